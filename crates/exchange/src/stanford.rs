//! Stanford's scan configurations (`*.conf`): PLY range grids with their poses.
//!
//! ```text
//! camera ...                                  a viewer's camera; not used
//! bmesh bun045.ply  tx ty tz  qx qy qz qw     one scan; quaternion with the scalar last
//! ```
//!
//! The pose is world = R(q)ᵀ p + t, with R(q) the usual rotation matrix of q: the *conjugate*
//! quaternion rotates. Read the other way round, the ten scans of the bunny miss each other by
//! centimetres. The format carries no unit; by its convention the numbers are metres.

use crate::input::read_text;
use crate::ply::read_range_grid;
use crate::scan::{FramedImage, LoadView};
use crate::{OpenOptions, Place, ReadError, Scan, ScanView, points, pose};
use nalgebra::Quaternion;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::Note;

/// The configuration that a path is: a file `*.conf`, or the only one in a folder. `None` for a
/// folder that cannot be listed, which `Scan::open_with` states if no other format has it.
pub(crate) fn configuration(path: &Path) -> Option<PathBuf> {
    let is_one = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("conf"));
    if !path.is_dir() {
        return Some(path.to_owned()).filter(is_one);
    }
    let entries = std::fs::read_dir(path).ok()?.flatten().map(|entry| entry.path());
    let mut found = entries.filter(|path| is_one(path) && path.is_file());
    found.next().filter(|_| found.next().is_none())
}

/// The problem of a folder with several configurations; `None` with fewer.
pub(crate) fn several(folder: &Path) -> Option<String> {
    let is_configuration = |path: &PathBuf| {
        let is_conf = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("conf"));
        let lists_views =
            |text: &str| text.lines().any(|l| l.starts_with("bmesh ") || l.starts_with("mesh "));
        is_conf && read_text(path).is_ok_and(|text| lists_views(&text))
    };
    let entries = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let mut found: Vec<PathBuf> = entries.filter(is_configuration).collect();
    found.sort();
    let names: Vec<String> = found.iter().map(|path| path.display().to_string()).collect();
    (names.len() > 1).then(|| {
        format!(
            "the folder holds {} Stanford configurations, each of which is a scan; pass one of \
             them: {}",
            names.len(),
            names.join(", ")
        )
    })
}

pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let path = &configuration(path).unwrap_or_else(|| path.to_owned());
    let text = read_text(path)?;
    let (mut views, mut notes) = (Vec::new(), Vec::new());
    let unit = points::unit_or_metres(path, options, &mut notes);
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        match words.split_first() {
            Some((&("bmesh" | "mesh"), scan)) => views.push(view(path, number, scan, &mut notes)?),
            // A viewer's camera and comments do not concern the scan.
            None | Some((&"camera", _)) => {}
            Some((word, _)) if word.starts_with('#') => {}
            Some((word, _)) => {
                let start: String = word.chars().take(40).collect();
                let problem = format!(
                    "the line begins with {start:?}; expected \"bmesh\", \"mesh\", \"camera\" or \
                     \"#\"; correct the word, or make the line a comment"
                );
                return Err(ReadError::damaged(path, Place::Line(number), problem));
            }
        }
    }
    if views.is_empty() {
        return Err(ReadError::damaged(path, Place::Whole, "no line \"bmesh FILE ...\""));
    }
    let files = views.iter().map(|v: &ScanView| v.path().to_owned());
    let inputs = std::iter::once(path.to_owned()).chain(files).collect();
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Scan { name, unit, sigma: None, planes: None, views, notes, inputs })
}

fn view(
    path: &Path,
    line: usize,
    words: &[&str],
    notes: &mut Vec<Note>,
) -> Result<ScanView, ReadError> {
    let name = words.first().copied().unwrap_or("without a file").to_owned();
    let at = Place::ViewLine { line, name: name.clone() };
    let damaged = |problem: String| ReadError::damaged(path, at.clone(), problem);
    let numbers = words.iter().skip(1).map(|w| w.parse().ok());
    let numbers: Option<Vec<f64>> = numbers.collect();
    let Some(&[tx, ty, tz, qx, qy, qz, qw]) = numbers.as_deref() else {
        return Err(damaged("expected a file and 7 numbers: tx ty tz qx qy qz qw".to_owned()));
    };
    // The conjugate: see the module's page.
    let q = Quaternion::new(qw, qx, qy, qz).conjugate();
    let (world_from_sensor, note) = pose::from_quaternion([tx, ty, tz], q).map_err(damaged)?;
    notes.extend(note.map(|text| Note::about(format_args!("{}{at}", path.display()), text)));
    let file = path.parent().unwrap_or(Path::new("")).join(&name);
    let source = Arc::new(RangeGridView { path: file.clone() });
    Ok(ScanView::new(name, file, world_from_sensor, source))
}

/// A PLY range grid of a triangulation scanner that was carried along x.
#[derive(Debug)]
struct RangeGridView {
    path: PathBuf,
}

impl LoadView for RangeGridView {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let grid = read_range_grid(&self.path)?;
        notes.extend(grid.notes);
        points::framed_carried(&self.path, grid.size, grid.points, notes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_1_SQRT_2;
    use transect_geometry::{Isometry3, LengthUnit, Point3};

    fn open_text(text: &str) -> Result<Scan, ReadError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.conf");
        std::fs::write(folder.path().join("a.ply"), "ply").unwrap();
        std::fs::write(&path, text).unwrap();
        Scan::open(&path)
    }

    #[test]
    fn poses_rotate_by_the_conjugate_quaternion() {
        let h = FRAC_1_SQRT_2;
        let scan = open_text(&format!("camera 0 0 0 0 0 0 1\nbmesh a.ply 1 2 3 0 0 {h} {h}\n"));
        let scan = scan.unwrap();
        // R(q) turns x into y, so its transpose turns y into x.
        let turned = scan.views[0].world_from_sensor() * Point3::new(0.0, 1.0, 0.0);
        assert!((turned - Point3::new(2.0, 2.0, 3.0)).norm() < 1e-12, "{turned}");
        assert_eq!((scan.name.as_str(), scan.unit), ("part", LengthUnit::Metre));
        assert_eq!(scan.notes.len(), 1);
        assert!(scan.notes[0].text.ends_with("taken as metres by its convention"));
    }

    #[test]
    fn a_folder_with_one_configuration_is_its_scan() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.ply"), "ply").unwrap();
        std::fs::write(folder.path().join("bun.conf"), "bmesh a.ply 0 0 0 0 0 0 1\n").unwrap();
        let scan = Scan::open(folder.path()).unwrap();
        assert_eq!((scan.name.as_str(), scan.views.len()), ("bun", 1));
        std::fs::write(folder.path().join("head.conf"), "").unwrap();
        assert_eq!(configuration(folder.path()), None, "either may be meant");
        assert_eq!(configuration(&folder.path().join("a.ply")), None);
    }

    #[test]
    fn quaternions_without_direction_are_named_by_line_and_view() {
        let error = open_text("\nbmesh a.ply 0 0 0 0 0 0 0").unwrap_err().to_string();
        let wanted =
            "part.conf, line 2, view a.ply: the quaternion has length 0, which is no rotation";
        assert!(error.ends_with(wanted), "{error}");
        let error = open_text("bmesh a.ply 0 0 NaN 0 0 0 1").unwrap_err().to_string();
        assert!(error.contains("line 1, view a.ply: the pose has a number"), "{error}");
        let error = open_text("bmesh a.ply 0 0").unwrap_err().to_string();
        assert!(error.contains("line 1, view a.ply: expected a file and 7 numbers"), "{error}");
    }

    #[test]
    fn byte_order_marks_comments_and_long_quaternions_are_read() {
        let scan = open_text("\u{feff}mesh a.ply 0 0 0 0 0 0 2\n# a comment\n").unwrap();
        assert_eq!(scan.views[0].world_from_sensor(), &Isometry3::identity());
        assert!(
            scan.notes[1]
                .to_string()
                .ends_with("line 1, view a.ply: quaternion of length 2.0000 normalised")
        );
        let empty = open_text("camera 1 2 3\n").unwrap_err().to_string();
        assert!(empty.ends_with("part.conf: no line \"bmesh FILE ...\""), "{empty}");
    }

    #[test]
    fn a_line_that_is_none_is_an_error() {
        let error = open_text("bmesh a.ply 0 0 0 0 0 0 1\nbmehs a.ply 0 0 0 0 0 0 1\n");
        let error = error.unwrap_err().to_string();
        let wanted = "part.conf, line 2: the line begins with \"bmehs\"; expected \"bmesh\"";
        assert!(error.contains(wanted), "{error}");
    }

    /// Read the other way round, the poses put these two scans centimetres apart.
    #[test]
    fn neighbouring_scans_of_the_bunny_lie_on_each_other() {
        let Some(folder) = crate::test_data::shared("stanford_bunny") else { return };
        let scan = Scan::open(&folder.join("bun.conf")).unwrap();
        let points = |number: usize, every: usize| {
            let view = &scan.views[number];
            let grid = crate::read_range_grid(view.path()).unwrap();
            let seen = grid.points.into_iter().filter(|p| p.x.is_finite()).step_by(every);
            seen.map(|p| view.world_from_sensor() * p).collect::<Vec<_>>()
        };
        let (first, second) = (points(0, 1), points(1, 100));
        let nearest = |p: &Point3| {
            first.iter().map(|q| (p - q).norm_squared()).fold(f64::INFINITY, f64::min).sqrt()
        };
        // The grids are 0.5 to 0.8 mm wide, so points of one lie up to half of that from the
        // other's.
        let median = transect_device::median(second.iter().map(nearest)).unwrap();
        assert!(median < 0.5e-3, "{median} m");
    }
}
