//! The dissertation's method: labels and codes against those of one pass, curves against solids.

use crate::dissertation_scene::*;
use crate::gaps::bridged;
use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{
    ImageSize, Neighbour, PairGeometry, Pixel, Point3, SensorPlane, Vector3, View,
};
use transect_geometry::{Node, PlaneFamily, PlaneIndex, StraightGuide, Vector2};
use transect_partial::dissertation::{
    Code, DirectionRule, DissertationOptions, JumpTest, Label, PlaneImage, code_image, label_image,
    partial_model,
};
use transect_partial::one_pass::{self, OnePassOptions};
use transect_partial::subpixel::Subpixel;
use transect_partial::{BreakRule, EndReason, PartialCurve, PartialModel, SectionAxes};
use transect_sensors::{AngularScan, ImagingRadar, PointGrid, RayStarts};

/// Levels of a view's pixels as one pass has them, row-major; NaN where missing.
fn one_pass_levels(view: &View, axes: &SectionAxes) -> Vec<f32> {
    let size = view.frame().size();
    let mut levels = vec![0.0; size.pixels()];
    for (row, out) in levels.chunks_mut(size.cols).enumerate() {
        view.frame().form_row(view.image(), row, axes.level(), out);
    }
    levels
}

/// How far a level must be from a plane for both methods to agree on its label. It is the rounding
/// of a level to `f32`, 2⁻²⁴ of it, and that of two ways of computing it in `f64`.
fn bound(level: f32) -> f64 {
    2_f64.powi(-24) * f64::from(level).abs() + 1e-9
}

fn is_clear(level: f32, k: i32) -> bool {
    (f64::from(level) - f64::from(k)).abs() > bound(level)
}

fn pixels(size: ImageSize) -> impl Iterator<Item = Pixel> {
    size.all_pixels()
}

/// Levels of the planes that a view crosses, from the axes' base: at most five of them.
fn some_levels(view: &View, axes: &SectionAxes) -> Vec<i32> {
    let levels = one_pass_levels(view, axes);
    let valid = || levels.iter().copied().filter(|l| !l.is_nan());
    let (low, high) = (valid().fold(f32::MAX, f32::min), valid().fold(f32::MIN, f32::max));
    let all: Vec<i32> = (low.floor() as i32 - 1..=high.ceil() as i32).collect();
    all.iter().copied().step_by(all.len().div_ceil(5)).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn labels_and_codes_are_those_of_one_pass(
        seen in seen(0.03), normal in directions(), interval in 0.05..0.4, kind in 0..3_u8,
    ) {
        let planes = family(&seen, normal, interval, kind);
        let (view, frame) = (&seen.view, seen.view.frame());
        let axes = SectionAxes::new(view, &planes).unwrap();
        let levels = one_pass_levels(view, &axes);
        let size = frame.size();
        let level = |p: Pixel| levels[p.row * size.cols + p.col];
        let JumpTest::ScaleFree { max_incidence_rad, .. } = JumpTest::default() else { panic!() };
        let rule = BreakRule::new(max_incidence_rad, 0.0);
        let pairs = |neighbour| {
            let mut row = vec![PairGeometry::MISSING; size.cols];
            let rows = 0..size.rows;
            rows.flat_map(|i| {
                frame.pair_row(view.image(), i, neighbour, &mut row);
                row.clone()
            }).collect::<Vec<_>>()
        };
        let (up, left) = (pairs(Neighbour::Up), pairs(Neighbour::Left));
        for k in some_levels(view, &axes) {
            let labels = label_image(view, &axes, k);
            let codes = code_image(view, &axes, k, JumpTest::default(), 0.0);
            let high = |p: Pixel| level(p).ceil() as i32 > k;
            for p in pixels(size) {
                if level(p).is_nan() {
                    prop_assert_eq!(labels.get(p), None);
                    prop_assert_eq!(codes.get(p), Code::NONE);
                } else if is_clear(level(p), k) {
                    prop_assert_eq!(labels.get(p) == Some(Label::High), high(p), "{}", p);
                    let differs = |pair: &PairGeometry, neighbour| {
                        let other = frame.neighbour(p, neighbour);
                        let other = other.filter(|o| !level(*o).is_nan());
                        let clear = other.is_none_or(|o| is_clear(level(o), k));
                        let differs = other.is_some_and(|o| high(o) != high(p));
                        (clear, differs && rule.holds(pair))
                    };
                    let at = p.row * size.cols + p.col;
                    let (clear_up, row) = differs(&up[at], Neighbour::Up);
                    let (clear_left, column) = differs(&left[at], Neighbour::Left);
                    if clear_up && clear_left {
                        prop_assert_eq!(codes.get(p), Code::new(row, column), "{}", p);
                    }
                }
            }
        }
    }

    #[test]
    fn the_printed_label_is_the_same_or_the_complement_by_where_the_ray_starts(
        seen in seen(0.0), normal in directions(), interval in 0.1..0.4,
    ) {
        let planes = family(&seen, normal, interval, 1);
        let (view, frame) = (&seen.view, seen.view.frame());
        let axes = SectionAxes::new(view, &planes).unwrap();
        for k in some_levels(view, &axes) {
            let labels = label_image(view, &axes, k);
            let plane = axes.sensor_plane(k);
            let image = PlaneImage::new(frame, &plane);
            let height = |p: &Point3| plane.normal.dot(&p.coords) - plane.offset;
            for p in pixels(frame.size()) {
                let Some(point) = view.point_in_sensor(p) else { continue };
                let ray = frame.ray(p).unwrap();
                let (start, end) = (height(&ray.start), height(&point));
                // f32 ranges and table lookups: too close to say.
                if start.abs() < 1e-6 * seen.rig.scale || end.abs() < 1e-4 * seen.rig.scale {
                    continue;
                }
                // Some sensors see only part of their rays; there a plane may be met unseen.
                let ahead = -start / plane.normal.dot(&ray.direction);
                if ahead > 0.0 && image.get(p).is_infinite() && ahead < (point - ray.start).norm() {
                    continue;
                }
                let printed = image.is_before(p, f64::from(view.image().get(p).unwrap()));
                prop_assert_eq!(printed, (start > 0.0) != (end > 0.0));
                let high = labels.get(p) == Some(Label::High);
                prop_assert_eq!(printed, if start > 0.0 { !high } else { high });
            }
        }
    }
}

/// Every unit's left is inside: what is compared, and where not, stands in the test below.
fn check_sides(
    seen: &Seen,
    planes: &PlaneFamily,
    plane: PlaneIndex,
    curve: &PartialCurve,
) -> Result<usize, TestCaseError> {
    let (pixel, frame) = (seen.rig.pixel(), planes.frame(plane));
    let mut checked = 0;
    let nodes = curve.curve.nodes();
    if nodes.len() <= 4 {
        return Ok(0);
    }
    for (i, unit) in curve.curve.units().enumerate() {
        let steepest = [&nodes[i], &nodes[(i + 1) % nodes.len()]]
            .map(|node| node.tan_incidence.map_or(0.0, f64::from))
            .into_iter()
            .fold(0.0, f64::max);
        let v = unit.vector();
        let spacing = pixel * steepest.hypot(1.0);
        if v.norm() < 0.3 * spacing {
            continue;
        }
        let left = Vector2::new(-v.y, v.x).normalize();
        let at = |steps: f64| {
            let p = unit.at(0.5) + left * (steps * pixel);
            distance(&seen.solids, &frame.world_from_plane(&p))
        };
        let (inside, outside) = (at(1.0), at(-1.0));
        if (outside - inside).abs() > 0.2 * pixel {
            prop_assert!(inside < outside, "{inside} {outside} at {}", unit.at(0.5));
            checked += 1;
        }
        if nodes.len() > 12 {
            let deepest = [0.5, 1.0, 2.0].map(at).into_iter().fold(f64::INFINITY, f64::min);
            // A plane that touches a solid between two samples cuts a section as shallow as the
            // sagitta of their chord, on the tightest curve: pixel² / (8 · 0.3).
            let sagitta = 0.42 * pixel * pixel / seen.rig.scale;
            prop_assert!(deepest < sagitta, "{deepest} at {}", unit.at(0.5));
        }
    }
    Ok(checked)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Not compared are units shorter than a third of the distance of two samples on the surface.
    /// Their direction is the zigzag of two kinds of pairs. Curves of up to four nodes may be
    /// nothing else, so they are not compared either. Nor are places where both sides are at the
    /// same depth, as on a plane that touches the solid. In curves of up to 12 nodes, the left
    /// need not lie inside.
    #[test]
    fn the_point_to_the_left_of_every_curve_is_inside(
        seen in seen(0.03), normal in directions(), interval in 0.05..0.3, kind in 0..3_u8,
        way in 0..4_usize, printed in any::<bool>(),
    ) {
        let planes = family(&seen, normal, interval, kind);
        // Solids are further apart than two of these.
        let printed = printed.then_some(JumpTest::Printed { threshold: 0.3 * seen.rig.scale });
        let jump = printed.unwrap_or_default();
        let options =
            { let mut options = DissertationOptions::default(); options.subpixel = Subpixel::ALL[way]; options.jump = jump; options };
        let model = partial_model(&seen.view, &planes, &options).unwrap();
        for plane in &model.planes {
            for curve in &plane.curves {
                check_sides(&seen, &planes, plane.plane, curve)?;
                check_ends(curve)?;
                if printed.is_none() {
                    check_attributes(&seen, &planes, plane.plane, curve)?;
                }
            }
        }
    }

    /// The samples are the same, so are the curves; F is not asked for.
    #[test]
    fn point_grids_have_the_curves_of_their_sensors(
        seen in seen(0.03).prop_filter("one viewpoint", has_one_viewpoint), normal in directions(),
        interval in 0.05..0.3, kind in 0..3_u8, way in 0..4_usize, printed in any::<bool>(),
    ) {
        let planes = family(&seen, normal, interval, kind);
        let grid = as_point_grid(&seen);
        let mut options = DissertationOptions::default();
        options.subpixel = Subpixel::ALL[way];
        let rules = [DirectionRule::PlanePoints, DirectionRule::Codes];
        options.direction = rules[usize::from(printed)];
        let model = partial_model(&grid.view, &planes, &options).unwrap();
        for plane in &model.planes {
            for curve in &plane.curves {
                check_attributes(&grid, &planes, plane.plane, curve)?;
                if !printed {
                    check_sides(&grid, &planes, plane.plane, curve)?;
                }
            }
        }
        let of_sensor = partial_model(&seen.view, &planes, &options).unwrap();
        let nodes = |model| curves(model).map(|c| c.curve.nodes().len()).sum::<usize>();
        // Range jumps are told in f32 by one of the two, and in f64 by the other.
        let (here, there) = (nodes(&model), nodes(&of_sensor));
        prop_assert!(here.abs_diff(there) <= 2 + there / 50, "{here} nodes, {there} of the sensor");
    }

    #[test]
    fn both_direction_rules_agree(
        seen in seen(0.02), normal in directions(), interval in 0.05..0.3, kind in 0..3_u8,
    ) {
        let planes = family(&seen, normal, interval, kind);
        let model = |direction| {
            let mut options = DissertationOptions::default(); options.direction = direction;
            partial_model(&seen.view, &planes, &options).unwrap()
        };
        let (points, codes) = (model(DirectionRule::PlanePoints), model(DirectionRule::Codes));
        for (a, b) in curves(&points).zip(curves(&codes)) {
            // Shorter curves have too few pixels on their right for the printed rule.
            if a.curve.nodes().len() > 8 {
                prop_assert_eq!(&a.curve, &b.curve);
            }
        }
    }
}

/// Distance along a pixel's ray between its sample and a plane, worked out in space.
fn apart(view: &View, plane: &SensorPlane, p: Pixel) -> Option<f64> {
    let (ray, point) = (view.frame().ray(p)?, view.point_in_sensor(p)?);
    let ahead = plane.offset - plane.normal.dot(&ray.start.coords);
    let range = ahead / plane.normal.dot(&ray.direction);
    (range > 0.0).then(|| (range - (point - ray.start).norm()).abs())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_printed_jump_test_asks_both_sides_of_a_border(
        seen in seen(0.03), normal in directions(), interval in 0.1..0.4, share in 0.02..0.3,
    ) {
        let planes = family(&seen, normal, interval, 1);
        let (view, frame) = (&seen.view, seen.view.frame());
        let axes = SectionAxes::new(view, &planes).unwrap();
        let threshold = share * seen.rig.scale;
        for k in some_levels(view, &axes) {
            let labels = label_image(view, &axes, k);
            let codes = code_image(view, &axes, k, JumpTest::Printed { threshold }, 0.0);
            let plane = axes.sensor_plane(k);
            for p in pixels(frame.size()) {
                for neighbour in [Neighbour::Up, Neighbour::Left] {
                    let other = frame.neighbour(p, neighbour);
                    let Some(other) = other.filter(|o| labels.get(*o).is_some()) else { continue };
                    let both = [p, other].map(|p| apart(view, &plane, p));
                    let both = both.map(|d| d.unwrap_or(f64::INFINITY));
                    // Tables and f32 values round; some sensors do not see all of their rays.
                    let seen_at = [p, other].iter().all(|p| {
                        let value = frame.plane_value(*p, &plane);
                        value.and_then(|v| frame.point(*p, v)).is_some()
                    });
                    let close = both.iter().any(|d| (d - threshold).abs() < 1e-6 * threshold);
                    if close || (!seen_at && both.iter().all(|d| *d < threshold)) {
                        continue;
                    }
                    let differ = labels.get(p).is_some() && labels.get(p) != labels.get(other);
                    let expected = differ && both.iter().all(|d| *d < threshold);
                    prop_assert_eq!(codes.get(p).crosses(neighbour), expected, "{}", p);
                }
            }
        }
    }

    /// One pass has more nodes: it ends curves on the diagonals of cells with a missing pixel.
    #[test]
    fn nodes_are_those_of_one_pass(
        seen in seen(0.02), normal in directions(), interval in 0.1..0.3,
    ) {
        let planes = family(&seen, normal, interval, 1);
        let mut options = DissertationOptions::default(); options.gap = 0; options.thickness = 0;
        let model = partial_model(&seen.view, &planes, &options).unwrap();
        let mut linear = OnePassOptions::default(); linear.subpixel = Subpixel::Cartesian;
        let other = one_pass::partial_model(&seen.view, &planes, &linear);
        let other = other.unwrap();
        // In f32 a level of 28 is known to 2e-6 of an interval. Where the plane cuts the line of
        // two samples at a small angle, a node is known to many times that.
        let same = 1e-3 * seen.rig.pixel();
        for plane in &model.planes {
            let there = other.planes.iter().find(|p| p.plane == plane.plane);
            let nodes: Vec<_> =
                there.iter().flat_map(|p| &p.curves).flat_map(|c| c.curve.nodes()).collect();
            for node in plane.curves.iter().flat_map(|c| c.curve.nodes()) {
                let near = |n: &&&Node| (n.position - node.position).norm() < same;
                prop_assert!(nodes.iter().find(near).is_some(), "{}", node.position);
            }
        }
    }
}

fn curves(model: &PartialModel) -> impl Iterator<Item = &PartialCurve> {
    model.planes.iter().flat_map(|p| &p.curves)
}

fn has_one_viewpoint(seen: &Seen) -> bool {
    let frame = &seen.rig.frame;
    let start = |row, col| frame.ray(Pixel::new(row, col)).map(|ray| ray.start);
    let size = frame.size();
    start(0, 0).is_some() && start(0, 0) == start(size.rows - 1, size.cols - 1)
}

/// The same view as a grid of points, which has no inverse mapping.
fn as_point_grid(seen: &Seen) -> Seen {
    let (view, size) = (&seen.view, seen.view.image().size());
    let missing = Point3::new(f64::NAN, f64::NAN, f64::NAN);
    let points = pixels(size).map(|p| view.point_in_sensor(p).unwrap_or(missing)).collect();
    let start = view.frame().ray(Pixel::new(0, 0)).unwrap().start;
    let (grid, image) = PointGrid::new(size, points, RayStarts::Viewpoint(start)).unwrap();
    let pose = *view.world_from_sensor();
    let view = View::new("grid", image, Arc::new(grid), pose, view.sigma()).unwrap();
    Seen { rig: seen.rig.clone(), view, solids: seen.solids.clone() }
}

/// One pixel per node, ends if open.
fn check_ends(curve: &PartialCurve) -> Result<(), TestCaseError> {
    prop_assert_eq!(curve.pixels.len(), curve.curve.nodes().len());
    prop_assert_eq!(curve.curve.ends() == [None; 2], curve.curve.is_closed());
    Ok(())
}

/// Samples beside their nodes, and normals that are the solid's. The printed jump test lets a
/// normal's samples lie on two solids.
fn check_attributes(
    seen: &Seen,
    planes: &PlaneFamily,
    plane: PlaneIndex,
    curve: &PartialCurve,
) -> Result<(), TestCaseError> {
    let nodes = curve.curve.nodes();
    let frame = planes.frame(plane);
    for (node, pixel) in nodes.iter().zip(&curve.pixels) {
        let normal = &node.normal;
        let in_world = frame.world_from_plane(&node.position);
        let sample = seen.view.point_in_sensor(*pixel).unwrap();
        let sample = seen.view.world_from_sensor() * sample;
        let ray = seen.view.frame().ray(*pixel).unwrap().direction;
        let true_normal = self::normal(&seen.solids, &sample);
        let cos = -(seen.view.world_from_sensor() * ray).dot(&true_normal);
        prop_assert!((sample - in_world).norm() < 6.0 * seen.rig.pixel() / cos.max(0.1));
        let normal = normal.unwrap_or_default().cast::<f64>();
        let normal =
            frame.x_axis() * normal.x + frame.y_axis() * normal.y + frame.normal() * normal.z;
        if normal.norm() > 0.0 && cos > 0.6 {
            prop_assert!((normal.norm() - 1.0).abs() < 1e-5);
            // The normal of the smallest ball turns by this angle from one ray to the next. The
            // angle ends at the ball's outline.
            let next =
                (1.0 - cos * cos).max(0.0).sqrt() + seen.rig.pixel() / (0.3 * seen.rig.scale);
            let turn = next.min(1.0).asin() - cos.min(1.0).acos();
            prop_assert!(normal.dot(&true_normal) > turn.cos().min(0.9), "{normal} {true_normal}");
        }
    }
    Ok(())
}

/// A full circle of columns inside a round room, 40 rows.
fn room(dropped: impl Fn(Pixel) -> bool, flip: bool) -> (View, PlaneFamily) {
    let size = ImageSize { rows: 40, cols: 120 };
    let step = std::f64::consts::TAU / size.cols as f64 * if flip { -1.0 } else { 1.0 };
    let theta = AngularScan::from_radians(0.4, step);
    let phi = AngularScan::from_radians(-0.8, 0.041);
    let radar = Arc::new(ImagingRadar::new(size, theta, phi).unwrap());
    let on_axis = Point3::new(0.5, -0.3, 0.0);
    let solids = [Solid::Room { on_axis, axis: Vector3::z(), radius: 3.0 }];
    let view = look(radar, transect_device::Isometry3::identity(), &solids, dropped).unwrap();
    let guide = StraightGuide::along(Vector3::new(0.1, 0.2, 1.0)).unwrap();
    (view, PlaneFamily::new(guide, 0.0, 0.25).unwrap())
}

#[test]
fn full_circles_are_closed_across_the_seam() {
    for flip in [false, true] {
        for subpixel in Subpixel::ALL {
            let (view, planes) = room(|_| false, flip);
            let mut options = DissertationOptions::default();
            options.subpixel = subpixel;
            let model = partial_model(&view, &planes, &options).unwrap();
            // Plane 0 passes through the sensor, where no ray meets it.
            for k in -2..=2 {
                let plane = model.planes.iter().find(|p| p.plane == PlaneIndex(k)).unwrap();
                let [ring] = plane.curves.as_slice() else { panic!("plane {k}") };
                assert!(ring.curve.is_closed() && bridged(ring).is_empty(), "plane {k}");
                let area = ring.curve.signed_area().unwrap();
                // The room is a hole in the solid: clockwise; cut obliquely, 0.07 of a right angle.
                let circle = std::f64::consts::PI * 9.0 * 1.05_f64.sqrt();
                assert!((area + circle).abs() < 0.01 * circle, "{subpixel} plane {k}: {area}");
            }
        }
    }
}

#[test]
fn a_ring_cut_at_the_seam_is_closed_again_and_marked() {
    for missing in 1..=5_usize {
        let cut = |p: Pixel| (p.col + 2) % 120 < missing;
        let (view, planes) = room(cut, false);
        let model = partial_model(&view, &planes, &DissertationOptions::default()).unwrap();
        let plane = model.planes.iter().find(|p| p.plane == PlaneIndex(1)).unwrap();
        let [ring] = plane.curves.as_slice() else { panic!("{missing} missing") };
        assert_eq!(ring.curve.is_closed(), missing <= 4, "{missing} missing");
        assert_eq!(bridged(ring).len(), usize::from(missing <= 4), "{missing} missing");
        if missing > 4 {
            assert_eq!(ring.curve.ends(), [Some(EndReason::MissingPixel); 2]);
        }
    }
}

#[test]
fn footprints_at_open_ends_are_those_of_one_pass() {
    let size = crate::common::SIZE;
    let scan =
        |step: f64, count: usize| AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step);
    let radar = ImagingRadar::new(size, scan(0.016, size.cols), scan(0.004, size.rows)).unwrap();
    let radar = Arc::new(radar);
    let pose = crate::common::pose_towards_origin(radar.as_ref(), 0.3, 0.1, 0.0);
    let ball = crate::common::Ball { centre: Point3::origin(), radius: 2.0 };
    let view = crate::common::look(radar, pose, &[ball], &[]).unwrap();
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.11, 0.4).unwrap();
    let printed = partial_model(&view, &planes, &DissertationOptions::default()).unwrap();
    let model = one_pass::partial_model(&view, &planes, &OnePassOptions::default()).unwrap();
    let mut compared = 0;
    for plane in &printed.planes {
        let others = model.planes.iter().filter(|p| p.plane == plane.plane);
        let others: Vec<&Node> =
            others.flat_map(|p| &p.curves).flat_map(|c| c.curve.nodes()).collect();
        let long = plane.curves.iter().map(|c| &c.curve).filter(|c| c.nodes().len() > 12);
        let open = long.filter(|c| !c.is_closed());
        for node in open.flat_map(|c| c.nodes().iter().skip(1).take(3)) {
            let away = |n: &&&Node| (n.position - node.position).norm();
            let Some(same) = others.iter().min_by(|a, b| away(a).total_cmp(&away(b))) else {
                continue;
            };
            let ratio = f64::from(node.footprint) / f64::from(same.footprint);
            assert!((0.8..1.25).contains(&ratio), "{:?}: {ratio}", node.position);
            compared += 1;
        }
    }
    assert!(compared > 12, "{compared}");
}
