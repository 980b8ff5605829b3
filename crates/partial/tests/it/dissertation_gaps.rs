//! Gaps, range jumps and thick curves of the dissertation's method.

use crate::dissertation_scene::*;
use crate::gaps::{bridged, curves_on, radar};
use proptest::prelude::*;
use std::cell::Cell;
use transect_device::{Isometry3, Point3, Vector3, View};
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_partial::dissertation::{DissertationOptions, partial_model};
use transect_partial::{EndReason, PartialModel};

fn model(view: &View, planes: &PlaneFamily) -> PartialModel {
    partial_model(view, planes, &DissertationOptions::default()).unwrap()
}

gap_laws!(model);

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
/// middle. They are turned from it by an angle so small that one pixel changes the height by
/// `rise`.
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
    let mut options = DissertationOptions::default();
    options.thickness = 0;
    let thick = partial_model(&view, &planes, &options).unwrap();
    let thick = thick.planes.first().map_or(0, |p| p.curves.len());
    assert!(thick > 1, "{thick} pieces before thinning");
    let thin = model(&view, &planes);
    let [curve] = curves_on(&thin, PlaneIndex(0)) else { panic!("one piece after thinning") };
    assert_eq!(curve.curve.ends(), [Some(EndReason::ImageBorder); 2]);
    assert!(bridged(curve).is_empty());
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
        let mut options = DissertationOptions::default();
        options.thickness = thickness;
        let model = partial_model(&view, &planes, &options).unwrap();
        model.planes.iter().map(|p| p.curves.len()).sum::<usize>()
    };
    let (before, after) = (pieces(0), pieces(4));
    println!("pieces before and after thinning: {before}, {after}");
    assert!(before > 3 * after, "{before} before, {after} after");
}
