//! Gaps, jumps and noise where counts say whether it is right.
//!
//! A camera looks along z at a ball (cut by missing columns), at a wall with a step (beside which
//! columns are missing), and at a noisy wall that planes nearly touch.

use crate::failure::Failure;
use crate::table::{print_grid, say};
use std::sync::Arc;
use transect_device::{ImageSize, Pixel, RangeImage, View};
use transect_geometry::{Isometry3, PlaneFamily, StraightGuide, Vector3};
use transect_partial::dissertation::DissertationOptions;
use transect_partial::one_pass::OnePassOptions;
use transect_partial::{Method, PartialModel, partial_model};
use transect_scene::{Noise, Scene, Shape, Solid};
use transect_sensors::{Intrinsics, Pinhole};

/// Most missing pixels that a curve is continued across.
const GAP: usize = 4;

/// Rows and columns.
const SIZE: usize = 128;

/// First missing column of a gap, and the one in front of which the step is.
const GAP_COLUMN: usize = 50;
const STEP_COLUMN: usize = 64;

/// How far the wall is behind its nearer half, and how far that is from the camera.
const STEP: f64 = 0.5;
const WALL: f64 = 3.0;

/// Prints the tables.
pub fn run() -> Result<(), Failure> {
    gaps()?;
    near_tangent()
}

fn methods() -> [(&'static str, Method); 2] {
    let mut one_pass = OnePassOptions::default();
    one_pass.gap = GAP;
    let mut dissertation = DissertationOptions::default();
    dissertation.gap = GAP;
    [("one_pass", Method::OnePass(one_pass)), ("dissertation", Method::Dissertation(dissertation))]
}

/// Curves across missing pixels, and at a step.
fn gaps() -> Result<(), Failure> {
    let middle = Isometry3::translation(0.0, 0.0, WALL);
    let ball = view(vec![Solid::new(Shape::ball(0.6)?, middle)?], 0.0)?;
    let step = view(vec![wall(WALL, 0.0)?, wall(WALL - STEP, -5.0)?], 0.0)?;
    // Neither plane holds the camera's axis or a line of pixels.
    let [across_ball, across_step] =
        [plane([0.1, 1.0, 0.2], 0.62)?, plane([0.1, 1.0, 0.02], 0.07)?];
    let mut lines = Vec::new();
    for (name, method) in methods() {
        for missing in 0..=GAP + 2 {
            let cut = partial_model(&without(&ball, GAP_COLUMN, missing)?, &across_ball, &method)?;
            let beside = STEP_COLUMN - missing / 2;
            let jump = partial_model(&without(&step, beside, missing)?, &across_step, &method)?;
            lines.push(vec![
                name.to_owned(),
                missing.to_string(),
                pieces(&cut).to_string(),
                bridged(&cut).to_string(),
                pieces(&jump).to_string(),
                on_both_sides(&jump).to_string(),
            ]);
        }
    }
    say(&format!("\nCurves cut by missing pixels, up to {GAP} of which are bridged:\n"));
    let heads = ["method", "missing", "pieces", "bridged", "pieces at a step", "across the step"];
    print_grid(&heads, &lines);
    Ok(())
}

/// Pieces of a section of a noisy wall, with and without the lines that noise alone makes.
fn near_tangent() -> Result<(), Failure> {
    let mut lines = Vec::new();
    for sigma in [0.003, 0.015] {
        let view = view(vec![wall(WALL, 0.0)?], sigma)?;
        for degrees in [0.0_f64, 1.0, 2.0, 5.0, 10.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let plane = plane([sin, 0.0, cos], WALL * cos)?;
            let mut line = vec![sigma.to_string(), format!("{degrees:.0}°")];
            for smooth in [false, true] {
                let mut options = OnePassOptions::default();
                options.smooth = smooth;
                let mut kept = options;
                kept.excursion_sigmas = 0.0;
                for options in [kept, options] {
                    let model = partial_model(&view, &plane, &Method::OnePass(options))?;
                    line.push(pieces(&model).to_string());
                }
            }
            lines.push(line);
        }
    }
    say("\nPieces on one plane at an angle to a noisy wall:\n");
    let heads = ["noise", "angle", "pieces", "noise left out", "pieces smoothed", "noise left out"];
    print_grid(&heads, &lines);
    Ok(())
}

/// A wall of ten by ten across the view, its front at a distance and its middle at some x.
fn wall(distance: f64, x: f64) -> Result<Solid, Failure> {
    const SIZE: f64 = 10.0;
    let middle = Isometry3::translation(x, 0.0, distance + 0.5);
    Ok(Solid::new(Shape::cuboid(Vector3::new(SIZE, SIZE, 1.0))?, middle)?)
}

fn view(solids: Vec<Solid>, sigma: f64) -> Result<View, Failure> {
    let centre = 0.5 * (SIZE as f64 - 1.0);
    let intrinsics = Intrinsics { fx: SIZE as f64, fy: SIZE as f64, cx: centre, cy: centre };
    let camera = Pinhole::new(ImageSize { rows: SIZE, cols: SIZE }, intrinsics)?;
    let noise = Noise { sigma, seed: 5, ..Noise::NONE };
    let scene = Scene::new(solids);
    Ok(scene.view("camera", Arc::new(camera), Isometry3::identity(), &noise, 0)?)
}

/// The one plane with this normal and offset that meets anything.
fn plane(normal: [f64; 3], offset: f64) -> Result<PlaneFamily, Failure> {
    Ok(PlaneFamily::new(StraightGuide::along(Vector3::from(normal))?, offset, 1e3)?)
}

/// The view without some columns.
fn without(view: &View, first: usize, count: usize) -> Result<View, Failure> {
    let (image, size) = (view.image(), view.frame().size());
    let kept = |k: usize| {
        let pixel = Pixel::new(k / size.cols, k % size.cols);
        let missing = (first..first + count).contains(&pixel.col);
        image.get(pixel).filter(|_| !missing).unwrap_or(f32::NAN)
    };
    let values = (0..size.pixels()).map(kept).collect();
    Ok(view.with_image(RangeImage::from_values(size, values)?)?)
}

fn pieces(model: &PartialModel) -> usize {
    model.planes.iter().map(|p| p.curves.len()).sum()
}

/// Units across missing pixels.
fn bridged(model: &PartialModel) -> usize {
    model.planes.iter().flat_map(|p| &p.curves).map(|c| c.bridged.len()).sum()
}

/// Curves that have nodes on both sides of the step.
fn on_both_sides(model: &PartialModel) -> usize {
    let curves = model.planes.iter().flat_map(|p| &p.curves);
    let both = curves.filter(|curve| {
        let left = curve.pixels.iter().filter(|p| p.col < STEP_COLUMN).count();
        left > 0 && left < curve.pixels.len()
    });
    both.count()
}
