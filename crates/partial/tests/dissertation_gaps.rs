//! Gaps, range jumps and thick curves of the dissertation's method.
#![allow(clippy::unwrap_used, reason = "test code; shared strategies are outside test functions")]

mod dissertation_scene;

use dissertation_scene::*;
use proptest::prelude::*;
use std::cell::Cell;
use std::sync::Arc;
use transect_device::{DeviceFrame, Isometry3, Pixel, Point3, Vector3, View};
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_partial::dissertation::{DissertationOptions, partial_model};
use transect_partial::{EndReason, PartialCurve, PartialModel};
use transect_sensors::{AngularScan, ImagingRadar};

fn curves_on(model: &PartialModel, plane: PlaneIndex) -> &[PartialCurve] {
    let found = model.planes.iter().find(|p| p.plane == plane);
    found.map_or(&[], |p| p.curves.as_slice())
}

fn model(view: &View, planes: &PlaneFamily) -> PartialModel {
    partial_model(view, planes, &DissertationOptions::default()).unwrap()
}

/// A way to cut a curve: pixels that lie in a strip across it, and that are not far from it.
#[derive(Debug, Clone, Copy)]
struct Cut {
    at: Pixel,
    along_columns: bool,
    width: usize,
}

impl Cut {
    fn takes(&self, p: Pixel) -> bool {
        let (along, across, from, beside) = if self.along_columns {
            (p.col, p.row, self.at.col, self.at.row)
        } else {
            (p.row, p.col, self.at.row, self.at.col)
        };
        (from..from + self.width).contains(&along) && across.abs_diff(beside) < 12
    }
}

/// Whether all pixels up to three away are valid and close in space, too.
fn is_surrounded(seen: &Seen, p: Pixel) -> bool {
    let Some(here) = seen.view.point_in_sensor(p) else { return false };
    let near = |row: usize, col: usize| {
        let there = seen.view.point_in_sensor(Pixel::new(row, col));
        there.is_some_and(|there| (there - here).norm() < 10.0 * seen.rig.pixel())
    };
    let around = |at: usize| at.saturating_sub(3)..=at + 3;
    around(p.row).all(|row| around(p.col).all(|col| near(row, col)))
}

/// The first place from which a curve runs on for 24 pixels, more along the rows than along the
/// columns or the other way round; away from its ends, from rims and from other curves. Where it
/// turns within a gap, nobody can say how it continues.
fn cuttable(seen: &Seen, model: &PartialModel) -> Option<(PlaneIndex, Cut)> {
    for plane in &model.planes {
        let [curve] = plane.curves.as_slice() else { continue };
        for (start, run) in curve.pixels.windows(60).enumerate().step_by(7) {
            let (first, at, last) = (run[0], run[28], run[59]);
            let (rows, cols) = (first.row.abs_diff(last.row), first.col.abs_diff(last.col));
            // Four pixels along a steeper curve are more than four across.
            let gentle = |a: Pixel, b: Pixel| {
                let (rows, cols) = (a.row.abs_diff(b.row), a.col.abs_diff(b.col));
                10 * rows.min(cols) <= 7 * rows.max(cols)
            };
            let cut = Cut { at, along_columns: cols > rows, width: 7 };
            let node = |k: usize| curve.curve.nodes()[start + k].position;
            let turn = (node(28) - node(16)).angle(&(node(48) - node(36)));
            let gentle = gentle(first, last) && gentle(run[16], at) && gentle(at, run[44]);
            let straight = rows.max(cols) >= 24 && gentle && turn < 0.5;
            // The strip must not meet the curve a second time.
            let inside = curve.pixels.iter().filter(|p| cut.takes(**p)).count();
            let once = inside == run.iter().filter(|p| cut.takes(**p)).count();
            if straight && once && run[12..52].iter().all(|p| is_surrounded(seen, *p)) {
                return Some((plane.plane, cut));
            }
        }
    }
    None
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20))]

    #[test]
    fn a_curve_cut_by_one_to_four_missing_pixels_is_one_again_and_by_five_it_is_two(
        rig in rigs(), setting in settings(), axis in directions(), angle in 0.0..3.1_f64,
        normal in directions(),
    ) {
        let pose = rig.pose(axis * angle);
        let solids = setting.solids(&rig.line_of_sight(&pose), rig.scale);
        let whole = look(rig.frame.clone(), pose, &solids, |_| false);
        prop_assume!(whole.is_some());
        let seen = Seen { rig: rig.clone(), view: whole.unwrap(), solids: solids.clone() };
        let planes = family(&seen, normal, 0.1, 1);
        let before = model(&seen.view, &planes);
        let found = cuttable(&seen, &before);
        prop_assume!(found.is_some());
        let (plane, cut) = found.unwrap();
        let [curve] = curves_on(&before, plane) else { panic!() };
        // A curve along the border of what the sensor sees has gaps of its own.
        prop_assume!(curve.bridged.is_empty());
        for width in 1..=5 {
            let cut = Cut { width, ..cut };
            let view = look(rig.frame.clone(), pose, &solids, |p| cut.takes(p)).unwrap();
            let after = model(&view, &planes);
            let curves = curves_on(&after, plane);
            let bridged: usize = curves.iter().map(|c| c.bridged.len()).sum();
            if width <= 4 {
                prop_assert_eq!(curves.len(), 1, "{} missing", width);
                prop_assert_eq!(curves[0].curve.is_closed(), curve.curve.is_closed());
                prop_assert_eq!(bridged, 1);
                for unit in &curves[0].bridged {
                    let pixels = &curves[0].pixels;
                    let (a, b) = (*unit as usize, (*unit as usize + 1) % pixels.len());
                    let (a, b) = (pixels[a], pixels[b]);
                    let apart = a.row.abs_diff(b.row).max(a.col.abs_diff(b.col));
                    prop_assert!(apart >= width, "{a} to {b}");
                    let near = |p: Pixel| {
                        let (along, from) = if cut.along_columns { (p.col, cut.at.col) } else { (p.row, cut.at.row) };
                        along + 2 >= from && along <= from + width + 2
                    };
                    prop_assert!(near(a) && near(b), "{a} to {b} for {cut:?}");
                }
            } else {
                let two = if curve.curve.is_closed() { 1 } else { 2 };
                prop_assert_eq!((curves.len(), bridged), (two, 0), "{} missing", width);
                let reasons = curves.iter().flat_map(|c| c.ends.unwrap());
                let missing = reasons.filter(|r| *r == EndReason::MissingPixel).count();
                prop_assert!(missing >= 2);
            }
        }
    }
}

fn radar(columns: usize) -> Arc<dyn DeviceFrame> {
    let size = transect_device::ImageSize { rows: 48, cols: columns };
    let scan = |count: usize| AngularScan::from_radians(-0.0078 * (count - 1) as f64, 0.0156);
    Arc::new(ImagingRadar::new(size, scan(columns), scan(48)).unwrap())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    /// Two walls side by side, one 1 to 2 units behind the other; up to four columns at the jump
    /// between them are missing, more or less in each row.
    #[test]
    fn a_jump_is_never_bridged(
        step in 1.0..2.0_f64, tilt in -0.4..0.4_f64, slant in -0.4..0.4_f64, normal in directions(),
        missing in prop::collection::vec(0..=4_usize, 48), upright in any::<bool>(),
    ) {
        // The sensor looks along +x, its columns along y and its rows along z.
        let wall = Vector3::new(-1.0, tilt, slant).normalize();
        let (far, near) = (Point3::new(5.0 + step, 0.0, 0.0), Point3::new(5.0, 0.0, 0.0));
        let behind = |p: Pixel| if upright { p.col >= 24 } else { p.row >= 24 };
        let frame = radar(48);
        let ground = |on_plane| [Solid::Ground { on_plane, normal: wall }];
        let gap = |p: Pixel| {
            let (along, across) = if upright { (p.row, p.col) } else { (p.col, p.row) };
            let missing = missing[along];
            (24 - missing / 2..24 - missing / 2 + missing).contains(&across)
        };
        let pose = Isometry3::identity();
        let both = [far, near].map(|p| look(frame.clone(), pose, &ground(p), gap).unwrap());
        let value = |k: usize| {
            let p = Pixel::new(k / 48, k % 48);
            both[usize::from(!behind(p))].image().get(p).unwrap_or(f32::NAN)
        };
        let values = (0..48 * 48).map(value).collect();
        let image = transect_device::RangeImage::from_values(frame.size(), values).unwrap();
        let view = View::new("step", image, frame, pose, Some(0.0)).unwrap();
        let planes = planes_through(&Point3::new(5.0, 0.01, 0.02), normal, 0.2);
        let model = model(&view, &planes);
        for curve in model.planes.iter().flat_map(|p| &p.curves) {
            let sides = curve.pixels.iter().filter(|p| behind(**p)).count();
            prop_assert!(sides == 0 || sides == curve.pixels.len(), "{sides}");
        }
    }
}

/// A deterministic sequence of numbers between -1 and 1.
fn noise(seed: u64) -> impl Fn() -> f64 {
    let state = Cell::new(seed);
    move || {
        let next = state.get().wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        state.set(next);
        (next >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// A wall at x = 5, seen along x with noise of up to `spread`, and planes that pass it in the
/// middle, turned from it by an angle so small that one pixel changes the height by `rise`.
fn nearly_tangent(spread: f64, rise: f64, columns: usize) -> (View, PlaneFamily) {
    let frame = radar(columns);
    let next = noise(7);
    let wall = [Solid::Ground { on_plane: Point3::new(5.0, 0.0, 0.0), normal: -Vector3::x() }];
    let view = look_with_noise(frame, Isometry3::identity(), &wall, |_| false, |_| spread * next());
    let angle = rise / (5.0 * 0.0156);
    let normal = Vector3::new(angle.cos(), 0.0, angle.sin());
    // A plane between two rows, and no other.
    (view.unwrap(), planes_through(&Point3::new(5.0, 0.0, 0.002), normal, 50.0))
}

#[test]
fn a_thick_curve_becomes_one_pixel_wide_and_keeps_its_ends() {
    // Noise of up to 1.9 rows: labels are random in four rows, certain in all others.
    let (view, planes) = nearly_tangent(0.0019, 0.001, 64);
    let options = DissertationOptions { thickness: 0, ..Default::default() };
    let thick = partial_model(&view, &planes, &options).unwrap();
    let thick = thick.planes.first().map_or(0, |p| p.curves.len());
    assert!(thick > 1, "{thick} pieces before thinning");
    let thin = model(&view, &planes);
    let [curve] = curves_on(&thin, PlaneIndex(0)) else { panic!("one piece after thinning") };
    assert_eq!(curve.ends, Some([EndReason::ImageBorder; 2]));
    assert!(curve.bridged.is_empty());
    let pixels = &curve.pixels;
    let mut at_border = [pixels[0].col, pixels[pixels.len() - 1].col];
    at_border.sort_unstable();
    assert_eq!(at_border, [0, 63], "from end to end");
    // Where thinning moved borders, the plane may pass no pair of a few columns.
    for pair in pixels.windows(2) {
        assert!(pair[0].row.abs_diff(pair[1].row) <= 4 && pair[0].col.abs_diff(pair[1].col) <= 5);
    }
}

#[test]
fn noise_near_tangency_falls_into_far_fewer_pieces_when_thinned() {
    let (view, planes) = nearly_tangent(0.004, 0.001, 256);
    let pieces = |thickness| {
        let options = DissertationOptions { thickness, ..Default::default() };
        let model = partial_model(&view, &planes, &options).unwrap();
        model.planes.iter().map(|p| p.curves.len()).sum::<usize>()
    };
    let (before, after) = (pieces(0), pieces(4));
    println!("pieces before and after thinning: {before}, {after}");
    assert!(before > 3 * after, "{before} before, {after} after");
}
