//! What every node and every open end says of itself.

use crate::common::{SIZE, normals, planes_along, random_views, views};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Isometry3, Pixel, RangeImage, Vector3, View};
use transect_geometry::PlaneFamily;
use transect_partial::one_pass::{
    Effort, OnePassOptions, Workspace, partial_model, partial_model_with,
};
use transect_partial::{EndReason, PartialCurve, PartialModel};
use transect_sensors::{Intrinsics, LightStripe, Pinhole};

fn curves(model: &PartialModel) -> impl Iterator<Item = &PartialCurve> {
    model.planes.iter().flat_map(|p| &p.curves)
}

/// A wall at depth 2 seen by a camera, cut by upright planes; some pixels differ from it.
fn wall(gap: usize, cols: usize, change: impl Fn(usize, usize) -> f32) -> PartialModel {
    let rows = 12;
    let size = ImageSize { rows, cols };
    let values = (0..size.pixels()).map(|k| change(k / cols, k % cols)).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    let (cx, cy) = (0.5 * cols as f64, 0.5 * rows as f64);
    let camera = Pinhole::new(size, Intrinsics { fx: 40.0, fy: 40.0, cx, cy }).unwrap();
    let view =
        View::new("wall", image, Arc::new(camera), Isometry3::identity(), Some(0.0)).unwrap();
    let mut options = OnePassOptions::default();
    options.gap = gap;
    partial_model(&view, &planes_along(Vector3::x(), 0.11), &options).unwrap()
}

#[test]
fn ends_at_the_images_border_say_so() {
    let model = wall(0, 40, |_, _| 2.0);
    let ends: Vec<_> = curves(&model).map(|c| c.curve.ends()).collect();
    assert!(ends.len() > 10);
    assert!(ends.iter().all(|e| *e == [Some(EndReason::ImageBorder); 2]), "{ends:?}");
}

/// The largest number of 32 bits and beyond. Another surface begins behind the missing row.
#[test]
fn gaps_wider_than_the_image_are_as_wide_as_the_image() {
    let ends = |gap| {
        let depths = |row: usize| [2.0, f32::NAN, 5.0][row.min(7).saturating_sub(5)];
        let model = wall(gap, 40, |row, _| depths(row));
        curves(&model).map(|c| c.curve.ends()).collect::<Vec<_>>()
    };
    let is_jump = |ends: &[Option<EndReason>; 2]| ends.contains(&Some(EndReason::RangeJump));
    for gap in [i32::MAX as usize, usize::MAX >> 1] {
        assert_eq!(ends(gap), ends(12));
        assert!(ends(gap).iter().any(is_jump));
    }
}

/// A laser sheet whose stripe is behind the farthest distance at which the sensor sees it.
#[test]
fn values_without_a_point_are_an_error_that_states_them() {
    let frame = LightStripe::smart_eye().unwrap();
    let size = frame.size();
    // The last cell of the camera's row: the sheet and the camera's line meet behind the sensor,
    // or nowhere.
    let image = RangeImage::from_values(size, vec![9e8; size.pixels()]).unwrap();
    let view = View::new("far", image, Arc::new(frame), Isometry3::identity(), Some(0.0)).unwrap();
    let planes = planes_along(Vector3::x(), 0.11);
    let error = partial_model(&view, &planes, &OnePassOptions::default()).unwrap_err();
    let wanted = "the values of the image run from 900000000 to 900000000, and the sensor has no";
    assert!(error.to_string().starts_with(wanted), "{error}");
}

#[test]
fn ends_at_missing_pixels_and_at_range_jumps_say_so() {
    for (odd, reason) in [(f32::NAN, EndReason::MissingPixel), (5.0, EndReason::RangeJump)] {
        let model = wall(0, 40, |row, _| if row == 6 { odd } else { 2.0 });
        let mut inner = 0;
        for curve in curves(&model).filter(|c| c.pixels.iter().all(|p| p.row != 6)) {
            let mut ends = curve.curve.ends();
            let at_border = |p: &Pixel| p.row == 0 || p.row == 11;
            if !at_border(&curve.pixels[0]) {
                ends.reverse();
            }
            assert_eq!(ends, [EndReason::ImageBorder, reason].map(Some));
            inner += 1;
        }
        assert!(inner > 10, "{inner} curves");
    }
}

#[test]
fn ends_at_missing_pixels_that_hide_another_surface_are_range_jumps() {
    for (missing, expected) in [
        (6..7, EndReason::RangeJump),
        (5..9, EndReason::RangeJump),
        (4..9, EndReason::MissingPixel),
    ] {
        let behind = |row: usize| if row < 6 { 2.0 } else { 5.0 };
        let hole = |row: usize| if missing.contains(&row) { f32::NAN } else { behind(row) };
        let model = wall(4, 40, |row, _| hole(row));
        let ends = curves(&model).flat_map(|c| c.curve.ends());
        let mut ends: Vec<EndReason> = ends.map(Option::unwrap).collect();
        ends.retain(|end| *end != EndReason::ImageBorder);
        assert!(ends.len() > 10 && ends.iter().all(|end| *end == expected), "{ends:?}");
    }
}

/// How well the normals of a view's nodes agree with those of the balls, as cosines.
fn agreements(view: &View, balls: &[crate::common::Ball], planes: &PlaneFamily) -> Vec<f64> {
    let model = partial_model(view, planes, &OnePassOptions::default()).unwrap();
    let mut found = Vec::new();
    for plane in &model.planes {
        let frame = planes.frame(plane.plane);
        for curve in plane.curves.iter().filter(|c| c.curve.nodes().len() > 8) {
            for node in curve.curve.nodes() {
                let n = node.normal.unwrap().cast::<f64>();
                assert!((n.norm() - 1.0).abs() < 1e-5);
                let world = frame.world_from_plane(&node.position);
                let near = |b: &&crate::common::Ball| ((world - b.centre).norm() - b.radius).abs();
                let ball = balls.iter().min_by(|a, b| near(a).total_cmp(&near(b))).unwrap();
                let out = frame.x_axis() * n.x + frame.y_axis() * n.y + frame.normal() * n.z;
                let toward_sensor = view.world_from_sensor().translation.vector - world.coords;
                assert!(out.dot(&toward_sensor) > -0.05 * toward_sensor.norm());
                let height = frame.height(&ball.centre);
                // A small section is a few pixels long, and has no direction to speak of.
                if ball.radius.powi(2) - height.powi(2) > 0.25_f64.powi(2) {
                    found.push(out.dot(&(world - ball.centre).normalize()));
                }
            }
        }
    }
    found
}

#[test]
fn normals_point_out_of_the_balls() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let mut cosines = Vec::new();
    for _ in 0..100 {
        let (view, balls) = views().new_tree(&mut runner).unwrap().current();
        let normal = normals().new_tree(&mut runner).unwrap().current();
        cosines.extend(agreements(&view, &balls, &planes_along(normal, 0.1)));
    }
    cosines.sort_by(f64::total_cmp);
    let quantile = |share: f64| cosines[(share * cosines.len() as f64) as usize];
    assert!(cosines.len() > 2000, "{}", cosines.len());
    // Within 8° for half of the nodes; at rims the samples that tell the normal are far apart.
    let found = (quantile(0.5), quantile(0.05));
    assert!(found.0 > 0.99 && found.1 > 0.8, "{found:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_nodes_pixel_is_beside_it((view, _) in views(), normal in normals(), interval in 0.05..0.3) {
        let planes = planes_along(normal, interval);
        let model = partial_model(&view, &planes, &OnePassOptions::default()).unwrap();
        for plane in &model.planes {
            let frame = planes.frame(plane.plane);
            for curve in &plane.curves {
                prop_assert_eq!(curve.pixels.len(), curve.curve.nodes().len());
                prop_assert_eq!(curve.curve.ends() == [None; 2], curve.curve.is_closed());
                for (node, pixel) in curve.curve.nodes().iter().zip(&curve.pixels) {
                    let world = frame.world_from_plane(&node.position);
                    let sample = |p| view.point_in_sensor(p).map(|s| view.world_from_sensor() * s);
                    let apart = (sample(*pixel).unwrap() - world).norm();
                    // No farther than half of the longest pair the pixel may have.
                    let around = (-1..=1_isize).flat_map(|r| (-1..=1_isize).map(move |c| (r, c)));
                    let reach = around.filter_map(|(r, c)| {
                        let (row, col) = (pixel.row.checked_add_signed(r)?, pixel.col.checked_add_signed(c)?);
                        let other = sample(Pixel::new(row, col))?;
                        (row < SIZE.rows && col < SIZE.cols).then(|| (other - sample(*pixel).unwrap()).norm())
                    });
                    let reach = reach.fold(0.0, f64::max);
                    prop_assert!(apart <= 0.5 * reach + 1e-6, "{} of {}", apart, reach);
                }
            }
        }
    }

    #[test]
    fn the_workspace_and_the_effort_change_nothing(view in random_views(), interval in 0.05..0.3) {
        let planes = planes_along(Vector3::new(0.2, 0.3, 0.9), interval);
        let options = OnePassOptions::default();
        let fresh = partial_model(&view, &planes, &options).unwrap();
        let mut work = Workspace::default();
        for parts in [1, 3] {
            let effort = Effort { parts, ..Effort::default() };
            let again = partial_model_with(&view, &planes, &options, &effort, &mut work).unwrap();
            prop_assert_eq!(fresh.counts, again.counts);
            let nodes = |m: &PartialModel| curves(m).flat_map(|c| c.curve.nodes().to_vec()).collect::<Vec<_>>();
            prop_assert_eq!(nodes(&fresh), nodes(&again));
        }
    }
}
