//! The text at the head of every PLY file.

use crate::Place;
use crate::error::Problem;
use crate::scalar::Scalar;

/// The encoding of the numbers after the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a name. Only binary files depend on it.
fn scalar(name: &str) -> Option<Scalar> {
    Some(match name {
        "char" | "int8" => Scalar::I8,
        "uchar" | "uint8" => Scalar::U8,
        "short" | "int16" => Scalar::I16,
        "ushort" | "uint16" => Scalar::U16,
        "int" | "int32" => Scalar::I32,
        "uint" | "uint32" => Scalar::U32,
        "float" | "float32" => Scalar::F32,
        "double" | "float64" => Scalar::F64,
        _ => return None,
    })
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    One(Scalar),
    List { count: Scalar, item: Scalar },
}

#[derive(Debug, Clone)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: usize,
    pub(super) properties: Vec<Property>,
}

impl Element {
    pub(super) fn position(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }

    /// The fewest bytes of one instance. In text, a number takes a digit and a separator.
    pub(super) fn fewest_bytes(&self, encoding: Encoding) -> usize {
        let fewest = |p: &Property| match (encoding, p.kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::One(scalar) | Kind::List { count: scalar, .. }) => scalar.size(),
        };
        self.properties.iter().map(fewest).sum()
    }
}

#[derive(Debug, Clone)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Words after `obj_info`.
    infos: Vec<(String, String)>,
    pub(super) notes: Vec<String>,
    /// Length of the header in bytes; the numbers follow.
    pub(super) length: usize,
}

impl Header {
    /// Parses everything up to `end_header`.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Problem> {
        let mut builder = Builder::default();
        let (mut at, mut line) = (0, 0);
        while let Some(rest) = bytes.get(at..).filter(|r| !r.is_empty()) {
            line += 1;
            let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            let text = String::from_utf8_lossy(rest.get(..end).unwrap_or(rest));
            at += end + 1;
            if line == 1 {
                require_magic(text.trim_end())?;
                continue;
            }
            if text.trim() == "end_header" {
                return builder.finish(line, at.min(bytes.len()));
            }
            builder.line(line, text.trim()).map_err(|text| problem(line, text))?;
        }
        Err(problem(line.max(1), "truncated: there is no end_header"))
    }

    /// A whole number given as `obj_info name number`.
    pub(super) fn info(&self, name: &str) -> Option<usize> {
        let (_, value) = self.infos.iter().find(|(n, _)| n == name)?;
        value.parse().ok()
    }

    pub(super) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }
}

fn problem(line: usize, text: impl Into<String>) -> Problem {
    Problem::at(Place::Line(line), text)
}

fn require_magic(text: &str) -> Result<(), Problem> {
    if text == "ply" { Ok(()) } else { Err(problem(1, "not a PLY file")) }
}

#[derive(Default)]
struct Builder {
    encoding: Option<Encoding>,
    elements: Vec<Element>,
    infos: Vec<(String, String)>,
    /// The first unknown line, and the number of them.
    stray: Option<(usize, String)>,
    stray_count: usize,
}

impl Builder {
    fn line(&mut self, line: usize, text: &str) -> Result<(), String> {
        let mut words = text.split_ascii_whitespace();
        match words.next() {
            Some("format") => self.encoding = Some(encoding(words.next())?),
            Some("comment") => {}
            Some("obj_info") => {
                let name = words.next().unwrap_or_default().to_owned();
                self.infos.push((name, words.collect::<Vec<_>>().join(" ")));
            }
            Some("element") => self.elements.push(element(text, words)?),
            Some("property") => {
                let property = property(text, words)?;
                let element = self.elements.last_mut();
                element.ok_or("a property before any element")?.properties.push(property);
            }
            Some(_) => {
                self.stray_count += 1;
                self.stray.get_or_insert_with(|| (line, text.chars().take(40).collect()));
            }
            None => {}
        }
        Ok(())
    }

    fn finish(self, line: usize, length: usize) -> Result<Header, Problem> {
        let missing = || problem(line, "the header has no format line");
        let encoding = self.encoding.ok_or_else(missing)?;
        if let Some(empty) = self.elements.iter().find(|e| e.properties.is_empty()) {
            return Err(problem(line, format!("element {} has no properties", empty.name)));
        }
        let count = self.stray_count;
        let note = |(line, text)| {
            format!("line {line}: unknown header line {text:?} ignored, one of {count}")
        };
        let notes = self.stray.map(note).into_iter().collect();
        let Self { elements, infos, .. } = self;
        Ok(Header { encoding, elements, infos, notes, length })
    }
}

fn encoding(word: Option<&str>) -> Result<Encoding, String> {
    match word {
        Some("ascii") => Ok(Encoding::Ascii),
        Some("binary_little_endian") => Ok(Encoding::LittleEndian),
        Some("binary_big_endian") => Ok(Encoding::BigEndian),
        other => Err(format!("unknown format {:?}", other.unwrap_or_default())),
    }
}

fn element<'a>(text: &str, mut words: impl Iterator<Item = &'a str>) -> Result<Element, String> {
    let parsed = words.next().zip(words.next().and_then(|w| w.parse().ok()));
    let (name, count) = parsed.ok_or_else(|| format!("{text:?} is not \"element NAME COUNT\""))?;
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

fn property<'a>(text: &str, mut words: impl Iterator<Item = &'a str>) -> Result<Property, String> {
    let kind = words.next().and_then(|word| match word {
        "list" => {
            let (count, item) = words.next().zip(words.next())?;
            Some(Kind::List { count: scalar(count)?, item: scalar(item)? })
        }
        one => scalar(one).map(Kind::One),
    });
    let parsed = kind.zip(words.next());
    let (kind, name) = parsed.ok_or_else(|| format!("{text:?} is not a property this reads"))?;
    Ok(Property { name: name.to_owned(), kind })
}
