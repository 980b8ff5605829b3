//! What the consensus of all views must keep, on shapes whose truth is known.

use proptest::prelude::*;
use std::f64::consts::TAU;
use transect_fusion::pattern::{OverlapTolerance, Relation, classify};
use transect_fusion::{ConsensusOptions, FusedPlane, consensus};
use transect_geometry::{Curve, Node, Point2};

/// A star-shaped outline: r(a) = 1 + bumps.
#[derive(Debug, Clone, Copy)]
struct Outline {
    bump: f64,
    lobes: f64,
}

impl Outline {
    fn at(&self, a: f64) -> Point2 {
        let r = 1.0 + self.bump * (self.lobes * a).cos();
        Point2::new(r * a.cos(), r * a.sin())
    }

    /// Distance of a point from the outline along its radius.
    fn error(&self, p: &Point2) -> f64 {
        p.coords.norm() - self.at(p.y.atan2(p.x)).coords.norm()
    }
}

/// What one view saw: an arc, sampled at a spacing and a phase of its own, with noise.
#[derive(Debug, Clone)]
struct Look {
    from: f64,
    sweep: f64,
    spacing: f64,
    seed: u64,
}

/// Uniform noise in ±1 from a seed.
fn noise(seed: u64, k: u64) -> f64 {
    let mut x = seed ^ k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    for _ in 0..2 {
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    (x >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

fn see(outline: &Outline, look: &Look, sigma: f64) -> Vec<Curve> {
    let count = (look.sweep / look.spacing) as u64;
    let closed = look.sweep >= TAU;
    let phase = 0.5 * noise(look.seed, 99);
    let node = |k: u64| {
        let a = look.from + look.spacing * (k as f64 + phase);
        let p = outline.at(a);
        // Uniform in ±√3 σ has the standard deviation σ.
        let off = 1.0 + sigma * 3_f64.sqrt() * noise(look.seed, k) / p.coords.norm();
        let position = Point2::from(p.coords * off);
        let correlation = (look.spacing * (look.seed % 4) as f64) as f32;
        let (sigma, footprint) = (sigma as f32, look.spacing as f32);
        Node::at(position).with_sigma(sigma).with_footprint(footprint).with_correlation(correlation)
    };
    vec![Curve::new((0..count).map(node).collect(), closed).unwrap()]
}

fn fuse(views: &[Vec<Curve>]) -> FusedPlane {
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    consensus(&slices, &ConsensusOptions::default())
}

fn outlines() -> impl Strategy<Value = Outline> {
    (0.0..0.2_f64, 2..6_u32).prop_map(|(bump, lobes)| Outline { bump, lobes: f64::from(lobes) })
}

fn looks() -> impl Strategy<Value = Vec<Look>> {
    let look = (0.0..TAU, 1.0..4.0_f64, 0.015..0.025_f64, any::<u64>())
        .prop_map(|(from, sweep, spacing, seed)| Look { from, sweep, spacing, seed });
    prop::collection::vec(look, 1..8)
}

fn nodes(plane: &FusedPlane) -> impl Iterator<Item = &Node> {
    plane.curves.iter().flat_map(|c| c.nodes())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn the_order_of_views_does_not_matter(
        outline in outlines(), looks in looks(), sigma in 0.0..0.01_f64, turn in 0..8_usize,
    ) {
        let views: Vec<_> = looks.iter().map(|l| see(&outline, l, sigma)).collect();
        let mut turned = views.clone();
        turned.rotate_left(turn % views.len());
        turned.swap(0, views.len() / 2);
        prop_assert_eq!(fuse(&views).curves, fuse(&turned).curves);
    }

    #[test]
    fn no_two_curves_overlap_and_all_of_them_lie_on_the_outline(
        outline in outlines(), looks in looks(), sigma in 0.0..0.008_f64,
    ) {
        let views: Vec<_> = looks.iter().map(|l| see(&outline, l, sigma)).collect();
        let fused = fuse(&views);
        for n in nodes(&fused) {
            // A node near the end of one view's curve may state more than the noise of a sample.
            let largest = 4.0 * sigma.max(f64::from(n.sigma)) + 2e-3;
            let error = outline.error(&n.position).abs();
            prop_assert!(error < largest, "{error} at {n:?}");
        }
        let tolerance = OverlapTolerance::within((3.0 * sigma).max(0.005)).unwrap();
        for (k, a) in fused.curves.iter().enumerate() {
            for b in &fused.curves[..k] {
                let overlaps = classify(a, b, &tolerance);
                // Ends that meet are one curve's worth of gap apart; anything longer is a
                // duplicate.
                let longest = overlaps.as_slice().iter().map(|o| o.on_a.length()).fold(0.0, f64::max);
                let fine = overlaps.relation() == Relation::Apart || longest < 0.06;
                prop_assert!(fine, "{longest} {:?}", overlaps.relation());
            }
        }
    }

    #[test]
    fn what_a_view_saw_is_in_the_result(
        outline in outlines(), looks in looks(), sigma in 0.0..0.004_f64,
    ) {
        let views: Vec<_> = looks.iter().map(|l| see(&outline, l, sigma)).collect();
        let fused = fuse(&views);
        for curve in views.iter().flatten() {
            for n in curve.nodes() {
                let distance = |c: &Curve| c.foot(&n.position).distance;
                let nearest = fused.curves.iter().map(distance).fold(f64::INFINITY, f64::min);
                prop_assert!(nearest < fused.threshold + 0.03, "{nearest} from {n:?}");
            }
        }
    }

    #[test]
    fn curves_run_with_their_solid_on_the_left(
        outline in outlines(), looks in looks(), sigma in 0.0..0.008_f64,
    ) {
        let views: Vec<_> = looks.iter().map(|l| see(&outline, l, sigma)).collect();
        for curve in &fuse(&views).curves {
            let along: f64 = curve.units().map(|u| u.start.coords.perp(&u.end.coords)).sum();
            prop_assert!(along > 0.0, "a curve runs the wrong way round the outline");
        }
    }
}

fn circle_arcs(count: u64, sigma: f64) -> Vec<Vec<Curve>> {
    let circle = Outline { bump: 0.0, lobes: 1.0 };
    let arc = |k: u64| Look { from: k as f64 * 2.4, sweep: 2.1, spacing: 0.02, seed: k };
    (0..count).map(|k| see(&circle, &arc(k), sigma)).collect()
}

#[test]
fn nothing_drifts_however_many_arcs_are_fused() {
    let sagitta = 0.02_f64.powi(2) / 8.0;
    for count in [10, 50, 100] {
        let fused = fuse(&circle_arcs(count, 0.0));
        assert_eq!(fused.curves.len(), 1, "{count} arcs");
        assert!(fused.curves[0].is_closed(), "{count} arcs");
        let errors: Vec<f64> = nodes(&fused).map(|n| n.position.coords.norm() - 1.0).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        assert!(mean.abs() < 0.1 * sagitta, "{count} arcs: {} sagittas", mean / sagitta);
    }
}

#[test]
fn more_views_mean_less_error() {
    let rms = |count: u64| {
        let fused = fuse(&circle_arcs(count, 0.005));
        let squares: Vec<f64> =
            nodes(&fused).map(|n| (n.position.coords.norm() - 1.0).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    // Nine times the views would be a third of the error if nothing but noise were left.
    assert!(rms(54) < 0.5 * rms(6), "{} against {}", rms(54), rms(6));
}

#[test]
fn rods_of_a_few_footprints_keep_their_solid_inside() {
    // Five to eight nodes of each view, at irregular angles.
    let ring = |perimeter: f64, seed: u64, count: u64| {
        let node = |k: u64| {
            let jitter = 0.5 * noise(seed, k);
            let angle = TAU * (k as f64 + jitter) / count as f64;
            let radius = perimeter / TAU * (1.0 + 0.02 * noise(seed, 100 + k));
            let position = Point2::new(radius * angle.cos(), radius * angle.sin());
            Node::at(position).with_footprint(1.0).with_sigma(0.01)
        };
        vec![Curve::new((0..count).map(node).collect(), true).unwrap()]
    };
    for views in [1, 3, 8] {
        for perimeter in [2.0, 2.5, 3.0, 4.0, 6.0] {
            let area = |draw: u64| {
                let view = |v: u64| ring(perimeter, 1000 * draw + v, 5 + (draw + v) % 4);
                let fused = fuse(&(0..views).map(view).collect::<Vec<_>>());
                if let [rod] = &fused.curves[..] { rod.signed_area() } else { None }
            };
            let areas: Vec<f64> = (0..100).filter_map(area).collect();
            let kept = areas.iter().filter(|area| **area > 0.0).count();
            let case = format!("{perimeter} footprints, {views} views");
            assert!(kept >= 95, "{kept} of 100 at {case}");
            assert_eq!(areas.len(), kept, "solid outside at {case}");
        }
    }
}

#[test]
fn scraps_beside_a_wall_that_was_seen_coarsely_go() {
    // Three views see a part of the wall closely, and one sees all of it from afar, a little off.
    let line = |from: f64, count: u64, step: f64, seed: u64, off: f64| {
        let node = |k: u64| {
            let position = Point2::new(from + step * k as f64, off + 0.0003 * noise(seed, k));
            Node::at(position).with_footprint(step as f32).with_sigma(0.0003)
        };
        vec![Curve::new((0..count).map(node).collect(), false).unwrap()]
    };
    for step in [0.01, 0.08, 0.12, 0.2] {
        let near = (0..3).map(|v| line(3.0 + 0.003 * v as f64, 300, 0.01, v, 0.0));
        let far = line(0.37 * step, (10.0 / step) as u64, step, 9, 0.005);
        let fused = fuse(&near.chain([far]).collect::<Vec<_>>());
        let length: f64 = fused.curves.iter().map(Curve::length).sum();
        let count = fused.curves.len();
        assert!(count == 1 && length > 9.7, "{count} curves, {length} of 10, a step of {step}");
    }
}

/// Both sides of a sheet of some thickness, each seen by several views.
fn sheet(thickness: f64, sigma: f64) -> Vec<Vec<Curve>> {
    let side = |seed: u64, upper: bool| {
        let node = |k: u64| {
            let (x, y) = (0.02 * k as f64, sigma * 3_f64.sqrt() * noise(seed, k));
            // The upper side runs back, so that the sheet is on the left of both.
            let position =
                if upper { Point2::new(4.0 - x, thickness + y) } else { Point2::new(x, y) };
            Node::at(position).with_sigma(sigma as f32).with_footprint(0.02)
        };
        Curve::new((0..200).map(node).collect(), false).unwrap()
    };
    (0..8).map(|v| vec![side(2 * v, false), side(2 * v + 1, true)]).collect()
}

#[test]
fn both_sides_of_a_thin_sheet_are_kept() {
    let sigma = 0.004;
    for thickness in [0.5 * sigma, sigma, 4.0 * sigma, 20.0 * sigma] {
        let fused = fuse(&sheet(thickness, sigma));
        assert!(fused.curves.iter().map(Curve::length).sum::<f64>() > 7.6, "{thickness}");
        // At its ends the sheet may be closed by a tip; between them, direction tells the sides.
        let mean = |forward: bool| {
            let units = fused.curves.iter().flat_map(|c| c.units().collect::<Vec<_>>());
            let side = units.filter(|u| (u.vector().x > 0.0) == forward);
            let inner = side.map(|u| u.at(0.5)).filter(|p| p.x > 0.3 && p.x < 3.7);
            let heights: Vec<f64> = inner.map(|p| p.y).collect();
            heights.iter().sum::<f64>() / heights.len() as f64
        };
        let found = mean(false) - mean(true);
        assert!((found - thickness).abs() < 0.1 * sigma, "{found} for {thickness}");
    }
}

#[test]
fn two_sheets_that_face_the_same_way_stay_two_beyond_the_threshold() {
    let sigma = 0.004;
    for apart in [10.0, 12.0, 16.0] {
        let layer = |seed: u64, height: f64| {
            let node = |k: u64| {
                let y = height + sigma * 3_f64.sqrt() * noise(seed, k);
                let position = Point2::new(0.02 * k as f64, y);
                Node::at(position).with_sigma(sigma as f32).with_footprint(0.02)
            };
            Curve::new((0..200).map(node).collect(), false).unwrap()
        };
        let views: Vec<_> =
            (0..8).map(|v| vec![layer(2 * v, 0.0), layer(2 * v + 1, apart * sigma)]).collect();
        let fused = fuse(&views);
        assert_eq!(fused.curves.len(), 2, "{apart} sigma apart");
        for n in nodes(&fused).filter(|n| (0.3..3.7).contains(&n.position.x)) {
            let off = n.position.y.abs().min((n.position.y - apart * sigma).abs());
            assert!(off < 2.0 * sigma, "{apart} sigma apart: {n:?}");
        }
    }
}

#[test]
fn a_view_that_comes_twice_changes_nothing() {
    let once = circle_arcs(3, 0.005);
    let twice: Vec<_> = once.iter().chain(&once).cloned().collect();
    assert_eq!(fuse(&once).curves, fuse(&twice).curves);
    assert_eq!(fuse(&once[..1]).curves, fuse(&[once[0].clone(), once[0].clone()]).curves);
}

#[test]
fn views_that_differ_in_weight_alone_may_come_in_any_order() {
    let view = &circle_arcs(1, 0.005)[0];
    let lighter = |c: &Curve| {
        let half = |n: &Node| n.with_weight(0.5);
        Curve::new(c.nodes().iter().map(half).collect(), c.is_closed()).unwrap()
    };
    let other: Vec<Curve> = view.iter().map(lighter).collect();
    let (a, b) = (fuse(&[view.clone(), other.clone()]), fuse(&[other, view.clone()]));
    assert_eq!(a.curves, b.curves);
}

#[test]
fn bridged_ground_is_marked() {
    let circle = Outline { bump: 0.0, lobes: 1.0 };
    let gap = 0.04;
    let look = Look { from: 0.0, sweep: TAU - gap, spacing: 0.02, seed: 5 };
    let fused = fuse(&[see(&circle, &look, 0.0)]);
    assert_eq!(fused.curves.len(), 1);
    assert!(fused.curves[0].is_closed());
    let unseen: Vec<&Node> = nodes(&fused).filter(|n| n.views.is_none()).collect();
    assert_eq!(unseen.len(), 1);
    assert!((unseen[0].position - circle.at(-0.5 * gap)).norm() < 0.03);
}

#[test]
fn nodes_without_accuracy_or_footprint_make_a_curve() {
    let circle = Outline { bump: 0.0, lobes: 1.0 };
    let ring = (0..300).map(|k| Node::at(circle.at(f64::from(k) * TAU / 300.0))).collect();
    let fused = fuse(&[vec![Curve::new(ring, true).unwrap()]]);
    assert_eq!(fused.curves.len(), 1);
    assert!(fused.curves[0].is_closed());
    let point = vec![Node::at(Point2::origin()); 5];
    assert!(fuse(&[vec![Curve::new(point, false).unwrap()]]).curves.is_empty());
}

#[test]
fn nothing_in_nothing_out() {
    assert!(fuse(&[]).curves.is_empty());
    assert!(fuse(&[Vec::new(), Vec::new()]).curves.is_empty());
}
