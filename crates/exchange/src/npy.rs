//! NumPy's `.npy`: one array of numbers behind a short text header.
//!
//! ```text
//! \x93NUMPY  1 0  length (u16; u32 from version 2)
//! {'descr': '<f4', 'fortran_order': False, 'shape': (512, 1024), }   padded with spaces, \n
//! the numbers, row-major
//! ```
//!
//! Read: arrays of integers of 1 to 8 bytes and of `f2 f4 f8`, in either byte order, row-major or
//! in Fortran order. Written: little-endian arrays of version 1.
//!
//! The crate `npyz` does the same, but it brings some twenty crates and a C compiler into the
//! build. The announced shape is compared with the length of the file before memory is taken.
//! Reference: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>

use crate::error::Problem;
use crate::scalar::Scalar;
use std::io::{self, Write};

const MAGIC: &[u8] = b"\x93NUMPY";

/// The header before an array's numbers.
#[derive(Debug)]
pub(crate) struct Header {
    pub(crate) shape: Vec<usize>,
    pub(crate) scalar: Scalar,
    pub(crate) big_endian: bool,
    /// Whether the first index runs fastest.
    pub(crate) fortran: bool,
    /// Length of the header in bytes; the numbers follow.
    pub(crate) length: usize,
}

impl Header {
    /// The header at the start of a file, of which `bytes` may be a part. Call
    /// [`Header::data_size`] before using its sizes: it compares them with the file.
    pub(crate) fn parse(bytes: &[u8]) -> Result<Self, Problem> {
        let (header, length) = split_header(bytes)?;
        let fortran = value_of(header, "fortran_order")?.starts_with("True");
        let (scalar, big_endian) = scalar(value_of(header, "descr")?)?;
        Ok(Self { shape: shape(value_of(header, "shape")?)?, scalar, big_endian, fortran, length })
    }

    /// The bytes of all numbers, if a file of that many bytes holds them.
    pub(crate) fn data_size(&self, file_size: usize) -> Result<usize, Problem> {
        let (shape, each) = (&self.shape, self.scalar.size());
        let follow = file_size.saturating_sub(self.length);
        let needed = shape.iter().try_fold(each, |product, &n| product.checked_mul(n));
        needed.filter(|&n| n <= follow).ok_or_else(|| {
            Problem::damaged(format!(
                "truncated: the header announces {shape:?} numbers of {each} bytes, \
                 {follow} bytes follow"
            ))
        })
    }
}

/// The note on a number of bytes after the last number of an array.
pub(crate) fn leftovers(bytes: usize) -> Option<String> {
    (bytes > 0).then(|| format!("{bytes} bytes after the last number ignored"))
}

/// An array still in its file's bytes.
pub(crate) struct Npy<'a> {
    header: Header,
    data: &'a [u8],
    /// Bytes after the last number.
    left: usize,
}

impl<'a> Npy<'a> {
    /// The array at the start of the bytes. [`Npy::leftovers`] tells of bytes behind its end, which
    /// NumPy ignores.
    pub(crate) fn parse(bytes: &'a [u8]) -> Result<Self, Problem> {
        let header = Header::parse(bytes)?;
        let needed = header.data_size(bytes.len())?;
        let data = bytes.get(header.length..).and_then(|d| d.get(..needed)).unwrap_or_default();
        let left = bytes.len() - header.length - data.len();
        Ok(Self { header, data, left })
    }

    /// The note on bytes after the last number, such as those of a second array.
    pub(crate) fn leftovers(&self) -> Option<String> {
        leftovers(self.left)
    }

    pub(crate) fn shape(&self) -> &[usize] {
        &self.header.shape
    }

    /// The numbers in row-major order.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> + '_ {
        let Header { scalar, big_endian, fortran, .. } = self.header;
        let size = scalar.size();
        (0..self.data.len() / size).map_while(move |n| {
            let n = if fortran { self.fortran_place(n) } else { n };
            scalar.read(self.data.get(n * size..)?, big_endian)
        })
    }

    /// The numbers of a row-major array of little-endian `f4`, which most images are, without the
    /// way over 64 bits; `None` for other arrays.
    pub(crate) fn singles(&self) -> Option<Vec<f32>> {
        let Header { scalar, big_endian, fortran, .. } = self.header;
        let is_plain = scalar == Scalar::F32 && !big_endian && !fortran;
        let numbers = || self.data.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
        is_plain.then(|| numbers().collect())
    }

    /// The numbers in threes.
    pub(crate) fn triples(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let mut numbers = self.numbers();
        std::iter::from_fn(move || Some([numbers.next()?, numbers.next()?, numbers.next()?]))
    }

    /// The place of a number of a row-major array in one of Fortran order.
    fn fortran_place(&self, row_major: usize) -> usize {
        let mut stride: usize = self.header.shape.iter().product();
        let (mut rest, mut place) = (row_major, 0);
        for &length in self.header.shape.iter().rev() {
            stride /= length.max(1);
            place += rest % length.max(1) * stride;
            rest /= length.max(1);
        }
        place
    }

    pub(crate) fn is_integer(&self) -> bool {
        self.header.scalar.is_integer()
    }
}

/// The types of numbers that are read.
const KNOWN: &str = "read are f2, f4, f8, i1 to i8 and u1 to u8";

/// The header's text, and where it ends.
fn split_header(bytes: &[u8]) -> Result<(&str, usize), Problem> {
    let not_npy = || Problem::damaged("not a .npy file");
    let cut = || Problem::damaged("truncated inside the header");
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(not_npy)?;
    let (version, rest) = rest.split_at_checked(2).ok_or_else(cut)?;
    let (length, rest) = match version.first() {
        Some(1) => {
            let (n, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (usize::from(u16::from_le_bytes(*n)), rest)
        }
        Some(2 | 3) => {
            let (n, rest) = rest.split_first_chunk().ok_or_else(cut)?;
            (u32::from_le_bytes(*n) as usize, rest)
        }
        _ => return Err(Problem::unsupported("a version of .npy other than 1, 2 and 3")),
    };
    let (header, data) = rest.split_at_checked(length).ok_or_else(cut)?;
    let header = std::str::from_utf8(header).map_err(|_| not_npy())?;
    Ok((header, bytes.len() - data.len()))
}

/// The text after `'key':` in the header.
fn value_of<'h>(header: &'h str, key: &str) -> Result<&'h str, Problem> {
    let quoted = [format!("'{key}':"), format!("\"{key}\":")];
    let found = quoted.iter().find_map(|q| header.split_once(q.as_str()));
    let missing = || Problem::damaged(format!("the header has no {key}"));
    found.map(|(_, after)| after.trim_start()).ok_or_else(missing)
}

fn scalar(value: &str) -> Result<(Scalar, bool), Problem> {
    let quote = value.chars().next().filter(|&c| c == '\'' || c == '"');
    let name = quote.and_then(|q| value.get(1..)?.split(q).next());
    let Some(name) = name else {
        return Err(Problem::unsupported(format!("an array of records; {KNOWN}")));
    };
    let big_endian = name.starts_with('>');
    let scalar = match name.trim_start_matches(['<', '>', '=', '|']) {
        "i1" => Scalar::I8,
        "u1" => Scalar::U8,
        "i2" => Scalar::I16,
        "u2" => Scalar::U16,
        "i4" => Scalar::I32,
        "u4" => Scalar::U32,
        "i8" => Scalar::I64,
        "u8" => Scalar::U64,
        "f2" => Scalar::F16,
        "f4" => Scalar::F32,
        "f8" => Scalar::F64,
        _ => return Err(Problem::unsupported(format!("numbers of type {name:?}; {KNOWN}"))),
    };
    Ok((scalar, big_endian))
}

fn shape(value: &str) -> Result<Vec<usize>, Problem> {
    let inside = value.strip_prefix('(').and_then(|v| v.split_once(')'));
    let bad = || Problem::damaged("the header's shape is not a tuple of whole numbers");
    let (inside, _) = inside.ok_or_else(bad)?;
    let sizes = inside.split(',').map(str::trim).filter(|s| !s.is_empty());
    sizes.map(|s| s.parse().map_err(|_| bad())).collect()
}

/// Writes the header of a little-endian array; its numbers follow.
pub(crate) fn write_header(out: &mut impl Write, descr: &str, shape: &[usize]) -> io::Result<()> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut header = format!(
        "{{'descr': '{descr}', 'fortran_order': False, 'shape': ({}), }}",
        if shape.len() == 1 { sizes.trim_end() } else { sizes.trim_end_matches(", ") }
    );
    // The format asks for data aligned to 64 bytes, and a line feed at the header's end.
    let before = MAGIC.len() + 4;
    let padded = (before + header.len() + 1).next_multiple_of(64);
    header.extend(std::iter::repeat_n(' ', padded - before - header.len() - 1));
    header.push('\n');
    let length = u16::try_from(header.len()).map_err(io::Error::other)?;
    out.write_all(MAGIC)?;
    out.write_all(&[1, 0])?;
    out.write_all(&length.to_le_bytes())?;
    out.write_all(header.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(descr: &str, shape: &[usize], data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        write_header(&mut bytes, descr, shape).unwrap();
        bytes.extend_from_slice(data);
        bytes
    }

    fn problem(bytes: &[u8]) -> String {
        match Npy::parse(bytes) {
            Ok(array) => panic!("accepted, shape {:?}", array.shape()),
            Err(problem) => problem.text,
        }
    }

    #[test]
    fn numbers_of_either_byte_order_come_back() {
        let little = npy("<f4", &[1, 2], &[1.5f32.to_le_bytes(), 2.0f32.to_le_bytes()].concat());
        assert_eq!(little.len() % 64, 8, "the data is aligned");
        let little_array = Npy::parse(&little).ok().unwrap();
        let array = &little_array;
        assert_eq!((array.shape(), array.numbers().collect()), (&[1, 2][..], vec![1.5, 2.0]));
        let big = npy(">i8", &[1], &(-7i64).to_be_bytes());
        let array = Npy::parse(&big).ok().unwrap();
        assert!(array.is_integer() && !little_array.is_integer());
        assert_eq!(array.numbers().collect::<Vec<_>>(), [-7.0]);
    }

    #[test]
    fn hostile_headers_are_refused_without_being_believed() {
        let huge = npy("<f4", &[usize::MAX, usize::MAX], &[0; 8]);
        assert!(
            problem(&huge).starts_with("truncated: the header announces"),
            "{}",
            problem(&huge)
        );
        let longer = npy("<f8", &[2, 2], &[0; 35]);
        let note = "3 bytes after the last number ignored";
        assert_eq!(Npy::parse(&longer).ok().unwrap().leftovers().as_deref(), Some(note));
        let short = npy("<f8", &[2, 2], &[0; 31]);
        assert!(problem(&short).contains("31 bytes follow"));
        assert_eq!(problem(b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}"), "truncated inside the header");
        assert_eq!(problem(b"P5 2 2 255"), "not a .npy file");
        let nested = npy(&"(".repeat(9000), &[1], &[]);
        assert!(problem(&nested).starts_with("numbers of type"));
    }

    /// Two rows of three cells, with two numbers each: 100 row + 10 column + index.
    #[test]
    fn fortran_order_is_read_as_row_major() {
        let text = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3, 2), }";
        let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
        bytes.extend((text.len() as u16).to_le_bytes());
        bytes.extend(text.bytes());
        bytes.extend([0, 100, 10, 110, 20, 120, 1, 101, 11, 111, 21, 121]);
        let array = Npy::parse(&bytes).ok().unwrap();
        let numbers: Vec<f64> = array.numbers().collect();
        assert_eq!(numbers, [0, 1, 10, 11, 20, 21, 100, 101, 110, 111, 120, 121].map(f64::from));
    }

    #[test]
    fn other_types_say_what_is_read() {
        assert!(problem(&npy("<c8", &[1], &[0; 8])).contains("read are f2, f4, f8"));
    }
}
