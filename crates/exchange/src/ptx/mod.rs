//! PTX files: gridded scans as text, the exchange format of many terrestrial scanners' programs.
//!
//! ```text
//! 345                          columns
//! 1074                         rows
//! 10.2 4.1 1.7                 the scanner in the world
//! 1 0 0                        its x axis; the lines of its y and z axes follow
//! 1 0 0 0                      4 × 4 matrix with the translation in its 4th line:
//! ...                          world = (x y z 1) · matrix
//! 1.25 -0.3 0.8 0.5            one point per line, column by column: x y z, an intensity,
//! 0 0 0 0.5                    and red, green, blue if there are colours; 0 0 0: no return
//! ```
//!
//! The next scan follows without a mark. [`open`] goes through the file once and keeps the place of
//! each scan. A view reads its own lines. The format has no unit; its numbers are metres by
//! convention.

mod counts;
mod header;
mod lines;

use crate::scan::{FramedImage, LoadView};
use crate::{OpenOptions, Place, ReadError, Scan, ScanView, points, survey};
use header::Header;
use lines::{Lines, Position};
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::{ImageSize, Note};
use transect_geometry::Point3;

/// Fewest bytes of a point: `0 0 0` and a line feed.
const LEAST_BYTES: u64 = 6;

/// Largest distance between two statements of a place that is rounding of printed digits, in the
/// file's unit: 1 mm in metres. Chosen by hand; between 1e-4 and 1e-2 nothing changes.
const PLACE_ROUNDING: f64 = 1e-3;
/// The same as a share of the largest coordinate. Theory: coordinates in `f32` are off by up to
/// 6e-8 of their size, and two statements of one place by twice that along each axis. Doubled, no
/// note tells of places in a national grid that differ by 2 m.
const SINGLE_ROUNDING: f64 = 2e-7;

/// The scans of a file.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let mut notes = Vec::new();
    let unit = points::unit_or_metres(path, options, &mut notes);
    let mut lines = Lines::open(path)?;
    let (mut views, mut left_out, mut before) = (Vec::new(), Vec::new(), None);
    while lines.skip_blank()? {
        let number = views.len() + left_out.len();
        let (at, line) = (Place::View { number, name: name(number) }, lines.number());
        let header = Header::read(&mut lines, &at)
            .map_err(|error| wrong_counts(path, before).unwrap_or(error))?;
        let start = lines.position();
        before = Some((line, header.size, start));
        skip_points(&mut lines, &header, line)?;
        if header.size.rows < 2 || header.size.cols < 2 {
            left_out.push(format!("scan {number} (line {line}) has {}", header.size));
            continue;
        }
        let about = format!("{}{at}", path.display());
        notes.extend(header.notes.iter().map(|text| Note::about(&about, text)));
        let pose = header.world_from_sensor;
        let view = PtxView { path: path.to_owned(), at, line, header, start };
        views.push(ScanView::new(name(number), path.to_owned(), pose, Arc::new(view)));
    }
    settle(path, &views, &left_out, &mut notes)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let inputs = vec![path.to_owned()];
    Ok(Scan { name, unit, sigma: None, planes: None, views, notes, inputs })
}

/// PTX names no scan.
fn name(number: usize) -> String {
    format!("scan {number}")
}

/// Notes the scans without neighbouring pixels, or refuses a file that has no other.
fn settle(
    path: &Path,
    views: &[ScanView],
    left_out: &[String],
    notes: &mut Vec<Note>,
) -> Result<(), ReadError> {
    let reason = "a scan needs 2 rows and 2 columns; export the setups in full";
    match (views, left_out) {
        ([], []) => Err(ReadError::damaged(path, Place::Whole, "the file holds no scan")),
        ([], _) => {
            let problem = format!("{}; {reason}", left_out.join("; "));
            Err(ReadError::unsupported(path, Place::Whole, problem))
        }
        (_, []) => Ok(()),
        _ => {
            let text = format!("left out: {}; {reason}", left_out.join("; "));
            notes.push(Note::about(path.display(), text));
            Ok(())
        }
    }
}

/// Goes to the end of a scan, which began at `line`.
fn skip_points(lines: &mut Lines, header: &Header, line: usize) -> Result<(), ReadError> {
    let (size, left) = (header.size, lines.bytes_left());
    let announced = size.rows.saturating_mul(size.cols);
    // The last line of a file need not end in a line feed.
    let needed = (announced as u64).saturating_mul(LEAST_BYTES).saturating_sub(1);
    let found = if needed > left { None } else { Some(lines.skip(announced)?) };
    if found == Some(announced) {
        return Ok(());
    }
    let found = found.map_or_else(|| format!("{left} bytes"), |n| format!("{n} lines"));
    let problem = format!(
        "the scan announces {size}, but {found} follow; the file is cut off, or another line is \
         missing; export it again"
    );
    Err(ReadError::damaged(lines.path(), Place::Line(line), problem))
}

/// The error of a scan, which began at a line, if its counts are not those of its points. What is
/// read as the next scan begins in the wrong place then.
fn wrong_counts(path: &Path, before: Option<(usize, ImageSize, Position)>) -> Option<ReadError> {
    let (line, size, start) = before?;
    let mut lines = Lines::at(path, start).ok()?;
    let mut points = 0;
    while lines.words().ok()? > 1 {
        points += 1;
    }
    if points == size.pixels() {
        return None;
    }
    let problem = format!(
        "the scan announces {size}, which are {} points, but {points} lines of points follow; \
         correct this line and the next one, or export the scan again",
        size.pixels()
    );
    Some(ReadError::damaged(path, Place::Line(line), problem))
}

/// One scan of a file.
#[derive(Debug)]
struct PtxView {
    path: PathBuf,
    at: Place,
    /// The line with the number of columns; that of rows follows.
    line: usize,
    header: Header,
    /// The first line of its points.
    start: Position,
}

impl LoadView for PtxView {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let points = self.points()?;
        let Header { size, scanner, .. } = self.header;
        self.check_counts(&points)?;
        let framed = survey::framed(&self.path, &self.at, size, points, Some(scanner), notes)?;
        notes.extend(self.other_place(&framed));
        Ok(framed)
    }

    fn place(&self) -> Place {
        self.at.clone()
    }
}

impl PtxView {
    /// A note if the header states two places of the scanner, and the points are seen from that of
    /// the matrix. [`survey::framed`] notes points that are seen from another place.
    fn other_place(&self, framed: &FramedImage) -> Option<String> {
        let Header { size, scanner, world_from_sensor, .. } = &self.header;
        let ray = size.all_pixels().find_map(|pixel| framed.frame.ray(pixel))?;
        let used = world_from_sensor * Point3::origin();
        let stated = world_from_sensor * scanner;
        let largest = used.coords.amax().max(stated.coords.amax());
        let rounding = PLACE_ROUNDING.max(SINGLE_ROUNDING * largest);
        if ray.start != Point3::origin() || (stated - used).norm() <= rounding {
            return None;
        }
        let words = |p: Point3| format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z);
        Some(format!(
            "the third line of the header states the scanner at {}, but the matrix places it at \
             {}; the matrix is used, because the points are seen from its origin; if the matrix is \
             wrong, export the scan again",
            words(stated),
            words(used)
        ))
    }

    /// Refuses counts of columns and rows that the row-major points contradict.
    fn check_counts(&self, points: &[Point3]) -> Result<(), ReadError> {
        let Header { size, scanner, .. } = self.header;
        let in_file = |k: usize| points.get(k % size.rows * size.cols + k / size.rows).copied();
        let valid = |k: usize| in_file(k).filter(|point| *point != Point3::origin());
        let seen_from = |place: &Point3| counts::other_counts(size, place, valid);
        // Points in the world's frame are seen from the stated place.
        let found = seen_from(&Point3::origin());
        let found = found.filter(|found| seen_from(&scanner) == Some(*found));
        let Some(found) = found else { return Ok(()) };
        let problem = format!(
            "{}: the lines state {} columns and {} rows, but the points turn back after every {} \
             points, where a column ends; expected {} columns and {} rows; correct this line and \
             the next one, or export the scan again",
            self.at.words(),
            size.cols,
            size.rows,
            found.rows,
            found.cols,
            found.rows
        );
        Err(ReadError::damaged(&self.path, Place::Line(self.line), problem))
    }

    /// The scan's points, row by row.
    fn points(&self) -> Result<Vec<Point3>, ReadError> {
        let ImageSize { rows, cols } = self.header.size;
        let mut lines = Lines::at(&self.path, self.start)?;
        let mut points = vec![Point3::origin(); rows * cols];
        for col in 0..cols {
            for row in 0..rows {
                let point = read_point(&mut lines, &self.at, &self.header.scale)?;
                if let Some(place) = points.get_mut(row * cols + col) {
                    *place = point;
                }
            }
        }
        Ok(points)
    }
}

fn read_point(lines: &mut Lines, at: &Place, scale: &Vector3<f64>) -> Result<Point3, ReadError> {
    let wanted = "a point: x y z, then an intensity, then red, green and blue";
    let [x, y, z] = lines.numbers(at, wanted, 3..=7)?;
    Ok(Point3::from(Vector3::new(x, y, z).component_mul(scale)))
}

#[cfg(test)]
mod tests;
