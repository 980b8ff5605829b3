//! The accuracy table: method and subpixel solution by noise, surface and angle.
//!
//! One camera looks at a solid whose sections are known; see `surface.rs`. Angles are those between
//! the true surface normal and the section plane: 0° where the plane cuts the surface upright, 90°
//! where it touches it.

use super::super::lab::Lab;
use super::chart;
use super::error::{NodeError, figures};
use super::surface::{Surface, surfaces};
use crate::failure::Failure;
use crate::table::{line, say};
use rayon::prelude::*;
use std::collections::BTreeMap;
use transect_device::View;
use transect_geometry::{Curve, PlaneFamily, PlaneIndex, StraightGuide, Vector3};
use transect_partial::dissertation::DissertationOptions;
use transect_partial::one_pass::OnePassOptions;
use transect_partial::subpixel::Subpixel;
use transect_partial::{Method, PartialError, partial_model};

/// Range noise, as shares of the solids' size, which is 1.
const NOISE: [f64; 3] = [0.0, 0.001, 0.005];

/// Directions of the planes' normals: along no axis of any solid or of the camera. The last is that
/// in which most of the surfaces are nearly touched.
const NORMALS: [[f64; 3]; 4] =
    [[0.9, 0.3, 0.2], [-0.2, 0.8, 0.5], [0.3, -0.4, 0.8], [0.12, 0.1, 1.0]];

/// Distance between planes.
const INTERVAL: f64 = 0.023;

/// Limits of the classes of angles, in degrees.
const ANGLES: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0];

/// A family of planes with a surface's true sections by them.
struct Cut {
    planes: PlaneFamily,
    truth: BTreeMap<PlaneIndex, Vec<Curve>>,
}

/// Options of `experiments partial`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rows and columns of the camera.
    #[arg(long, default_value_t = 256, value_name = "NUMBER")]
    size: usize,
    /// Also the other subpixel solutions.
    #[arg(long)]
    full: bool,
}

/// Prints the table, one part for each noise, and the medians of the default method, and draws the
/// chart.
pub fn run(arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let surfaces = surfaces()?;
    chart(&surfaces, arguments, lab)?;
    let mut medians: Vec<_> = surfaces.iter().map(|s| vec![s.name.to_owned()]).collect();
    for sigma in NOISE {
        say(&format!("Noise of {:.1} % of the solids' size:\n", 100.0 * sigma));
        let lines = surfaces.iter().map(|surface| lines(surface, sigma, arguments));
        let lines: Vec<_> = lines.collect::<Result<_, _>>()?;
        let angles = ANGLES.windows(2).map(|a| format!("{:.0}° to {:.0}°", a[0], a[1]));
        let heads = line("surface | method | all", angles).join(" | ");
        lab.table(&format!("noise-{sigma}"), &heads, lines.concat())?;
        // The first line is that of the default method. Its figures for all angles begin with the
        // median.
        let all = lines.iter().filter_map(|of_surface| of_surface.first()?.get(2));
        let of_all = all.filter_map(|cell| cell.split(" / ").next());
        medians.iter_mut().zip(of_all).for_each(|(line, median)| line.push(median.to_owned()));
    }
    say("Medians of the default method over all angles:\n");
    let noises = NOISE.map(|sigma| format!(" | noise of {} %", 100.0 * sigma)).concat();
    lab.table("medians", &format!("surface{noises}"), medians)?;
    say("Median / 95 % / bias (positive outside) in thousandths of the size / predicted over \
         observed σ, by angle between surface normal and plane.");
    Ok(())
}

/// Draws the chart of the default method.
fn chart(surfaces: &[Surface], arguments: &Arguments, lab: &Lab) -> Result<(), Failure> {
    let of_default = |surface: &Surface| -> Result<_, Failure> {
        let view = surface.view(NOISE[1], arguments.size)?;
        let method = Method::OnePass(OnePassOptions::default());
        Ok((surface.name, errors(surface, &view, &cuts(surface)?, &method)?))
    };
    let of_default: Vec<_> = surfaces.iter().map(of_default).collect::<Result<_, _>>()?;
    let figure = chart::growth(&of_default);
    lab.picture("angles", |file| figure.write(file))
}

/// The lines of a surface, one for each method.
fn lines(
    surface: &Surface,
    sigma: f64,
    arguments: &Arguments,
) -> Result<Vec<Vec<String>>, Failure> {
    let view = surface.view(sigma, arguments.size)?;
    let cuts = cuts(surface)?;
    let line = |(name, method): (String, Method)| -> Result<_, PartialError> {
        let errors = errors(surface, &view, &cuts, &method)?;
        let mut line = vec![surface.name.to_owned(), name, figures(&errors, sigma > 0.0)];
        line.extend(ANGLES.windows(2).map(|limits| {
            let within = |e: &&NodeError| e.angle >= limits[0] && e.angle < limits[1];
            let class: Vec<_> = errors.iter().filter(within).copied().collect();
            figures(&class, sigma > 0.0)
        }));
        Ok(line)
    };
    Ok(methods(sigma > 0.0, arguments.full).into_par_iter().map(line).collect::<Result<_, _>>()?)
}

fn cuts(surface: &Surface) -> Result<Vec<Cut>, Failure> {
    NORMALS.iter().map(|normal| cut(surface, normal)).collect()
}

fn cut(surface: &Surface, normal: &[f64; 3]) -> Result<Cut, Failure> {
    let guide = StraightGuide::along(Vector3::from(*normal))?;
    let planes = PlaneFamily::new(guide, 0.4 * INTERVAL, INTERVAL)?;
    let truth = surface.sections(&planes)?;
    Ok(Cut { planes, truth })
}

/// Both methods with the subpixel solutions that differ, or with all of them. With noise, the
/// default also without smoothing.
fn methods(noisy: bool, full: bool) -> Vec<(String, Method)> {
    let one_pass = Subpixel::ALL.map(|subpixel| {
        let mut options = OnePassOptions::default();
        options.subpixel = subpixel;
        (format!("one_pass, {subpixel}"), Method::OnePass(options))
    });
    let dissertation = Subpixel::ALL.map(|subpixel| {
        let mut options = DissertationOptions::default();
        options.subpixel = subpixel;
        (format!("dissertation, {subpixel}"), Method::Dissertation(options))
    });
    let mut plain = OnePassOptions::default();
    plain.smooth = false;
    let plain = noisy.then(|| ("one_pass, not smoothed".to_owned(), Method::OnePass(plain)));
    let few = ["one_pass, cartesian", "one_pass, four_point", "dissertation, cartesian"];
    let by_subpixel = one_pass.into_iter().chain(dissertation);
    let chosen = by_subpixel.filter(|(name, _)| full || few.contains(&name.as_str()));
    chosen.chain(plain).collect()
}

/// The nodes' errors on planes in several directions.
fn errors(
    surface: &Surface,
    view: &View,
    cuts: &[Cut],
    method: &Method,
) -> Result<Vec<NodeError>, PartialError> {
    let mut errors = Vec::new();
    for Cut { planes, truth } in cuts {
        for found in partial_model(view, planes, method)?.planes {
            let curves = truth.get(&found.plane).cloned().unwrap_or_default();
            let section = surface.on(planes.frame(found.plane), curves);
            let nodes = found.curves.iter().flat_map(|c| c.curve.nodes());
            errors.extend(nodes.filter_map(|n| {
                let nearest = section.nearest(&n.position)?;
                let angle = nearest.sine.asin().to_degrees();
                Some(NodeError { signed: nearest.signed, sigma: f64::from(n.sigma), angle })
            }));
        }
    }
    Ok(errors)
}
