//! Structured scans of terrestrial scanners, as E57 and PTX files and organised clouds hold them.

use crate::missing::{self, Origin};
use crate::scan::FramedImage;
use crate::{Place, ReadError};
use std::path::Path;
use std::sync::Arc;
use transect_device::ImageSize;
use transect_geometry::Point3;
use transect_sensors::PointGrid;
use transect_sensors::RayStarts::Viewpoint;
use transect_sensors::point_grid::{fit_viewpoint, step_variation, uneven_rays};

/// Largest share of uneven rays of a true viewpoint. Measured: 0 in a scan of a plant room and in
/// simulated rooms; 1 % from a place that is 0.5 m off. Doubled, a place 0.2 m off passes.
const MOST_UNEVEN: f64 = 2e-3;
/// Largest variation of the steps between rays from the place that saw the points, over that from
/// the origin. Measured in a room: 0.4 m off the true place the steps vary at least 4 times as
/// much. Images of a Kinect and a scan of a plant room are seen from their origin; a fitted place
/// has 0.99 to 1.3 times its variation. Doubled, a place beside a true origin may be taken.
const STEADIER: f64 = 0.5;

/// The frame and the image of one scan of a file, from its row-major points. `stated` is the place
/// of the scanner that the file states beside the pose, in the frame of the points.
pub(crate) fn framed(
    path: &Path,
    at: &Place,
    size: ImageSize,
    mut points: Vec<Point3>,
    stated: Option<Point3>,
    notes: &mut Vec<String>,
) -> Result<FramedImage, ReadError> {
    missing::clear_points(size, &mut points, Origin::PointFile, notes)
        .map_err(|p| p.of(&at.words()).in_file(path))?;
    let origin = Point3::origin();
    points.iter_mut().filter(|p| **p == origin).for_each(|p| p.x = f64::NAN);
    if points.iter().all(|p| p.coords.iter().any(|c| c.is_nan())) {
        let problem =
            "no pixel has a point; leave this scan out, with the setting `views` or in the export";
        return Err(ReadError::damaged(path, at.clone(), problem));
    }
    let viewpoint = viewpoint(size, &points, stated, notes);
    let unusable = |e| ReadError::unusable(path, at.clone(), "the grid", e);
    let (frame, image) = PointGrid::new(size, points, Viewpoint(viewpoint)).map_err(unusable)?;
    Ok(FramedImage { frame: Arc::new(frame), image })
}

/// Whether points are seen from a place, and not from the origin of their frame.
pub(crate) fn is_seen_from_alone(size: ImageSize, points: &[Point3], place: &Point3) -> bool {
    let is_even = |place: &Point3| uneven_rays(size, points, place) <= MOST_UNEVEN;
    !is_even(&Point3::origin()) && is_even(place)
}

/// The place that saw the points: the origin of their frame, or another one if they are not seen
/// from there. Programs write points in the world's frame, with a pose that moves nothing.
fn viewpoint(
    size: ImageSize,
    points: &[Point3],
    stated: Option<Point3>,
    notes: &mut Vec<String>,
) -> Point3 {
    let origin = Point3::origin();
    let uneven = |place: &Point3| uneven_rays(size, points, place);
    let variation = |place: &Point3| step_variation(size, points, place);
    let (jumps, usual) = (uneven(&origin), variation(&origin));
    let is_even = jumps <= MOST_UNEVEN;
    let is_better = |place: &Point3| {
        uneven(place) <= MOST_UNEVEN && (!is_even || variation(place) < STEADIER * usual)
    };
    let better = stated.filter(is_better);
    let Some(p) = better.or_else(|| fit_viewpoint(size, points).filter(is_better)) else {
        if !is_even {
            notes.push(format!(
                "the points are not seen from the scan's origin ({:.1} % of rays jump), nor from \
                 another place; free and solid sides may be wrong; export coordinates in the \
                 scanner's frame, with its pose",
                100.0 * jumps
            ));
        }
        return origin;
    };
    let (jumps, usual) = (100.0 * jumps, 100.0 * usual);
    notes.push(format!(
        "the points are not seen from the scan's origin ({jumps:.1} % of rays jump, and their \
         steps vary by {usual:.1} %), but from ({:.3}, {:.3}, {:.3}), which is taken as the \
         scanner's place; export coordinates in the scanner's frame, with its pose, to state it",
        p.x, p.y, p.z
    ));
    p
}

#[cfg(test)]
mod tests {
    use super::*;
    use transect_device::{Pixel, Vector3};

    const SIZE: ImageSize = ImageSize { rows: 60, cols: 90 };

    /// A room with a pillar in the world's frame, as a scanner at `at` sees it.
    fn room(at: &Vector3) -> Vec<Point3> {
        hall(at, 0.4)
    }

    /// A room in which a pillar stands at a share of the way to a wall.
    fn hall(at: &Vector3, pillar: f64) -> Vec<Point3> {
        let point = |k: usize| {
            let (theta, phi) = (0.07 * (k % 90) as f64, -1.0 + 0.03 * (k / 90) as f64);
            let (cos, z) = (phi.cos(), phi.sin());
            let d = Vector3::new(cos * theta.cos(), cos * theta.sin(), z);
            let reach = Vector3::new(5.0, 4.0, 1.5).zip_map(&d, |half, d| half / d.abs()).min();
            Point3::from(at + d * if d.x > 0.9 { pillar * reach } else { reach })
        };
        (0..SIZE.pixels()).map(point).collect()
    }

    /// The start of the rays, and the notes.
    fn seen_from(points: Vec<Point3>, stated: Option<Point3>) -> (Point3, Vec<String>) {
        let (at, mut notes) = (Place::View { number: 3, name: "hall".to_owned() }, Vec::new());
        let framed = framed(Path::new("a.e57"), &at, SIZE, points, stated, &mut notes).unwrap();
        (framed.frame.ray(Pixel::new(30, 10)).unwrap().start, notes)
    }

    #[test]
    fn points_in_the_frame_of_the_world_are_seen_from_the_scanner() {
        let origin = Point3::origin();
        let (start, notes) = seen_from(room(&origin.coords), Some(Point3::new(9.0, 9.0, 9.0)));
        assert_eq!((start, notes.len()), (origin, 0), "the origin comes first");
        let place = Point3::new(420_000.0, 5_300_000.0, 310.0);
        for stated in [None, Some(place), Some(origin), Some(Point3::new(1.0, 2.0, 3.0))] {
            let (start, notes) = seen_from(room(&place.coords), stated);
            assert!((start - place).norm() < 1e-3, "{stated:?}: {start}");
            assert!(notes[0].starts_with("the points are not seen from"), "{notes:?}");
            assert!(notes[0].contains("but from (420000.000, 5300000.000, 310.000), which is"));
        }
    }

    #[test]
    fn a_room_without_jumps_is_seen_from_the_scanner_too() {
        let place = Point3::new(0.4, -0.3, 0.1);
        for stated in [None, Some(place), Some(Point3::new(3.0, 1.0, 0.0))] {
            let (start, notes) = seen_from(hall(&place.coords, 1.0), stated);
            assert!((start - place).norm() < 1e-3, "{stated:?}: {start}");
            assert!(notes[0].contains("but from (0.400, -0.300, 0.100), which is"), "{notes:?}");
        }
        let (start, notes) = seen_from(hall(&Vector3::zeros(), 1.0), Some(place));
        assert_eq!((start, notes.len()), (Point3::origin(), 0), "{notes:?}");
    }

    #[test]
    fn a_scan_without_points_is_told() {
        let nowhere = vec![Point3::new(f64::NAN, 0.0, 0.0); SIZE.pixels()];
        let (at, notes) = (Place::Whole, &mut Vec::new());
        let error = framed(Path::new("a.ptx"), &at, SIZE, nowhere, None, notes).unwrap_err();
        assert_eq!(
            error.to_string(),
            "a.ptx: no pixel has a point; leave this scan out, with the setting `views` or in the \
             export"
        );
    }

    #[test]
    fn points_that_no_place_saw_are_noted() {
        let mut points = room(&Vector3::new(300.0, 0.0, 0.0));
        // Two halves of the room as two places see them.
        for (point, other) in points.iter_mut().zip(room(&Vector3::new(290.0, 3.0, 0.0))).skip(2700)
        {
            *point = other;
        }
        let (start, notes) = seen_from(points, None);
        assert_eq!(start, Point3::origin());
        assert!(notes[0].contains("nor from another place; free and solid sides"), "{notes:?}");
    }
}
