//! One pass against the slow, obvious way, and against solids whose inside is known.

use crate::common::{Ball, views};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::sync::Arc;
use transect_device::{ImageSize, Isometry3, Neighbour, Pixel, Point3, View};
use transect_geometry::{PlaneFamily, Point2, StraightGuide, Vector2, Vector3};
use transect_partial::one_pass::{OnePassOptions, partial_model};
use transect_partial::subpixel::Subpixel;
use transect_partial::{BreakRule, PartialModel, SectionAxes};
use transect_sensors::{AngularScan, ImagingRadar, PointGrid, RayStarts};

/// A directed segment, rounded so that equal ones compare equal: plane, start, end.
type Segment = (i64, [i64; 4]);

fn segment(plane: i64, a: Point2, b: Point2) -> Option<Segment> {
    let round = |v: f64| (v * 1e9).round() as i64;
    let ends = [round(a.x), round(a.y), round(b.x), round(b.y)];
    (ends[..2] != ends[2..]).then_some((plane, ends))
}

fn segments_of(model: &PartialModel) -> Vec<Segment> {
    let mut all = Vec::new();
    for plane in &model.planes {
        for unit in plane.curves.iter().flat_map(|c| c.curve.units().collect::<Vec<_>>()) {
            all.extend(segment(plane.plane.0, unit.start, unit.end));
        }
    }
    all.sort_unstable();
    all
}

/// The per-plane method: every cell of every plane on its own, nothing shared, nothing linked.
struct PerPlane<'a> {
    view: &'a View,
    axes: SectionAxes,
    rule: BreakRule,
}

impl PerPlane<'_> {
    fn level(&self, p: Pixel) -> f32 {
        let cols = self.view.frame().size().cols;
        let mut row = vec![0.0; cols];
        self.view.frame().form_row(self.view.image(), p.row, self.axes.level(), &mut row);
        row[p.col]
    }

    fn joined(&self, p: Pixel, neighbour: Neighbour) -> bool {
        let frame = self.view.frame();
        let mut row = vec![transect_device::PairGeometry::MISSING; frame.size().cols];
        frame.pair_row(self.view.image(), p.row, neighbour, &mut row);
        self.rule.holds(&row[p.col])
    }

    fn vertex(&self, a: Pixel, b: Pixel, plane: i32) -> Point2 {
        let p = self.view.point_in_sensor(a).unwrap();
        let q = self.view.point_in_sensor(b).unwrap();
        let height = |x| self.axes.level().at(x) - f64::from(plane);
        let t = (height(&p) / (height(&p) - height(&q))).clamp(0.0, 1.0);
        self.axes.in_plane(&(p + (q - p) * t))
    }

    /// Walks around the valid corners of a cell; `ring` is in the order TL, TR, BR, BL.
    fn cell(
        &self,
        ring: &[(Pixel, f32)],
        open: &[bool],
        plane: i32,
        out: &mut Vec<(Point2, Point2)>,
    ) {
        let n = ring.len();
        let high = |k: usize| ring[k % n].1 > plane as f32;
        // Clockwise on screen, a curve (high on its left) leaves where high turns to low.
        let sides: Vec<usize> = (0..n).filter(|&k| high(k) != high(k + 1)).collect();
        let leaving: Vec<usize> = sides.iter().copied().filter(|&k| high(k)).collect();
        let mean = ring.iter().map(|r| f64::from(r.1)).sum::<f64>() / n as f64;
        for leave in leaving {
            // At a saddle the curve keeps to the low corner after it, or to the high one before.
            let step = if sides.len() == 4 && mean <= f64::from(plane) { n - 1 } else { 1 };
            let enter =
                (1..n).map(|s| (leave + s * step) % n).find(|k| sides.contains(k) && !high(*k));
            let enter = enter.unwrap();
            if open[enter] && open[leave] {
                let at = |k: usize| self.vertex(ring[k].0, ring[(k + 1) % n].0, plane);
                out.push((at(enter), at(leave)));
            }
        }
    }

    fn segments(&self, planes: std::ops::Range<i32>) -> Vec<Segment> {
        let size = self.view.frame().size();
        let mut all = Vec::new();
        let mirrored = self.view.frame().handedness() == transect_device::Handedness::ColumnsLeft;
        for row in 1..size.rows {
            for col in 1..size.cols {
                let corners = [(row - 1, col - 1), (row - 1, col), (row, col), (row, col - 1)];
                let pixels = corners.map(|(r, c)| Pixel::new(r, c));
                // Sides in ring order: top, right, bottom, left.
                let open = [
                    self.joined(pixels[1], Neighbour::Left),
                    self.joined(pixels[2], Neighbour::Up),
                    self.joined(pixels[2], Neighbour::Left),
                    self.joined(pixels[3], Neighbour::Up),
                ];
                let ring = pixels.map(|p| (p, self.level(p)));
                let broken = open.iter().filter(|o| !**o).count();
                // A corner whose two sides are both broken is left out.
                let lost = (0..4).find(|&k| !open[k] && !open[(k + 3) % 4]);
                let (ring, open) = match (broken, lost) {
                    (0 | 1, _) => (ring.to_vec(), open.to_vec()),
                    (2, Some(lost)) => {
                        let kept: Vec<_> = (0..4).filter(|&k| k != lost).map(|k| ring[k]).collect();
                        (kept, vec![true; 3])
                    }
                    _ => continue,
                };
                for plane in planes.clone() {
                    let mut found = Vec::new();
                    self.cell(&ring, &open, plane, &mut found);
                    for (a, b) in found {
                        let (a, b) = if mirrored { (b, a) } else { (a, b) };
                        all.extend(segment(self.axes.plane(plane).0, a, b));
                    }
                }
            }
        }
        all.sort_unstable();
        all
    }
}

fn planes(normal: Vector3, interval: f64) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), 0.0123, interval).unwrap()
}

fn normals() -> impl Strategy<Value = Vector3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter("has a direction", |v: &Vector3| v.norm() > 0.1)
}

/// How deep a point is inside the nearest ball surface; negative outside all.
fn depth(
    balls: &[Ball],
    planes: &PlaneFamily,
    plane: transect_geometry::PlaneIndex,
    p: &Point2,
) -> f64 {
    let world = planes.frame(plane).world_from_plane(p);
    let inside = |b: &Ball| b.radius - (world - b.centre).norm();
    balls.iter().map(inside).fold(f64::NEG_INFINITY, f64::max)
}

/// Radius of the circle in which a plane cuts the ball that is nearest to a point of it.
fn section_radius(
    balls: &[Ball],
    planes: &PlaneFamily,
    plane: transect_geometry::PlaneIndex,
    p: &Point2,
) -> f64 {
    let frame = planes.frame(plane);
    let world = frame.world_from_plane(p);
    let depth = |b: &Ball| b.radius - (world - b.centre).norm();
    let nearest = balls.iter().max_by(|a, b| depth(a).total_cmp(&depth(b)));
    nearest.map_or(0.0, |b| (b.radius.powi(2) - frame.height(&b.centre).powi(2)).max(0.0).sqrt())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn one_pass_finds_the_segments_of_the_per_plane_method(
        (view, _) in views(), normal in normals(), interval in 0.1..0.4,
    ) {
        let planes = planes(normal, interval);
        let mut options = OnePassOptions::default(); options.gap = 0; options.subpixel = Subpixel::Cartesian;
        let model = partial_model(&view, &planes, &options).unwrap();
        let axes = SectionAxes::new(&view, &planes).unwrap();
        let rule = BreakRule::new(options.max_incidence_rad, 0.0);
        let points = view.image().size().all_pixels().filter_map(|p| view.point_in_sensor(p));
        let levels = points.map(|p| axes.level().at(&p));
        let (low, high) = levels.fold((0.0_f64, 0.0_f64), |(a, b), l| (a.min(l), b.max(l)));
        let slow = PerPlane { view: &view, axes, rule };
        let expected = slow.segments(low.floor() as i32..high.ceil() as i32 + 1);
        prop_assert_eq!(segments_of(&model), expected);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_point_to_the_left_of_every_curve_is_inside(
        (view, balls) in views(), normal in normals(), interval in 0.05..0.3,
    ) {
        let planes = planes(normal, interval);
        let model = partial_model(&view, &planes, &OnePassOptions::default()).unwrap();
        for plane in &model.planes {
            for unit in plane.curves.iter().flat_map(|c| c.curve.units().collect::<Vec<_>>()) {
                let v = unit.vector();
                // Crossings of pairs in different directions lie on different chords of the ball,
                // up to a sagitta apart; a unit shorter than that has no direction to speak of.
                if v.norm() < 0.02 {
                    continue;
                }
                // Two pixel footprints at the ball: well beyond a chord's sagitta.
                let step = 0.06;
                let left = Vector2::new(-v.y, v.x).normalize() * step;
                let middle = unit.at(0.5);
                // Where a plane grazes a ball, the chords between samples may miss its small
                // section.
                if section_radius(&balls, &planes, plane.plane, &middle) < 0.25 {
                    continue;
                }
                let (inner, outer) = (middle + left, middle - left);
                let difference = depth(&balls, &planes, plane.plane, &inner)
                    - depth(&balls, &planes, plane.plane, &outer);
                prop_assert!(difference > -0.2 * step, "plane {} at {middle}", plane.plane);
            }
        }
    }

    #[test]
    fn curves_lie_on_the_surface_to_the_sampling_error(
        (view, balls) in views(), normal in normals(), interval in 0.05..0.3,
    ) {
        let planes = planes(normal, interval);
        // Chords of balls are inside; what is left of a cubic's error may be outside.
        for (subpixel, outside) in [(Subpixel::Cartesian, 1e-6), (Subpixel::FourPoint, 0.01)] {
            let mut options = OnePassOptions::default(); options.subpixel = subpixel;
            let model = partial_model(&view, &planes, &options).unwrap();
            for plane in &model.planes {
                for node in plane.curves.iter().flat_map(|c| c.curve.nodes()) {
                    let deep = depth(&balls, &planes, plane.plane, &node.position);
                    // The sagitta of the chord between two samples that a rim's footprint parts, on
                    // the smallest ball: (0.1 / cos 78°)² / (8 · 0.3).
                    prop_assert!((-outside..0.1).contains(&deep), "{deep} at {}", node.position);
                }
            }
        }
    }
}

/// A ball at the origin, seen by some sensor on the plane z = 0.
fn one_ball() -> View {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let frame = crate::common::frames().new_tree(&mut runner).unwrap().current();
    let pose = crate::common::pose_towards_origin(frame.as_ref(), 0.3, 0.0, 0.0);
    let ball = Ball { centre: transect_device::Point3::origin(), radius: 0.7 };
    crate::common::look(frame, pose, &[ball], &[]).unwrap()
}

#[test]
fn footprints_reach_from_node_to_node_on_uneven_grids() {
    for (theta_step, phi_step) in [(0.004, 0.024), (0.012, 0.012), (0.024, 0.004)] {
        let scan = |step: f64, count: usize| {
            AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step)
        };
        let (theta, phi) =
            (scan(theta_step, crate::common::SIZE.cols), scan(phi_step, crate::common::SIZE.rows));
        let radar = Arc::new(ImagingRadar::new(crate::common::SIZE, theta, phi).unwrap());
        let pose = crate::common::pose_towards_origin(radar.as_ref(), 0.3, 0.1, 0.0);
        let ball = Ball { centre: transect_device::Point3::origin(), radius: 2.0 };
        let view = crate::common::look(radar, pose, &[ball], &[]).unwrap();
        let planes = planes(Vector3::z(), 0.11);
        let model = partial_model(&view, &planes, &OnePassOptions::default()).unwrap();
        let curves = model
            .planes
            .iter()
            .flat_map(|p| &p.curves)
            .map(|c| &c.curve)
            .filter(|c| c.nodes().len() > 9);
        let mut checked = 0;
        for curve in curves {
            let step = curve.length() / curve.units().len() as f64;
            let sum: f64 = curve.nodes().iter().map(|n| f64::from(n.footprint)).sum();
            let footprint = sum / curve.nodes().len() as f64;
            assert!(footprint > 0.8 * step, "{footprint} for steps of {step}");
            checked += 1;
        }
        assert!(checked > 3, "{checked} curves");
    }
}

#[test]
fn a_plane_through_the_sensor_is_not_lost() {
    // There a comparison of the plane's range with the surface's sees nothing.
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.0, 1.0).unwrap();
    let model = partial_model(&one_ball(), &planes, &OnePassOptions::default()).unwrap();
    let curves: Vec<_> = model.planes.iter().map(|p| (p.plane.0, p.curves.len())).collect();
    assert_eq!(curves, [(0, 1)]);
}

#[test]
fn absurdly_dense_planes_are_refused() {
    let dense = planes(Vector3::z(), 1e-9);
    let error = partial_model(&one_ball(), &dense, &OnePassOptions::default()).unwrap_err();
    assert!(error.to_string().contains("is the interval in the right unit?"), "{error}");
}

/// A board of 0.1 m in a point grid; four of its points are metres off their rays.
#[test]
fn outliers_are_no_neighbours() {
    let size = ImageSize { rows: 40, cols: 50 };
    let outliers = [(20, 24), (20, 25), (21, 24), (21, 25)];
    for offset in [Vector3::new(2.0, 1.0, 3.0), Vector3::new(-0.4, 0.2, 0.1), Vector3::zeros()] {
        let point = |k: usize| {
            let (row, col) = (k / size.cols, k % size.cols);
            let on = Point3::new(col as f64 * 0.002 - 0.05, row as f64 * 0.002 - 0.04, 0.6);
            if outliers.contains(&(row, col)) { on + offset } else { on }
        };
        let points = (0..size.pixels()).map(point).collect();
        let (grid, image) =
            PointGrid::new(size, points, RayStarts::Viewpoint(Point3::origin())).unwrap();
        let pose = Isometry3::identity();
        let view = View::new("board", image, Arc::new(grid), pose, None).unwrap();
        let planes = PlaneFamily::new(StraightGuide::along(Vector3::y()).unwrap(), 0.0007, 0.004);
        let model = partial_model(&view, &planes.unwrap(), &OnePassOptions::default()).unwrap();
        let curves = model.planes.iter().flat_map(|p| &p.curves);
        let nodes = curves.map(|c| c.curve.nodes());
        let steps =
            nodes.flat_map(|n| n.windows(2)).map(|n| (n[1].position - n[0].position).norm());
        let longest = steps.fold(0.0, f64::max);
        println!("{:?}: longest segment {longest:.4}", offset.as_slice());
        assert!(longest > 0.0015 && longest < 0.004, "{:?}: {longest}", offset.as_slice());
    }
}
