//! Views that lie far away from the others, as those without a pose do in a survey in world
//! coordinates.
//!
//! **Idea.** Views whose boxes are near each other belong together, and so do their neighbours. The
//! largest group is the scan.

use crate::survey::ViewSurvey;
use crate::table::Quantity;
use transect_geometry::LengthUnit;

/// Largest distance between the boxes of two views that belong together, over the diagonal of the
/// larger box. No unit. Theory: stations of one survey see ground within a few times their range,
/// and coordinates of a country are a thousand times as long. Chosen by hand in between: from 5 to
/// 100 nothing changes there. Doubled, parts of a site with ten boxes between them stay together.
const NEAR: f64 = 10.0;

/// The numbers of the views that lie far away from most others. Of two largest groups of one size,
/// the one without poses is away. No view is away if several largest groups have poses.
pub(crate) fn far_away(views: &[ViewSurvey]) -> Vec<usize> {
    let groups = groups(views);
    let weight = |group: &Vec<usize>| {
        (group.len(), group.iter().any(|k| views.get(*k).is_some_and(|view| !view.is_unposed)))
    };
    let Some(largest) = groups.iter().map(weight).max() else { return Vec::new() };
    let (main, others): (Vec<_>, Vec<_>) =
        groups.into_iter().partition(|group| weight(group) == largest);
    if main.len() == 1 { others.concat() } else { Vec::new() }
}

/// The views that are near each other, directly or by others.
fn groups(views: &[ViewSurvey]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (k, view) in views.iter().enumerate() {
        let is_near = |other: &usize| views.get(*other).is_some_and(|o| are_near(view, o));
        let (near, mut far): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(is_near));
        let mut joined = near.concat();
        joined.push(k);
        far.push(joined);
        groups = far;
    }
    groups
}

fn are_near(a: &ViewSurvey, b: &ViewSurvey) -> bool {
    let size = |view: &ViewSurvey| (view.corners.1 - view.corners.0).norm();
    gap(a, b) <= NEAR * size(a).max(size(b))
}

/// The distance between the boxes of two views.
fn gap(a: &ViewSurvey, b: &ViewSurvey) -> f64 {
    let apart = (b.corners.0 - a.corners.1).sup(&(a.corners.0 - b.corners.1));
    apart.map(|length| length.max(0.0)).norm()
}

/// The views but those of some numbers.
pub(crate) fn without(views: &[ViewSurvey], away: &[usize]) -> Vec<ViewSurvey> {
    let near = views.iter().enumerate().filter(|(k, _)| !away.contains(k));
    near.map(|(_, view)| view.clone()).collect()
}

/// The sentence on views that lie far away; `None` if no view does.
pub(crate) fn sentence(views: &[ViewSurvey], away: &[usize], unit: LengthUnit) -> Option<String> {
    let first = views.get(*away.first()?)?;
    let near = without(views, away);
    let distance = near.iter().map(|view| gap(first, view)).fold(f64::INFINITY, f64::min);
    let distance = Quantity::new(distance, unit, 1).shown(None).join(" ");
    let pose = if first.is_unposed {
        ", and its pose is the identity, as if the file had none"
    } else {
        ""
    };
    let others = match away.len() {
        1 => String::new(),
        2 => " So does 1 more view.".to_owned(),
        n => format!(" So do {} more views.", n - 1),
    };
    Some(format!(
        "view {} lies {distance} away from the others{pose}.{others} The suggested planes leave \
         such views out. Check their poses, or leave them out with the setting `views`",
        first.name
    ))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "tests may fail loudly")]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{ImageSize, Isometry3, RangeImage, View};
    use transect_sensors::{Intrinsics, Pinhole};

    /// A camera 2 m before a wall.
    fn at(x: f64) -> ViewSurvey {
        let size = ImageSize { rows: 6, cols: 8 };
        let intrinsics = Intrinsics { fx: 8.0, fy: 8.0, cx: 3.5, cy: 2.5 };
        let image = RangeImage::from_values(size, vec![2.0; size.pixels()]).unwrap();
        let camera = Arc::new(Pinhole::new(size, intrinsics).unwrap());
        let pose = Isometry3::translation(x, 0.0, 0.0);
        let view = View::new(format!("at {x}"), image, camera, pose, Some(0.0)).unwrap();
        ViewSurvey::of(&view, Vec::new())
    }

    fn away(places: &[f64]) -> Vec<usize> {
        far_away(&places.iter().map(|x| at(*x)).collect::<Vec<_>>())
    }

    #[test]
    fn a_view_without_a_pose_lies_far_from_a_survey_in_world_coordinates() {
        assert_eq!(away(&[4e5, 4.00002e5, 0.0, 4.00004e5]), [2]);
        // Of two views it is the one whose pose is the identity.
        assert_eq!((away(&[0.0, 4e5]), away(&[4e5, 0.0])), (vec![0], vec![1]));
        let views = [at(4e5), at(0.0)];
        let told = sentence(&views, &[1], LengthUnit::Metre).unwrap();
        assert!(told.starts_with("view at 0 lies") && told.contains("identity"), "{told}");
        let views = [at(4e5), at(4.00002e5), at(4.00004e5), at(0.0), at(1e9)];
        let told = sentence(&views, &far_away(&views), LengthUnit::Metre).unwrap();
        assert!(told.contains(" So does 1 more view. "), "{told}");
    }

    #[test]
    fn views_that_follow_each_other_are_not_far_away() {
        assert_eq!(away(&[0.0, 10.0, 20.0, 30.0, 40.0, 50.0]), Vec::<usize>::new());
        // Nothing tells which half is wrong.
        assert_eq!(away(&[1e5, 1e5, 3e5, 3e5]), Vec::<usize>::new());
        assert_eq!(away(&[]), Vec::<usize>::new());
    }
}
