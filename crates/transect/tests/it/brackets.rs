//! The brackets of areas and volumes on the bundled scenes hold the exact values.

use std::sync::Arc;
use transect::{Setup, Unwatched, reconstruct};
use transect_device::{DeviceFrame, ImageSize, View};
use transect_geometry::{Curve, Envelope, Point2};
use transect_model::{Bracket, Location, Model, Section, SectionIndex};
use transect_scene::{Description, SensorParameters, Station};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole};

/// A station's sensor with a part of its rows and columns.
fn frame(station: &Station, step: usize) -> Arc<dyn DeviceFrame> {
    let size = ImageSize { rows: station.size.rows / step, cols: station.size.cols / step };
    let step = step as f64;
    match station.sensor {
        SensorParameters::Spherical { theta0, dtheta, phi0, dphi } => {
            let theta = AngularScan::from_radians(theta0, step * dtheta);
            let phi = AngularScan::from_radians(phi0, step * dphi);
            Arc::new(ImagingRadar::new(size, theta, phi).unwrap())
        }
        SensorParameters::Pinhole { fx, fy, cx, cy } => {
            let [fx, fy, cx, cy] = [fx, fy, cx, cy].map(|pixels| pixels / step);
            Arc::new(Pinhole::new(size, Intrinsics { fx, fy, cx, cy }).unwrap())
        }
        _ => panic!("the scenes are seen by scanners and cameras"),
    }
}

fn model(description: &Description, step: usize) -> Model {
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| -> View {
        let (frame, noise) = (frame(s, step), &description.noise);
        scene.view(s.name.clone(), frame, s.world_from_sensor, noise, k as u64).unwrap()
    };
    let views: Vec<View> = description.stations.iter().enumerate().map(view).collect();
    let setup = Setup::new(description.unit, description.planes.clone());
    reconstruct(&views, &setup, &Unwatched).unwrap().model
}

fn holds(bracket: &Bracket, exact: f64) -> bool {
    bracket.least <= exact && bracket.most.is_none_or(|most| exact <= most)
}

fn text(bracket: &Bracket) -> String {
    let Bracket { least, most, estimate, .. } = bracket;
    most.map_or(format!("{least:.4} or more"), |most| {
        format!("{least:.4} to {most:.4}, about {estimate:.4}")
    })
}

/// The bracket is at most as wide as gaps times the extent, and the noise of the nodes, explain.
fn is_explained(section: &Section, bracket: &Bracket) -> bool {
    let mut gaps: f64 = section.gaps().iter().map(|gap| gap.width()).sum();
    let mut noise = 0.0;
    for curve in section.curves() {
        for (unit, node) in curve.units().zip(curve.nodes()) {
            let length = unit.vector().norm();
            if node.bridged {
                gaps += length;
            } else {
                noise += 6.0 * f64::from(node.sigma) * length;
            }
        }
    }
    // A curve bounds the face within it and the face around it.
    let explained = 2.0 * (gaps * section.envelope().size().norm() + noise);
    bracket.most.is_none_or(|most| most - bracket.least <= explained + 1e-9)
}

/// How often curves run round a point, by signed crossings of a ray along +x.
fn winding(curves: &[&Curve], p: &Point2) -> i32 {
    let units = curves.iter().flat_map(|curve| curve.units());
    let crossing = units.map(|u| match (u.start.y <= p.y, u.end.y <= p.y) {
        (true, false) if u.line_value(p) < 0.0 => 1,
        (false, true) if u.line_value(p) > 0.0 => -1,
        _ => 0,
    });
    crossing.sum()
}

/// What a query calls unknown or outside is neither filled nor counted as solid.
fn check_with_queries(section: &Section) {
    const STEPS: usize = 60;
    let Envelope { min, .. } = section.envelope();
    let step = section.envelope().size() / STEPS as f64;
    let filled: Vec<&Curve> =
        section.known_solid().into_iter().filter_map(|index| section.curve(index)).collect();
    let (index, mut inside) = (SectionIndex::new(section.clone()), 0.0);
    for k in 0..STEPS * STEPS {
        let (i, j) = ((k % STEPS) as f64 + 0.5, (k / STEPS) as f64 + 0.5);
        let p = Point2::new(min.x + i * step.x, min.y + j * step.y);
        let location = index.locate(&p).location;
        inside += if location == Location::Inside { step.x * step.y } else { 0.0 };
        assert!(winding(&filled, &p) == 0 || location == Location::Inside, "{p} is filled");
    }
    let (least, blur) = (section.measures().solid.least, section.length() * step.norm());
    assert!(least <= inside + blur, "{least} counted, {inside} known to queries");
}

/// Checks every plane of a scene; how many planes have gaps.
#[allow(clippy::print_stdout, reason = "`--nocapture` shows the brackets")]
fn check(name: &str, scene: &str, step: usize) -> usize {
    let description = Description::parse(scene).unwrap();
    let model = model(&description, step);
    let exact = description.scene().sections(&description.planes, 1e-4).unwrap();
    let (mut gaps, mut wrong) = (0, Vec::new());
    for (plane, section) in model.sections() {
        let measures = section.measures();
        let exact = Section::new(exact.get(&plane).cloned().unwrap_or_default());
        let exact = exact.map(|exact| exact.measures());
        let [solid, clear] = exact.map_or([0.0; 2], |e| [e.solid.estimate, e.clear.estimate]);
        println!(
            "{name} {plane}: solid {solid:.4} in {}; clear {clear:.4} in {}; gap {:.3}",
            text(&measures.solid),
            text(&measures.clear),
            measures.widest_gap
        );
        for (bracket, exact) in [(&measures.solid, solid), (&measures.clear, clear)] {
            if !holds(bracket, exact) || !is_explained(section, bracket) {
                wrong.push(format!("{plane}: {exact} in {}", text(bracket)));
            }
        }
        gaps += usize::from(measures.open_curves > 0);
        if plane.0 % 8 == 0 {
            check_with_queries(section);
        }
    }
    assert!(wrong.is_empty(), "{name}: {wrong:#?}");
    gaps
}

#[test]
fn brackets_hold_the_exact_areas_of_every_plane() {
    assert!(check("machined part", transect_scene::BUNDLED_MACHINED_PART, 2) > 0);
    assert!(check("room", transect_scene::BUNDLED_ROOM, 2) > 0);
    assert!(check("tunnel", transect_scene::BUNDLED_TUNNEL, 1) > 0);
    assert!(check("bend tunnel", transect_scene::BUNDLED_BEND_TUNNEL, 1) > 0);
    check("thin sheet", transect_scene::BUNDLED_THIN_SHEET, 2);
}

/// The tunnel along a bend has the clear volume of its exact sections.
#[test]
fn the_clear_volume_follows_the_bend() {
    let description = Description::parse(transect_scene::BUNDLED_BEND_TUNNEL).unwrap();
    let found = model(&description, 3).volume().clear;
    let mut exact = Model::new(description.unit, description.planes.clone());
    for (plane, curves) in description.scene().sections(&description.planes, 1e-4).unwrap() {
        exact.set_curves(plane, curves);
    }
    let exact = exact.volume().clear.bracket.estimate;
    println!("{exact} in {}", text(&found.bracket));
    assert!((800.0..840.0).contains(&exact), "{exact}");
    assert!(holds(&found.bracket, exact), "{exact} in {}", text(&found.bracket));
    assert!((found.bracket.estimate / exact - 1.0).abs() < 0.01);
}
