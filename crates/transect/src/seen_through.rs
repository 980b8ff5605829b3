//! Curves that views looked through.
//!
//! **Problem.** Fused curves hold what one view alone saw: people who walked by, false pixels
//! between two surfaces, walls that a wrong pose doubled. Other views measured what lies behind.
//!
//! **Idea.** The views vote. A node is left out if more views looked through it than measured it
//! (free space as in Curless and Levoy, 1996), and two at least. Nodes of fused curves are asked
//! about, so a view whose pose errs a little has a part in the curve and votes for it.
//!
//! Views without a curve on the plane have no vote. So a plane depends on the views that have
//! curves on it alone, and a model store fuses those planes of a new view that it has curves on.

use transect_device::{Isometry3, View};
use transect_geometry::{Curve, EndReason, Node, PlaneFrame, Point3};
use transect_register::FreeSpace;

/// Fewest views that look through a node. No unit. Chosen by hand: one view may have looked through
/// a window. Doubled, three views of four no longer leave out what the fourth one saw.
pub(crate) const LEAST_THROUGH: u32 = 2;

/// Nodes from one that is asked about to the next. No unit. Measured on 50 frames of a depth
/// camera: asking about every node takes 1.4 % of a run more. Between two different answers, all
/// nodes are asked about. Doubled, a stretch of seven nodes may be missed.
const STRIDE: usize = 4;

/// A view that can tell of free space.
#[derive(Debug, Clone)]
pub struct Witness {
    sensor_from_world: Isometry3,
    free: FreeSpace,
}

impl Witness {
    /// What a view looked through; `None` if it cannot tell.
    pub fn of(view: &View) -> Option<Self> {
        Some(Self::new(view.world_from_sensor(), FreeSpace::of(view)?))
    }

    /// What a view at this pose looked through.
    pub(crate) fn new(world_from_sensor: &Isometry3, free: FreeSpace) -> Self {
        Self { sensor_from_world: world_from_sensor.inverse(), free }
    }

    /// Whether the view looked through a world point.
    pub(crate) fn looked_through(&self, in_world: &Point3) -> bool {
        self.free.holds(&(self.sensor_from_world * in_world))
    }
}

/// The curves of a plane, and the nodes that were left out of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Seen {
    /// The curves that are left.
    pub curves: Vec<Curve>,
    /// The number of nodes that were left out.
    pub left_out: usize,
}

/// Leaves out what more views looked through than measured. `witnesses` are the views that have
/// curves on the plane. A run does this where [`Setup::free_space`](crate::Setup::free_space) is
/// set.
pub fn without_seen_through(
    curves: Vec<Curve>,
    frame: &PlaneFrame,
    witnesses: &[&Witness],
) -> Seen {
    if (witnesses.len() as u32) < LEAST_THROUGH {
        return Seen { curves, left_out: 0 };
    }
    let is_through = |node: &Node| {
        let place = frame.world_from_plane(&node.position);
        let through = witnesses.iter().filter(|w| w.looked_through(&place)).count() as u32;
        through >= LEAST_THROUGH && through > node.view_count()
    };
    let nodes = |curves: &[Curve]| curves.iter().map(|curve| curve.nodes().len()).sum::<usize>();
    let before = nodes(&curves);
    let kept = curves.into_iter().flat_map(|curve| {
        let through = answers(curve.nodes(), is_through);
        if through.contains(&true) { pieces(&curve, &through) } else { vec![curve] }
    });
    let curves: Vec<Curve> = kept.collect();
    Seen { left_out: before - nodes(&curves), curves }
}

/// The answers about all nodes, of which some are asked about.
fn answers(nodes: &[Node], ask: impl Fn(&Node) -> bool) -> Vec<bool> {
    let mut answers = vec![false; nodes.len()];
    let mut before: Option<(usize, bool)> = None;
    let last = nodes.len().saturating_sub(1);
    for k in (0..last).step_by(STRIDE).chain([last]) {
        let Some(node) = nodes.get(k) else { break };
        let here = ask(node);
        if let Some((from, there)) = before {
            for between in from + 1..k {
                answers[between] = if here == there { here } else { ask(&nodes[between]) };
            }
        }
        answers[k] = here;
        before = Some((k, here));
    }
    answers
}

/// The pieces of a curve without some of its nodes. A node alone makes no piece.
fn pieces(curve: &Curve, left_out: &[bool]) -> Vec<Curve> {
    let count = curve.nodes().len();
    // A closed curve begins behind a gap.
    let gap = left_out.iter().position(|left_out| *left_out).filter(|_| curve.is_closed());
    let order: Vec<usize> = (0..count).map(|k| (k + gap.unwrap_or(0)) % count).collect();
    let kept = order.split(|k| left_out[*k]).filter(|run| run.len() > 1);
    let piece = |run: &[usize]| {
        let nodes = run.iter().map(|k| curve.nodes()[*k]).collect();
        let [begin, end] = curve.ends();
        let at = |place: Option<&usize>, of: usize, reason: Option<EndReason>| {
            reason.filter(|_| place == Some(&of))
        };
        let ends = [at(run.first(), 0, begin), at(run.last(), count - 1, end)];
        Some(Curve::new(nodes, false).ok()?.with_ends(ends))
    };
    kept.filter_map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{ImageSize, Point3, RangeImage, Vector3, View};
    use transect_geometry::Point2;
    use transect_sensors::{Intrinsics, Pinhole};

    /// A camera in the origin that looks along z at a wall 3 m away.
    fn witness() -> Witness {
        let size = ImageSize { rows: 240, cols: 320 };
        let camera = Pinhole::new(size, Intrinsics { fx: 160.0, fy: 160.0, cx: 159.5, cy: 119.5 });
        let image = RangeImage::from_values(size, vec![3.0; size.pixels()]).unwrap();
        let pose = Isometry3::identity();
        let view = View::new("wall", image, Arc::new(camera.unwrap()), pose, Some(0.0)).unwrap();
        Witness::new(&pose, FreeSpace::of(&view).unwrap())
    }

    /// The plane of x and z, and a curve along x at a depth, which so many views measured.
    fn plane() -> PlaneFrame {
        PlaneFrame::new(Point3::origin(), Vector3::y()).unwrap()
    }

    fn curve(places: impl Iterator<Item = (f64, f64)>, views: u32, closed: bool) -> Curve {
        let node = |(x, z): (f64, f64)| {
            let place = plane().plane_from_world(&Point3::new(x, 0.0, z));
            Node::at(place).with_views(views)
        };
        Curve::new(places.map(node).collect(), closed).unwrap()
    }

    fn along_x(z: f64, views: u32) -> Curve {
        curve((-50..=50).map(|k| (0.01 * f64::from(k), z)), views, false)
    }

    fn left_out(curve: &Curve, witnesses: usize) -> usize {
        let witness = witness();
        let witnesses = vec![&witness; witnesses];
        without_seen_through(vec![curve.clone()], &plane(), &witnesses).left_out
    }

    #[test]
    fn more_views_that_look_through_than_measured_leave_a_curve_out() {
        let count = along_x(2.0, 1).nodes().len();
        for (views, witnesses, gone) in [
            (1, 1, 0),
            (1, 2, count),
            (2, 2, 0),
            (2, 3, count),
            (3, 3, 0),
            (0, 1, 0),
            (0, 2, count),
        ] {
            assert_eq!(left_out(&along_x(2.0, views), witnesses), gone, "{views} {witnesses}");
        }
        // On the wall and behind it.
        assert_eq!([3.0, 4.0].map(|z| left_out(&along_x(z, 1), 9)), [0, 0]);
    }

    #[test]
    fn the_rest_of_a_curve_stays() {
        // From the wall to a corner before it, and back.
        let place =
            |k: i32| (0.01 * f64::from(k), 3.0 - (0.5 - 0.02 * f64::from((k - 50).abs())).max(0.0));
        let ends = [Some(EndReason::RangeJump), Some(EndReason::ImageBorder)];
        let whole = curve((0..100).map(place), 1, false).with_ends(ends);
        let witness = witness();
        let seen = without_seen_through(vec![whole.clone()], &plane(), &[&witness, &witness]);
        assert_eq!(seen.curves.len(), 2);
        let [a, b] = [0, 1].map(|k| seen.curves[k].ends());
        assert_eq!([a[0], a[1], b[0], b[1]], [ends[0], None, None, ends[1]]);
        let kept: usize = seen.curves.iter().map(|curve| curve.nodes().len()).sum();
        assert_eq!(kept + seen.left_out, whole.nodes().len());
        assert!((30..70).contains(&seen.left_out), "{}", seen.left_out);
    }

    #[test]
    fn a_closed_curve_opens_at_its_gap() {
        let around = |k: i32| f64::from(k) * std::f64::consts::TAU / 200.0;
        let places = (0..200).map(|k| (0.3 * around(k).cos(), 3.0 - 0.3 * around(k).sin()));
        let closed = curve(places, 1, true);
        let left_out: Vec<bool> = (0..200).map(|k| (20..30).contains(&k)).collect();
        let pieces = pieces(&closed, &left_out);
        assert_eq!(pieces.len(), 1);
        assert!(!pieces[0].is_closed() && pieces[0].nodes().len() == 190);
        assert_eq!(pieces[0].nodes()[0], closed.nodes()[30]);
    }

    #[test]
    fn answers_are_those_of_asking_about_every_node() {
        let nodes: Vec<Node> = (0..203).map(|k| Node::at(Point2::new(f64::from(k), 0.0))).collect();
        for (low, high) in [(40.0, 52.0), (0.0, 9.0), (190.0, 300.0), (-9.0, 300.0), (300.0, 301.0)]
        {
            let ask = |node: &Node| (low..high).contains(&node.position.x);
            let all: Vec<bool> = nodes.iter().map(ask).collect();
            assert_eq!(answers(&nodes, ask), all, "{low} {high}");
        }
        assert_eq!(answers(&nodes[..2], |_| true), [true, true]);
    }
}
