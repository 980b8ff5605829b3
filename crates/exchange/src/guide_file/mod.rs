//! The points of a guide curve, from the files in which surveyors keep alignments.
//!
//! | file | what is read |
//! |---|---|
//! | `.csv`, `.txt` | a point per line: `x,y,z`, also with `;` or spaces between; `#` begins a comment; one header line |
//! | `.geojson`, `.json` | one `LineString`, alone, in a `Feature` or in a `FeatureCollection`; three coordinates each |
//! | `.dxf` | one `POLYLINE`, one `LWPOLYLINE` (at its elevation), or `LINE`s that follow each other; text, not binary |
//!
//! Coordinates are in the model's unit and frame; a GeoJSON of longitudes and latitudes is none. Arcs
//! (bulges), closed polylines and files with several curves are refused: what they mean as a guide is
//! for their author to say.

mod dxf;
mod geojson;

use crate::error::read_text;
use crate::{Place, ReadError};
use std::path::Path;
use transect_geometry::{CurvedGuide, GuideKind, MAX_GUIDE_POINTS, Point3};

/// Largest file that is read, in bytes: a hundred times what the most points take.
const LARGEST: u64 = 64 << 20;

/// A point and where in the file it is.
type Placed = (Point3, Place);

/// Reads a guide curve.
///
/// # Units
/// The model's length unit.
///
/// # Errors
/// [`ReadError`] naming the line where a number is missing or not finite, or a point repeats the one before
/// it; or saying that the file holds no curve, several, or one that is no guide.
pub fn read_guide(path: &Path, kind: GuideKind) -> Result<CurvedGuide, ReadError> {
    let length = std::fs::metadata(path).map(|m| m.len());
    let length = length.map_err(|e| ReadError::io(path, e))?;
    if length > LARGEST {
        let problem = format!("{length} bytes; a guide has at most {LARGEST}");
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    let text = read_text(path)?;
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    let points = match extension.as_deref() {
        Some("csv" | "txt") => rows(&text),
        Some("geojson" | "json") => geojson::points(&text),
        Some("dxf") => dxf::points(&text),
        _ => {
            let problem = "the name of a guide ends in .csv, .txt, .geojson, .json or .dxf";
            return Err(ReadError::damaged(path, Place::Whole, problem));
        }
    };
    let points = points.and_then(|points| checked(&points));
    let points = points.map_err(|(at, problem)| ReadError::damaged(path, at, problem))?;
    CurvedGuide::new(kind, points).map_err(|e| ReadError::unusable(path, Place::Whole, "guide", e))
}

/// What is wrong, and where.
type Problem = (Place, String);

/// The points, all finite and none twice in a row.
fn checked(points: &[Placed]) -> Result<Vec<Point3>, Problem> {
    if points.len() > MAX_GUIDE_POINTS {
        let problem = format!("{} points; a guide has at most {MAX_GUIDE_POINTS}", points.len());
        return Err((Place::Whole, problem));
    }
    let mut before = None;
    for (point, at) in points {
        if !point.coords.iter().all(|c| c.is_finite()) {
            return Err((at.clone(), "a coordinate is not finite".to_owned()));
        }
        if before == Some(point) {
            return Err((at.clone(), "the point repeats the one before it".to_owned()));
        }
        before = Some(point);
    }
    Ok(points.iter().map(|(point, _)| *point).collect())
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
        let fields = content.split([',', ';', ' ', '\t']).filter(|field| !field.is_empty());
        let fields: Vec<&str> = fields.collect();
        let numbers: Result<Vec<f64>, _> = fields.iter().map(|f| f.parse::<f64>()).collect();
        match numbers.as_deref() {
            Ok(&[x, y, z]) => points.push((Point3::new(x, y, z), Place::Line(number))),
            Ok(other) => {
                let problem = format!("{} numbers, not the three x, y and z", other.len());
                return Err((Place::Line(number), problem));
            }
            Err(_) if points.is_empty() && !header => header = true,
            Err(_) => {
                let problem = format!("{content:?} is not three numbers x, y and z");
                return Err((Place::Line(number), problem));
            }
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests;
