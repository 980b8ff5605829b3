//! Where a next view would close most gaps (dissertation, section 6.4).
//!
//! Idea: a gap is closed by a view of its chord from the free side. The sensor is placed in space
//! that rays crossed, because only that space is known to be free.
//!
//! 1. Every gap is sampled along its chord. The area of a sample is its share of the chord times
//!    the interval of the planes.
//! 2. Candidates are places in free space, evenly spaced.
//! 3. A candidate sees a sample that faces it, lies within the sensor's reach, and has no observed
//!    surface in between. Unknown space may hide a surface, so the sample counts with the share of
//!    the way to it that is known to be free.
//! 4. The candidate that sees the largest area is chosen, and its part of each sample is removed;
//!    then the next is chosen. This greedy cover reaches at least 63 % of the largest total
//!    (Nemhauser, Wolsey and Fisher 1978).
//!
//! Limits: sensors are points that see in all directions and can be anywhere in free space, so the
//! list is a proposal. Faces parallel to the section planes, such as the top of a table on level
//! sections, are in no section; only unknown space hints at them.

use super::KnownSpace;
use transect_geometry::{Point3, Vector3};

/// A piece of an unseen surface, from a gap of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnseenPatch {
    /// Its middle, in the world.
    pub middle: Point3,
    /// Unit vector away from the solid, in the world.
    pub outward: Vector3,
    /// Its area, in the square of the length unit.
    pub area: f64,
}

/// Options of the search for views.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NextViewOptions {
    /// Number of views to propose.
    pub views: usize,
    /// Largest angle between ray and surface normal at which a surface is seen, in radians.
    pub max_incidence_rad: f64,
    /// Largest distance at which the sensor sees a surface, in the length unit.
    pub reach: f64,
}

impl NextViewOptions {
    /// A number of views, the largest angle of incidence in radians, and the sensor's reach.
    pub const fn new(views: usize, max_incidence_rad: f64, reach: f64) -> Self {
        Self { views, max_incidence_rad, reach }
    }
}

/// Largest number of candidates and of patches; larger sets are thinned evenly. Chosen by hand.
/// Doubled, the search takes twice the time.
const CANDIDATES: usize = 600;
const PATCHES: usize = 4000;

/// A place from which a view would close gaps.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct NextView {
    /// Where to put the sensor, in the world.
    pub position: Point3,
    /// The middle of the unseen area that it would see.
    pub target: Point3,
    /// Unseen area expected in sight, without the area that earlier views of the list see, in the
    /// square of the length unit.
    pub area: f64,
}

/// The patches that a place sees, by number, with the share of each.
type Sight = Vec<(usize, f64)>;

/// The places with the largest unseen area in sight, best first; fewer than asked for if no place
/// sees more.
pub fn next_views(
    patches: &[UnseenPatch],
    space: &KnownSpace,
    options: &NextViewOptions,
) -> Vec<NextView> {
    let mut patches = thinned(patches);
    let look = |place: Point3| {
        let sees = |(k, patch)| Some((k, share_in_sight(&place, patch, space, options)?));
        (place, patches.iter().enumerate().filter_map(sees).collect())
    };
    let sights: Vec<(Point3, Sight)> = candidates(space).into_iter().map(look).collect();
    let mut chosen = Vec::new();
    while chosen.len() < options.views {
        // The first of equal places, so that the answer is always the same.
        let areas = sights.iter().map(|(_, sight)| area(&patches, sight));
        let best = areas.zip(&sights).rev().max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((area, (position, sight))) = best.filter(|(area, _)| *area > 0.0) else { break };
        chosen.push(NextView { position: *position, target: middle(&patches, sight), area });
        for &(k, share) in sight {
            patches[k].area *= 1.0 - share;
        }
    }
    chosen
}

fn area(patches: &[UnseenPatch], sight: &Sight) -> f64 {
    sight.iter().map(|&(k, share)| patches[k].area * share).sum()
}

/// Evenly chosen patches, each with the area of the patches left out beside it.
fn thinned(patches: &[UnseenPatch]) -> Vec<UnseenPatch> {
    let stride = patches.len().div_ceil(PATCHES).max(1);
    let standing_for = |group: &[UnseenPatch]| {
        let area = group.iter().map(|p| p.area).sum();
        group.get(group.len() / 2).map(|&middle| UnseenPatch { area, ..middle })
    };
    patches.chunks(stride).filter_map(standing_for).collect()
}

fn candidates(space: &KnownSpace) -> Vec<Point3> {
    let mut stride = 1;
    loop {
        let places = space.free_places(stride);
        if places.len() <= CANDIDATES {
            return places;
        }
        stride += 1;
    }
}

/// The share of a patch expected in sight; `None` if it is hidden.
fn share_in_sight(
    place: &Point3,
    patch: &UnseenPatch,
    space: &KnownSpace,
    options: &NextViewOptions,
) -> Option<f64> {
    let towards = place - patch.middle;
    let distance = towards.norm();
    let faces = towards.dot(&patch.outward) > distance * options.max_incidence_rad.cos();
    if !faces || distance > options.reach {
        return None;
    }
    // The ends of the gap are surface themselves, so cells with surface near it do not hide it.
    let share = space.free_share(place, &patch.middle, 2.0 * space.cell_size());
    (share > 0.0).then_some(share)
}

fn middle(patches: &[UnseenPatch], sight: &Sight) -> Point3 {
    let moment = |&(k, share): &(usize, f64)| patches[k].middle.coords * (patches[k].area * share);
    let moments: Vector3 = sight.iter().map(moment).sum();
    Point3::from(moments / area(patches, sight))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sensor at the origin sees a wall at x = 10 with a post before it at x = 5; the wall behind
    /// the post is a gap.
    fn scene() -> (KnownSpace, Vec<UnseenPatch>) {
        let steps = || -40..=40;
        let seen =
            steps().flat_map(|y| steps().map(move |z| (f64::from(y) * 0.1, f64::from(z) * 0.1)));
        let hit = |(y, z): (f64, f64)| {
            if y.abs() < 1.0 { Point3::new(5.0, y / 2.0, z / 2.0) } else { Point3::new(10.0, y, z) }
        };
        let rays: Vec<_> = seen.map(|p| (Point3::origin(), hit(p))).collect();
        let patch = |k: i32| UnseenPatch {
            middle: Point3::new(10.0, 0.1 * f64::from(k), 0.0),
            outward: -Vector3::x(),
            area: 0.1,
        };
        (KnownSpace::from_rays(&rays).unwrap(), (-9..=9).map(patch).collect())
    }

    fn options(views: usize) -> NextViewOptions {
        NextViewOptions::new(views, 1.3, 20.0)
    }

    #[test]
    fn the_gap_behind_a_post_is_seen_from_beside_the_post() {
        let (space, patches) = scene();
        let origin = Point3::origin();
        let hidden = |p: &UnseenPatch| share_in_sight(&origin, p, &space, &options(1)).is_none();
        assert!(patches.iter().all(hidden));
        let views = next_views(&patches, &space, &options(3));
        assert!(views[0].area > 1.4 && views[0].area <= 1.9, "{views:?}");
        let total: f64 = views.iter().map(|v| v.area).sum();
        assert!(views.windows(2).all(|v| v[0].area >= v[1].area) && total <= 1.9, "{views:?}");
        let line = views[0].position + (views[0].target - views[0].position) * 0.5;
        assert!(line.x > 5.0 || line.y.abs() > 0.5, "the post is in the way: {views:?}");
    }

    #[test]
    fn what_faces_away_or_is_too_far_is_not_promised() {
        let (space, mut patches) = scene();
        let near = NextViewOptions { reach: 1e-3, ..options(1) };
        assert_eq!(next_views(&patches, &space, &near), []);
        patches.iter_mut().for_each(|p| p.outward = Vector3::x());
        assert_eq!(next_views(&patches, &space, &options(1)), []);
    }

    #[test]
    fn many_patches_keep_their_area() {
        let (space, patches) = scene();
        let many: Vec<_> = (0..10_001).map(|k| patches[k % patches.len()]).collect();
        let area: f64 = thinned(&many).iter().map(|p| p.area).sum();
        assert!((area - 1000.1).abs() < 1e-6);
        assert!(candidates(&space).len() <= CANDIDATES);
    }
}
