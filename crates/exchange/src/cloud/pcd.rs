//! PCD files, version 0.5 to 0.7: text, binary, and binary compressed by LZF.
//!
//! Reference: *The PCD file format*, Point Cloud Library. Numbers are little-endian. Compressed
//! files hold all values of the first field, then all of the second. HEIGHT above 1 means rows and
//! columns. `VIEWPOINT tx ty tz qw qx qy qz` is the pose of the sensor: `pcl_viewer` and
//! `pcl_transform_from_viewpoint` take it as world-from-sensor, and so does this reader.

use super::lzf;
use crate::Place;
use crate::error::Problem;
use crate::point_table::{Cloud, is_ring_name, ring};
use crate::pose::from_unit_quaternion;
use crate::scalar::Scalar;
use nalgebra::Quaternion;
use transect_device::{ImageSize, MAX_PIXELS};
use transect_geometry::{Isometry3, Point3};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Text,
    Binary,
    Compressed,
}

/// A column of the table of points.
#[derive(Debug, Clone)]
struct Field {
    name: String,
    scalar: Scalar,
    count: usize,
    /// Bytes before the field in a record.
    offset: usize,
    /// Words before the field in a line.
    word: usize,
}

impl Field {
    fn bytes(&self) -> usize {
        self.scalar.size().saturating_mul(self.count)
    }

    /// The field, if it holds one number: the reader takes the first one.
    fn single(&self) -> Result<&Self, Problem> {
        if self.count == 1 {
            return Ok(self);
        }
        let (name, count) = (&self.name, self.count);
        let problem = format!("field {name} has COUNT {count}; expected 1 number for each point");
        Err(Problem::damaged(problem))
    }
}

/// The text at the head of a file.
#[derive(Debug)]
pub(super) struct Header {
    fields: Vec<Field>,
    size: ImageSize,
    /// Pose of the sensor in the world, if it is stated and not the identity.
    pub(super) viewpoint: Option<Isometry3>,
    encoding: Encoding,
    /// Lines of the header, and its bytes; the points follow.
    lines: usize,
    length: usize,
}

impl Header {
    /// Parses everything up to the line DATA.
    pub(super) fn parse(bytes: &[u8]) -> Result<Self, Problem> {
        let mut entries: Vec<(usize, Vec<String>)> = Vec::new();
        let mut length = 0;
        for (number, line) in (1..).zip(bytes.split_inclusive(|b| *b == b'\n')) {
            length += line.len();
            let text = String::from_utf8_lossy(line);
            let words: Vec<String> = text.split_whitespace().map(str::to_owned).collect();
            let is_last = words.first().is_some_and(|w| w == "DATA");
            let is_comment = words.first().is_none_or(|w| w.starts_with('#'));
            if !is_comment {
                entries.push((number, words));
            }
            if is_last {
                return Entries(entries).header(number, length);
            }
            if number > 100 {
                break;
            }
        }
        let problem = "no line DATA within the first 100 lines; expected the header of a PCD file";
        Err(Problem::damaged(problem))
    }

    fn words(&self) -> usize {
        self.fields.iter().map(|f| f.count).sum()
    }

    fn record(&self) -> usize {
        self.fields.iter().map(Field::bytes).sum()
    }

    fn field(&self, name: &str) -> Result<&Field, Problem> {
        let found = self.fields.iter().find(|f| f.name == name);
        let missing = || Problem::damaged(format!("FIELDS has no {name}; expected x, y and z"));
        found.ok_or_else(missing)?.single()
    }
}

/// The lines of a header by their first words.
struct Entries(Vec<(usize, Vec<String>)>);

impl Entries {
    fn find(&self, name: &str) -> Option<(usize, &[String])> {
        let entry = self.0.iter().find(|(_, words)| words.first().is_some_and(|w| w == name))?;
        Some((entry.0, entry.1.get(1..)?))
    }

    /// The numbers of a line; `None` without the line.
    fn numbers<T: std::str::FromStr>(&self, name: &str) -> Result<Option<Vec<T>>, Problem> {
        let Some((line, words)) = self.find(name) else { return Ok(None) };
        let parse = |word: &String| {
            let problem = || {
                Problem::at(
                    Place::Line(line),
                    format!("{name}: {word:?} is no number of the expected kind"),
                )
            };
            word.parse().map_err(|_| problem())
        };
        words.iter().map(parse).collect::<Result<_, _>>().map(Some)
    }

    fn number(&self, name: &str) -> Result<Option<usize>, Problem> {
        Ok(self.numbers(name)?.and_then(|n| n.first().copied()))
    }

    fn header(&self, lines: usize, length: usize) -> Result<Header, Problem> {
        let damaged = |problem: String| Problem::at(Place::Line(lines), problem);
        let at = |name: &str, problem: String| {
            Problem::at(Place::Line(self.find(name).map_or(lines, |(line, _)| line)), problem)
        };
        let fields = self.fields()?;
        let missing = |name: &str| damaged(format!("the header has no line {name}"));
        let cols = self.number("WIDTH")?.ok_or_else(|| missing("WIDTH"))?;
        let rows = self.number("HEIGHT")?.unwrap_or(1);
        let points = rows.checked_mul(cols).filter(|n| *n > 0 && *n <= MAX_PIXELS);
        let no_size = || {
            let problem = format!(
                "WIDTH {cols} × HEIGHT {rows} is empty or absurd; expected 1 to {MAX_PIXELS} points"
            );
            at("WIDTH", problem)
        };
        let points = points.ok_or_else(no_size)?;
        if let Some(stated) = self.number("POINTS")?.filter(|n| *n != points) {
            let text = format!("POINTS is {stated}, but WIDTH {cols} × HEIGHT {rows} is {points}");
            return Err(at("POINTS", text));
        }
        let encoding = match self.find("DATA").and_then(|(_, words)| words.first()) {
            Some(word) if word == "ascii" => Encoding::Text,
            Some(word) if word == "binary" => Encoding::Binary,
            Some(word) if word == "binary_compressed" => Encoding::Compressed,
            other => {
                let found = other.map_or("", String::as_str);
                let wanted = "expected ascii, binary or binary_compressed";
                return Err(damaged(format!("DATA is {found:?}; {wanted}")));
            }
        };
        let size = ImageSize { rows, cols };
        Ok(Header { fields, size, viewpoint: self.viewpoint()?, encoding, lines, length })
    }

    fn fields(&self) -> Result<Vec<Field>, Problem> {
        // Version 0.5 has COLUMNS in place of FIELDS.
        let names = self.find("FIELDS").or_else(|| self.find("COLUMNS"));
        let (line, names) =
            names.ok_or_else(|| Problem::damaged("the header has no line FIELDS"))?;
        let all = || std::iter::repeat_n((), names.len());
        let sizes = self.numbers("SIZE")?.unwrap_or_else(|| all().map(|()| 4).collect());
        let counts = self.numbers("COUNT")?.unwrap_or_else(|| all().map(|()| 1).collect());
        let kinds = self.find("TYPE").map(|(_, words)| words.to_vec());
        let kinds = kinds.unwrap_or_else(|| all().map(|()| "F".to_owned()).collect());
        if [sizes.len(), counts.len(), kinds.len()] != [names.len(); 3] {
            let problem = format!(
                "FIELDS has {} names, SIZE {}, TYPE {} and COUNT {} values; expected one each",
                names.len(),
                sizes.len(),
                kinds.len(),
                counts.len()
            );
            return Err(Problem::at(Place::Line(line), problem));
        }
        let (mut fields, mut offset, mut word) = (Vec::new(), 0_usize, 0_usize);
        for (((name, size), count), kind) in names.iter().zip(sizes).zip(counts).zip(kinds) {
            let scalar = scalar(&kind, size).filter(|_| count <= MAX_PIXELS).ok_or_else(|| {
                let problem = format!("field {name} has TYPE {kind}, SIZE {size}, COUNT {count}");
                Problem::at(Place::Line(line), problem + "; expected I, U or F of 1 to 8 bytes")
            })?;
            let field = Field { name: name.clone(), scalar, count, offset, word };
            offset = offset.saturating_add(field.bytes());
            word = word.saturating_add(count);
            fields.push(field);
        }
        Ok(fields)
    }

    fn viewpoint(&self) -> Result<Option<Isometry3>, Problem> {
        let Some(numbers) = self.numbers::<f64>("VIEWPOINT")? else { return Ok(None) };
        let line = Place::Line(self.find("VIEWPOINT").map_or(0, |(line, _)| line));
        let problem = |text: &str| Problem::at(line.clone(), format!("VIEWPOINT {text}"));
        let &[x, y, z, w, i, j, k] = numbers.as_slice() else {
            return Err(problem("needs 7 numbers: tx ty tz qw qx qy qz"));
        };
        let pose = from_unit_quaternion([x, y, z], Quaternion::new(w, i, j, k))
            .map_err(|why| problem(&format!("is no pose: {why}")))?;
        Ok((numbers != [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]).then_some(pose))
    }
}

fn scalar(kind: &str, size: usize) -> Option<Scalar> {
    Some(match (kind, size) {
        ("I", 1) => Scalar::I8,
        ("I", 2) => Scalar::I16,
        ("I", 4) => Scalar::I32,
        ("I", 8) => Scalar::I64,
        ("U", 1) => Scalar::U8,
        ("U", 2) => Scalar::U16,
        ("U", 4) => Scalar::U32,
        ("U", 8) => Scalar::U64,
        ("F", 4) => Scalar::F32,
        ("F", 8) => Scalar::F64,
        _ => return None,
    })
}

/// Reads all points, with their rows and columns and their rings if the file has them.
pub(super) fn read(bytes: &[u8]) -> Result<Cloud, Problem> {
    let header = Header::parse(bytes)?;
    let body = bytes.get(header.length..).unwrap_or_default();
    let (unpacked, behind) = match header.encoding {
        Encoding::Compressed => {
            let (unpacked, behind) = decompressed(&header, body)?;
            (Some(unpacked), behind)
        }
        _ => (None, 0),
    };
    let body = unpacked.as_deref().unwrap_or(body);
    let axes = [header.field("x")?, header.field("y")?, header.field("z")?];
    let ring_field = header.fields.iter().find(|f| is_ring_name(&f.name));
    let ring_field = ring_field.map(Field::single).transpose()?;
    // Fewest bytes of a point: in a text, a digit and a separator for each word.
    let least =
        if header.encoding == Encoding::Text { 2 * header.words() } else { header.record() };
    let most = header.size.pixels().min(body.len() / least.max(1));
    let points = Vec::with_capacity(most);
    let rings = ring_field.map(|_| Vec::with_capacity(most));
    let mut cloud = Cloud { points, rings, ..Cloud::default() };
    let mut add = |number: usize, line, value: &dyn Fn(&Field) -> Result<f64, String>| {
        let mut one = || {
            let [x, y, z] = axes.map(value);
            cloud.points.push(Point3::new(x?, y?, z?));
            if let (Some(field), Some(rings)) = (ring_field, &mut cloud.rings) {
                rings.push(ring(value(field)?)?);
            }
            Ok(())
        };
        let at = || Place::Element { kind: "point".to_owned(), number, line };
        one().map_err(|problem: String| Problem::at(at(), problem))
    };
    let (left, what) = match header.encoding {
        Encoding::Text => (read_text(&header, body, &mut add)?, "lines"),
        Encoding::Binary | Encoding::Compressed => {
            (read_binary(&header, body, &mut add)? + behind, "bytes")
        }
    };
    if left > 0 {
        cloud.notes.push(format!("{left} {what} after the last point ignored"));
    }
    cloud.size = (header.size.rows > 1).then_some(header.size);
    Ok(cloud)
}

/// Takes a point's number, its line, and the values of its fields.
type Add<'a> = dyn FnMut(usize, Option<usize>, &dyn Fn(&Field) -> Result<f64, String>) -> Result<(), Problem>
    + 'a;

/// Takes the points of a text. Returns the number of lines after the last one.
fn read_text(header: &Header, body: &[u8], add: &mut Add<'_>) -> Result<usize, Problem> {
    let is_full = |line: &&[u8]| !line.trim_ascii().is_empty();
    let lines = (header.lines + 1..).zip(body.split(|b| *b == b'\n'));
    let mut lines = lines.filter(|(_, line)| is_full(line));
    let mut words: Vec<&[u8]> = Vec::new();
    for number in 0..header.size.pixels() {
        let (line, text) = lines.next().ok_or_else(|| truncated(header, number))?;
        words.clear();
        let split = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        words.extend(split);
        if words.len() != header.words() {
            let (found, wanted) = (words.len(), header.words());
            let problem = format!("the line has {found} numbers; FIELDS and COUNT need {wanted}");
            return Err(Problem::at(Place::Line(line), problem));
        }
        add(number, Some(line), &|field| {
            let word = words.get(field.word).copied().unwrap_or_default();
            let number = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
            let start = || String::from_utf8_lossy(word).chars().take(20).collect::<String>();
            number.ok_or_else(|| format!("field {}: {:?} is no number", field.name, start()))
        })?;
    }
    Ok(lines.count())
}

/// Takes the points of bytes. Returns the number of bytes after the last one.
fn read_binary(header: &Header, body: &[u8], add: &mut Add<'_>) -> Result<usize, Problem> {
    let (points, record) = (header.size.pixels(), header.record());
    let left = record.checked_mul(points).and_then(|needed| body.len().checked_sub(needed));
    // A record without a byte could announce any number of points.
    let left = left.filter(|_| record > 0);
    let left = left.ok_or_else(|| truncated(header, body.len() / record.max(1)))?;
    for number in 0..points {
        add(number, None, &|field| {
            let at = match header.encoding {
                Encoding::Compressed => field.offset * points + number * field.bytes(),
                _ => number * record + field.offset,
            };
            let value = field.scalar.read(body.get(at..).unwrap_or_default(), false);
            value.ok_or_else(|| "truncated: the file ends here".to_owned())
        })?;
    }
    Ok(left)
}

fn truncated(header: &Header, found: usize) -> Problem {
    let points = header.size.pixels();
    let problem = format!("truncated: the header announces {points} points, the file has {found}");
    Problem::damaged(problem)
}

/// The points of a compressed file, and the number of bytes after them.
fn decompressed(header: &Header, body: &[u8]) -> Result<(Vec<u8>, usize), Problem> {
    let lengths = body.first_chunk::<4>().zip(body.get(4..).and_then(|b| b.first_chunk::<4>()));
    let (packed, length) = lengths.ok_or_else(|| truncated(header, 0))?;
    let (packed, length) = (u32::from_le_bytes(*packed), u32::from_le_bytes(*length));
    let data = body.get(8..).and_then(|b| b.get(..packed as usize));
    let data = data.ok_or_else(|| {
        let found = body.len().saturating_sub(8);
        Problem::damaged(format!(
            "truncated: the file announces {packed} compressed bytes and has {found}"
        ))
    })?;
    let points = lzf::decompress(data, length as usize).map_err(Problem::damaged)?;
    Ok((points, body.len() - 8 - data.len()))
}
