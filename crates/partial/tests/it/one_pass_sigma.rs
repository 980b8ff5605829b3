//! The predicted error of nodes against their observed one.

use crate::surfaces::{Distance, camera, look, quantile};
use transect_device::{Pixel, Point3, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_partial::one_pass::{OnePassOptions, partial_model};

fn surfaces() -> [(&'static str, Distance); 5] {
    [
        ("plane", |p| 3.0 - p.z),
        ("oblique plane", |p| (3.0 - p.z + 1.2 * p.x) / 1.2_f64.hypot(1.0)),
        ("cylinder", |p| (p.x + 0.2 * p.y).hypot(p.z - 4.0) / 1.02 - 1.0),
        ("ball", |p| p.x.hypot(p.y).hypot(p.z - 4.0) - 1.2),
        ("torus", |p| (p.x.hypot(p.y) - 0.9).hypot(p.z - 3.5) - 0.4),
    ]
}

/// Gradient of the distance.
fn normal(surface: Distance, p: &Point3) -> Vector3 {
    let step = 1e-5;
    let along = |d: Vector3| surface(&(p + d * step)) - surface(&(p - d * step));
    Vector3::new(along(Vector3::x()), along(Vector3::y()), along(Vector3::z())).normalize()
}

/// A node: angle between surface normal and plane in degrees, error across the curve, prediction.
struct Checked {
    angle: f64,
    error: f64,
    sigma: f64,
}

fn checked(view: &View, surface: Distance, smooth: bool) -> Vec<Checked> {
    let mut options = OnePassOptions::default();
    options.smooth = smooth;
    let mut found = Vec::new();
    for k in 0..12 {
        let (turn, lean) = (0.55 * f64::from(k), 0.13 * f64::from(k));
        let along = Vector3::new(turn.cos() * lean.cos(), turn.sin() * lean.cos(), lean.sin());
        let planes = PlaneFamily::new(StraightGuide::along(along).unwrap(), 0.01, 0.12).unwrap();
        let model = partial_model(view, &planes, &options).unwrap();
        for plane in &model.planes {
            let frame = planes.frame(plane.plane);
            for curve in plane.curves.iter().filter(|c| c.curve.nodes().len() > 8) {
                let nodes = curve.curve.nodes().iter().zip(&curve.pixels);
                for (node, _) in nodes.filter(|(_, p)| inside(view, **p)) {
                    let world = frame.world_from_plane(&node.position);
                    let n = normal(surface, &world);
                    // Where rims are, there are few pixels around.
                    if n.dot(&world.coords.normalize()).abs() < 0.4 {
                        continue;
                    }
                    let sine = n.dot(&along).abs();
                    let error = surface(&world) / (1.0 - sine * sine).sqrt();
                    let sigma = f64::from(node.sigma);
                    found.push(Checked { angle: sine.asin().to_degrees(), error, sigma });
                }
            }
        }
    }
    found
}

fn inside(view: &View, p: Pixel) -> bool {
    let size = view.image().size();
    (8..size.rows - 8).contains(&p.row) && (8..size.cols - 8).contains(&p.col)
}

#[test]
fn predicted_errors_are_observed_ones() {
    let mut bad = Vec::new();
    for (name, surface) in surfaces() {
        for (sigma, smooth) in [(0.003, false), (0.015, false), (0.003, true), (0.015, true)] {
            let view = look(&camera(), surface, sigma, Some(sigma));
            let all = checked(&view, surface, smooth);
            print!("{name:14} noise {sigma} smoothing {smooth:5}:");
            for from in [0.0, 15.0, 30.0, 45.0, 60.0] {
                let within = |c: &&Checked| (from..from + 15.0).contains(&c.angle);
                let ratios: Vec<f64> =
                    all.iter().filter(within).map(|c| c.error / c.sigma).collect();
                if ratios.len() < 400 {
                    print!("   -  ");
                    continue;
                }
                let count = ratios.len();
                let ratio = 0.6745 / quantile(ratios.into_iter(), 0.5);
                print!(" {ratio:.2}");
                // Without smoothing, noise of 0.6 pixels moves these sections by more than a pixel,
                // and their directions are anyone's guess.
                let lost = !smooth && sigma > 0.01 && from == 60.0;
                let most = if lost { 1.5 } else { 1.25 };
                if !(0.8..most).contains(&ratio) {
                    bad.push(format!("{name} {sigma} {smooth} {from}: {ratio:.2} of {count}"));
                }
            }
            println!();
        }
    }
    assert!(bad.is_empty(), "{bad:#?}");
}

#[test]
fn a_wrong_sigma_is_a_note_that_names_both_values() {
    for (factor, stated) in [(30.0, Some("0.30")), (1.0, None), (1.0 / 30.0, Some("0.00033"))] {
        let view = look(&camera(), |p| 3.0 - p.z + 0.3 * p.x, 0.01, Some(0.01 * factor));
        let planes = PlaneFamily::new(StraightGuide::along(Vector3::y()).unwrap(), 0.0, 0.2);
        let model = partial_model(&view, &planes.unwrap(), &OnePassOptions::default()).unwrap();
        let expected = stated.map(|stated| format!("sigma is stated as {stated}, "));
        assert_eq!(model.notes.len(), usize::from(expected.is_some()), "{:?}", model.notes);
        for (note, expected) in model.notes.iter().zip(expected) {
            assert!(
                note.to_string().contains(view.name()) && note.text.contains(&expected),
                "{note}"
            );
            assert!(
                note.text.contains("image is 0.0") && note.text.contains("\"sigma\""),
                "{note}"
            );
        }
    }
}

#[test]
fn chords_that_cut_edges_state_a_larger_error() {
    // Two walls with an edge between them, towards the camera and away from it, along neither rows
    // nor columns.
    let roofs: [(&str, Distance, f64); 3] = [
        ("ridge", |p| (3.0 - p.z + 0.8 * (p.x + 0.2 * p.y)).min(3.0 - p.z - 0.6 * p.x) / 1.4, 0.0),
        ("valley", |p| (3.0 - p.z + 0.8 * (p.x + 0.2 * p.y)).max(3.0 - p.z - 0.6 * p.x) / 1.4, 0.0),
        ("noisy ridge", |p| (3.0 - p.z + 0.8 * p.x).min(3.0 - p.z - 0.6 * p.x) / 1.4, 1e-4),
    ];
    for (name, surface, noise) in roofs {
        let view = look(&camera(), surface, noise, Some(noise.max(1e-9)));
        let all = checked(&view, surface, false);
        // A pixel is 0.025 wide there. An edge close to one of its samples may be off by more.
        let off: Vec<&Checked> = all.iter().filter(|c| c.error.abs() > 5e-4).collect();
        let beyond = off.iter().filter(|c| c.error.abs() > 4.0 * c.sigma).count();
        let sure = all.iter().filter(|c| c.sigma < 1e-6).count();
        println!("{name}: {} of {} off, {beyond} by more than 4 sigma", off.len(), all.len());
        assert!(off.len() > 50 && beyond * 5 < off.len(), "{name}: {beyond} of {}", off.len());
        // On the walls, and without noise, chords state no error.
        assert!(noise > 0.0 || sure * 10 > all.len() * 9, "{name}: {sure} of {}", all.len());
    }
}
