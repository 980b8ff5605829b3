//! The points of a guide curve, from the files in which surveyors keep alignments.
//!
//! | file | content |
//! |---|---|
//! | `.csv`, `.txt` | a point per line: `x,y,z`, also with `;` or spaces, and with decimal points; `#` begins a comment; a first line may name x, y and z |
//! | `.geojson`, `.json` | one `LineString`, alone, in a `Feature` or in a `FeatureCollection`; three coordinates each |
//! | `.dxf` | one `POLYLINE`, one `LWPOLYLINE` (at its elevation), or `LINE`s that touch at their ends, in any order; text, not binary |
//!
//! `LINE`s may be drawn in different directions. The guide has the direction in which most of its
//! length was drawn, with a note.
//!
//! Coordinates are in the model's unit and frame, so a GeoJSON of longitudes and latitudes cannot
//! be used. A drawing that states another unit (`$INSUNITS`) is refused. Arcs (bulges, `ARC`),
//! `SPLINE` and `ELLIPSE`, closed polylines and files with several curves are refused, because it
//! is unclear which guide they mean.

mod chain;
mod dxf;
mod geojson;
#[cfg(test)]
mod tests;

use crate::error::Problem;
use crate::input::{read_bytes, read_text};
use crate::{Place, ReadError};
use std::path::Path;
use transect_device::Note;
use transect_geometry::{CurvedGuide, GuideKind, LengthUnit, MAX_GUIDE_POINTS, Point3};

/// Largest file that is read, in bytes. Chosen by hand: a hundred times the size of a file with
/// [`MAX_GUIDE_POINTS`] points. Doubled, a wrong file may take twice the memory before it is
/// refused.
const MAX_FILE_SIZE: u64 = 64 << 20;

/// A point, and its place in the file.
#[derive(Clone)]
struct Placed {
    point: Point3,
    at: Place,
}

/// Reads a guide curve. Notes state what its file leaves unclear.
///
/// # Units
/// `unit`, the model's length unit.
///
/// # Errors
/// [`ReadError`] naming the line if a number is missing or not finite, or a point repeats the one
/// before it. Also if the file states another unit, or holds no curve, several curves, or a curve
/// that cannot be a guide.
pub fn read_guide(
    path: &Path,
    kind: GuideKind,
    unit: LengthUnit,
) -> Result<(CurvedGuide, Vec<Note>), ReadError> {
    let length = std::fs::metadata(path).map_err(|e| ReadError::io(path, e))?.len();
    if length > MAX_FILE_SIZE {
        let problem = format!("{length} bytes; a guide has at most {MAX_FILE_SIZE}");
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let points = match extension.as_deref() {
        Some("csv" | "txt") => rows(&read_text(path)?).map(|points| (points, None)),
        Some("geojson" | "json") => geojson::points(&read_text(path)?).map(|points| (points, None)),
        // Names may be in an encoding of their own; numbers are ASCII.
        Some("dxf") => dxf::points(&String::from_utf8_lossy(&read_bytes(path)?), unit),
        _ => {
            Err(Problem::damaged("the name of a guide ends in .csv, .txt, .geojson, .json or .dxf"))
        }
    };
    let read = points.and_then(|(points, note)| Ok((checked(&points)?, note)));
    let (points, note) = read.map_err(|p| p.in_file(path))?;
    let notes = note.into_iter().map(|text| Note::about(path.display(), text)).collect();
    let guide = CurvedGuide::new(kind, points);
    let guide = guide.map_err(|e| ReadError::unusable(path, Place::Whole, "guide", e))?;
    Ok((guide, notes))
}

/// The points, after a check that all are finite and none repeats the one before it.
fn checked(points: &[Placed]) -> Result<Vec<Point3>, Problem> {
    if points.len() > MAX_GUIDE_POINTS {
        let problem = format!("{} points; a guide has at most {MAX_GUIDE_POINTS}", points.len());
        return Err(Problem::damaged(problem));
    }
    let mut before = None;
    for Placed { point, at } in points {
        if !point.coords.iter().all(|c| c.is_finite()) {
            return Err(Problem::at(at.clone(), "a coordinate is not finite"));
        }
        if before == Some(point) {
            return Err(Problem::at(at.clone(), "the point repeats the one before it"));
        }
        before = Some(point);
    }
    Ok(points.iter().map(|placed| placed.point).collect())
}

/// Checks a line of names: those of x, y and z, in this order. Units may follow in brackets.
fn names_coordinates(line: &str, at: Place) -> Result<(), Problem> {
    let names = line.split([',', ';', ' ', '\t']).map(|name| name.trim_matches('"'));
    let names = names.filter(|name| !name.is_empty() && !name.starts_with(['[', '(']));
    let names: Vec<String> = names.map(str::to_lowercase).collect();
    let right = names.len() == 3 && names.iter().zip("xyz".chars()).all(|(n, c)| n.starts_with(c));
    if right {
        return Ok(());
    }
    let problem = format!(
        "{line:?} names no x, y and z in this order; bring the columns into this order, and name \
         them x,y,z or remove the line"
    );
    Err(Problem::at(at, problem))
}

/// The points of a table.
fn rows(text: &str) -> Result<Vec<Placed>, Problem> {
    let mut points = Vec::new();
    let mut header = false;
    for (number, line) in (1..).zip(text.lines()) {
        let content = line.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        let at = Place::Line(number);
        let fields = fields(content);
        let numbers: Result<Vec<f64>, _> = fields.iter().map(|field| field.parse()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, z]) => points.push(Placed { point: Point3::new(x, y, z), at }),
            Ok(other) => {
                let commas =
                    if other.len() == 6 { "; write decimal points, not commas" } else { "" };
                let problem = format!("{} numbers, not the three x, y and z{commas}", other.len());
                return Err(Problem::at(at, problem));
            }
            Err(_) if points.is_empty() && !header && !content.contains(char::is_numeric) => {
                names_coordinates(content, at)?;
                header = true;
            }
            Err(_) => {
                let commas = fields.iter().any(|field| field.contains(','));
                let commas = if commas { "; write decimal points, not commas" } else { "" };
                let problem = format!("{content:?} is not three numbers x, y and z{commas}");
                return Err(Problem::at(at, problem));
            }
        }
    }
    Ok(points)
}

/// The fields of a line: between semicolons, else between commas, else between spaces. A separator
/// may end the line; any other empty field stays, since it holds a place.
fn fields(line: &str) -> Vec<&str> {
    let separator = [';', ','].into_iter().find(|separator| line.contains(*separator));
    let Some(separator) = separator else { return line.split_whitespace().collect() };
    let line = line.strip_suffix(separator).unwrap_or(line);
    line.split(separator).map(str::trim).collect()
}
