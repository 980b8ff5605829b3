//! Reading PLY files: range grids of structured scans, point clouds, and triangle meshes.
//!
//! Text and binary files of either byte order. The header may hold comments, `obj_info` lines,
//! blank lines, CRLF line ends and unknown lines, which become notes. Announced numbers are
//! compared with the length of the file before memory is taken for them.
//!
//! PLY has no length unit. The caller must know the unit of the coordinates.
//! Reference: Greg Turk, *The PLY polygon file format* (1994), and the range scans of the Stanford
//! 3D Scanning Repository for the element `range_grid`.

mod body;
mod cloud;
mod header;
mod mesh;
mod range_grid;
#[cfg(test)]
mod tests;

pub(crate) use cloud::cloud;
pub(crate) use mesh::mesh;
pub use range_grid::{RangeGrid, read_range_grid};

use crate::input::without_mark;
use crate::{Place, ReadError};
use body::Body;
use header::{Element, Header, Kind};
use std::path::Path;
use transect_geometry::Point3;

/// A file whose header has been read, and whose numbers have not.
struct Ply<'a> {
    path: &'a Path,
    header: Header,
    body: Body<'a>,
}

impl<'a> Ply<'a> {
    fn open(path: &'a Path, bytes: &'a [u8]) -> Result<Self, ReadError> {
        let bytes = without_mark(bytes);
        let header = Header::parse(bytes).map_err(|p| p.in_file(path))?;
        let body = Body::new(bytes, header.length, header.encoding);
        Ok(Self { path, header, body })
    }

    /// The instances of an element, if the rest of the file can hold them.
    fn room_for(&self, element: &Element) -> Result<usize, ReadError> {
        let fewest = element.fewest_bytes(self.header.encoding).checked_mul(element.count);
        // The last number of a text file needs no separator.
        if fewest.is_some_and(|n| n <= self.body.remaining() + 1) {
            return Ok(element.count);
        }
        let problem = format!(
            "truncated: the header announces {} instances of element {}, but only {} bytes follow",
            element.count,
            element.name,
            self.body.remaining()
        );
        Err(ReadError::damaged(self.path, Place::Whole, problem))
    }

    /// Reads all instances of an element with `each`. An error names the instance.
    fn each_instance(
        &mut self,
        element: &Element,
        mut each: impl FnMut(&mut Body<'a>, usize) -> Result<(), String>,
    ) -> Result<(), ReadError> {
        self.room_for(element)?;
        for number in 0..element.count {
            each(&mut self.body, number).map_err(|problem| {
                let (kind, line) = (element.name.clone(), self.body.line());
                ReadError::damaged(self.path, Place::Element { kind, number, line }, problem)
            })?;
        }
        Ok(())
    }

    fn skip(&mut self, element: &Element) -> Result<(), ReadError> {
        self.each_instance(element, |body, _| {
            element.properties.iter().try_for_each(|p| body.skip(p))
        })
    }

    /// The properties x, y, z of an element. Other properties are skipped.
    fn points(&mut self, element: &Element) -> Result<Vec<Point3>, ReadError> {
        let mut points = Vec::with_capacity(self.room_for(element)?);
        self.numbers(element, ["x", "y", "z"], |point| {
            points.push(Point3::from(point));
            Ok(())
        })?;
        Ok(points)
    }

    /// Hands some scalar properties of every instance to `each`. Other properties are skipped.
    fn numbers<const N: usize>(
        &mut self,
        element: &Element,
        names: [&str; N],
        mut each: impl FnMut([f64; N]) -> Result<(), String>,
    ) -> Result<(), ReadError> {
        let Some(places) = places(element, names) else {
            let (name, wanted) = (&element.name, names.join(", "));
            let problem = format!("element {name} has no scalar properties {wanted}");
            return Err(ReadError::damaged(self.path, Place::Whole, problem));
        };
        self.each_instance(element, |body, _| {
            let mut numbers = [0.0; N];
            for (property, place) in element.properties.iter().zip(&places) {
                match (place.and_then(|at| numbers.get_mut(at)), property.kind) {
                    (Some(number), Kind::One(scalar)) => *number = body.number(scalar)?,
                    _ => body.skip(property)?,
                }
            }
            each(numbers)
        })
    }

    /// Hands the list `vertex_indices` of every instance to `each`. Other properties are skipped.
    fn vertex_lists(
        &mut self,
        element: &Element,
        mut each: impl FnMut(&[i64]) -> Result<(), String>,
    ) -> Result<(), ReadError> {
        let names = ["vertex_indices", "vertex_index"];
        let position = names.iter().find_map(|name| element.position(name));
        let kind = position.and_then(|at| element.properties.get(at)).map(|p| p.kind);
        let Some(Kind::List { count, item }) = kind else {
            let problem = format!("element {} has no list vertex_indices", element.name);
            return Err(ReadError::damaged(self.path, Place::Whole, problem));
        };
        let mut indices = Vec::new();
        self.each_instance(element, |body, _| {
            for (at, property) in element.properties.iter().enumerate() {
                if Some(at) != position {
                    body.skip(property)?;
                    continue;
                }
                indices.clear();
                for _ in 0..body.list_length(count, item)? {
                    indices.push(body.integer(item)?);
                }
                each(&indices)?;
            }
            Ok(())
        })
    }

    fn note_leftovers(&mut self) {
        if !self.body.is_spent() {
            let left = self.body.remaining();
            self.header.notes.push(format!("{left} bytes after the last element ignored"));
        }
    }
}

/// The place of each property of an element among the names; `None` unless all names are there.
fn places<const N: usize>(element: &Element, names: [&str; N]) -> Option<Vec<Option<usize>>> {
    let mut places = vec![None; element.properties.len()];
    for (at, name) in names.into_iter().enumerate() {
        *places.get_mut(element.position(name)?)? = Some(at);
    }
    Some(places)
}
