//! How accurate one view's curves are: by method, subpixel solution, noise, surface, and by the
//! angle between surface and section plane.
//!
//! One camera looks at a solid whose distance function is known. A node's error is its signed
//! distance, inside its plane, from the true section: to first order the solid's distance there over
//! the share of its gradient that lies in the plane. The spread of errors over predicted standard
//! deviations should be 1.

use super::table;
use crate::failure::Failure;
use crate::table::{digits, say};
use std::sync::Arc;
use transect_device::{ImageSize, View};
use transect_geometry::{Isometry3, PlaneFamily, PlaneFrame, Point3, StraightGuide, Vector3};
use transect_partial::dissertation::DissertationOptions;
use transect_partial::one_pass::OnePassOptions;
use transect_partial::subpixel::Subpixel;
use transect_partial::{Method, partial_model};
use transect_scene::{Noise, Scene, Shape, Solid};
use transect_sensors::{Intrinsics, Pinhole};

/// Options of `experiments partial`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rows and columns of the camera.
    #[arg(long, default_value_t = 256, value_name = "NUMBER")]
    size: usize,
}

/// Range noise, as shares of the solids' size, which is 1.
const NOISE: [f64; 3] = [0.0, 0.001, 0.005];

/// Directions of the planes' normals: along no axis of any solid or of the camera.
const NORMALS: [[f64; 3]; 3] = [[0.9, 0.3, 0.2], [-0.2, 0.8, 0.5], [0.3, -0.4, 0.8]];

/// Distance between planes.
const INTERVAL: f64 = 0.023;

/// Upper limits of the angles in the second table, in degrees.
const ANGLES: [f64; 6] = [15.0, 30.0, 45.0, 60.0, 75.0, 85.0];

/// A solid of size 1 around the origin, and its distance function.
struct Surface {
    name: &'static str,
    solid: Solid,
    /// Signed distance, positive outside, and its gradient.
    distance: fn(&Point3) -> (f64, Vector3),
}

const RING: f64 = 0.33;
const TUBE: f64 = 0.16;

fn surfaces() -> Result<Vec<Surface>, Failure> {
    let placed = |shape: Shape| Solid::new(shape, Isometry3::identity());
    Ok(vec![
        Surface {
            name: "plane",
            solid: placed(Shape::cuboid(Vector3::new(2.0, 2.0, 0.1))?)?,
            distance: |p| (p.z - 0.05, Vector3::z()),
        },
        Surface {
            name: "cylinder",
            solid: placed(Shape::cylinder(0.5, 12.0)?)?,
            distance: |p| {
                let out = Vector3::new(p.x, p.y, 0.0);
                (out.norm() - 0.5, out.normalize())
            },
        },
        Surface {
            name: "ball",
            solid: placed(Shape::ball(0.5)?)?,
            distance: |p| (p.coords.norm() - 0.5, p.coords.normalize()),
        },
        Surface {
            name: "torus",
            solid: placed(Shape::torus(RING, TUBE)?)?,
            distance: |p| {
                let ring = Vector3::new(p.x, p.y, 0.0).normalize() * RING;
                let out = p.coords - ring;
                (out.norm() - TUBE, out.normalize())
            },
        },
    ])
}

/// What is known of a node after the fact; lengths as shares of the solid's size.
#[derive(Debug, Clone, Copy)]
struct NodeError {
    /// Positive outside.
    signed: f64,
    sigma: f64,
    /// Between surface normal and section plane, in degrees.
    angle: f64,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let surfaces = surfaces()?;
    let mut lines = Vec::new();
    for (name, method) in methods() {
        for sigma in NOISE {
            for surface in &surfaces {
                let errors = errors(surface, sigma, arguments.size, &method)?;
                let mut line = vec![name.clone(), share(sigma), surface.name.to_owned()];
                line.extend(figures(&errors, sigma));
                lines.push(line);
            }
        }
    }
    let heads = ["method", "noise", "surface", "nodes", "median", "p95", "bias", "spread / σ"];
    table::print(&heads, &lines);
    say("");
    by_angle(&surfaces, arguments.size)?;
    say(
        "\nLengths in thousandths of the solids' size; bias is the mean signed error, positive outside.",
    );
    Ok(())
}

/// The default method's errors by the angle between surface normal and plane.
fn by_angle(surfaces: &[Surface], size: usize) -> Result<(), Failure> {
    let mut lines = Vec::new();
    for sigma in NOISE {
        let mut all = Vec::new();
        for surface in surfaces {
            all.extend(errors(surface, sigma, size, &Method::default())?);
        }
        let mut from = 0.0;
        for to in ANGLES {
            let errors: Vec<_> =
                all.iter().copied().filter(|e| e.angle >= from && e.angle < to).collect();
            let mut line = vec![share(sigma), format!("{from:.0}° to {to:.0}°")];
            line.extend(figures(&errors, sigma));
            lines.push(line);
            from = to;
        }
    }
    table::print(&["noise", "angle", "nodes", "median", "p95", "bias", "spread / σ"], &lines);
    Ok(())
}

/// Every method with every subpixel solution; the default also without smoothing.
fn methods() -> Vec<(String, Method)> {
    let plain = OnePassOptions { smooth: false, ..OnePassOptions::default() };
    let mut methods = vec![
        ("one_pass".to_owned(), Method::default()),
        ("one_pass, not smoothed".to_owned(), Method::OnePass(plain)),
    ];
    methods.extend(Subpixel::ALL.map(|subpixel| {
        let options = DissertationOptions { subpixel, ..DissertationOptions::default() };
        (format!("dissertation, {subpixel}"), Method::Dissertation(options))
    }));
    methods
}

/// The nodes' errors on planes in several directions.
fn errors(
    surface: &Surface,
    sigma: f64,
    size: usize,
    method: &Method,
) -> Result<Vec<NodeError>, Failure> {
    let view = view(surface, sigma, size)?;
    let mut errors = Vec::new();
    for normal in NORMALS {
        let guide = StraightGuide::along(Vector3::from(normal))?;
        let planes = PlaneFamily::new(guide, 0.4 * INTERVAL, INTERVAL)?;
        for found in partial_model(&view, &planes, method)?.planes {
            let frame = planes.frame(found.plane);
            let nodes = found.curves.iter().flat_map(|c| c.curve.nodes());
            errors.extend(nodes.filter_map(|n| {
                error(surface, &frame, &frame.world_from_plane(&n.position), f64::from(n.sigma))
            }));
        }
    }
    Ok(errors)
}

/// `None` where another face of the solid is nearer than the one asked about.
fn error(surface: &Surface, frame: &PlaneFrame, at: &Point3, sigma: f64) -> Option<NodeError> {
    let (distance, gradient) = (surface.distance)(at);
    let across = gradient.dot(&frame.normal());
    let in_plane = (1.0 - across * across).max(0.0).sqrt();
    let signed = distance / in_plane;
    let ours = distance.abs() < 0.05 && in_plane > 0.05;
    ours.then(|| NodeError { signed, sigma, angle: across.abs().min(1.0).asin().to_degrees() })
}

/// A camera of 30° that looks at the solid from 3 sizes away, off its axes.
fn view(surface: &Surface, sigma: f64, size: usize) -> Result<View, Failure> {
    let centre = 0.5 * (size as f64 - 1.0);
    let focal = 0.5 * size as f64 / 15_f64.to_radians().tan();
    let intrinsics = Intrinsics { fx: focal, fy: focal, cx: centre, cy: centre };
    let camera = Pinhole::new(ImageSize { rows: size, cols: size }, intrinsics)?;
    let eye = Point3::new(0.7, -1.5, 2.5);
    // `face_towards` turns z towards the target and y upwards; the image's rows run down.
    let pose = Isometry3::face_towards(&eye, &Point3::origin(), &-Vector3::z());
    let noise = Noise { sigma, seed: 7, ..Noise::NONE };
    let scene = Scene::new(vec![surface.solid.clone()]);
    Ok(scene.view(surface.name, Arc::new(camera), pose, &noise, 0)?)
}

/// Number, median, 95 % quantile, bias, and spread over predicted standard deviation.
fn figures(errors: &[NodeError], sigma: f64) -> Vec<String> {
    let quantile = |mut values: Vec<f64>, q: f64| {
        values.sort_unstable_by(f64::total_cmp);
        values.get(((values.len() as f64 - 1.0) * q) as usize).copied().unwrap_or(f64::NAN)
    };
    let sizes: Vec<f64> = errors.iter().map(|e| 1e3 * e.signed.abs()).collect();
    let bias = errors.iter().map(|e| 1e3 * e.signed).sum::<f64>() / errors.len().max(1) as f64;
    let normed = errors.iter().map(|e| e.signed.abs() / e.sigma).collect();
    // The median of |x| of a normal x is 0.6745 of its standard deviation.
    let spread = if sigma > 0.0 { digits(quantile(normed, 0.5) / 0.6745) } else { String::new() };
    vec![
        errors.len().to_string(),
        digits(quantile(sizes.clone(), 0.5)),
        digits(quantile(sizes, 0.95)),
        digits(bias),
        spread,
    ]
}

fn share(sigma: f64) -> String {
    format!("{:.1} %", 100.0 * sigma)
}
