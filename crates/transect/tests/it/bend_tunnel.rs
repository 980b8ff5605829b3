//! Curved guides: a tunnel along a bend, and a straight one as a curved guide sees it.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_3;
use std::sync::Arc;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate};
use transect::{ReconstructError, Reconstruction, Setup, Unwatched, reconstruct};
use transect_device::{DeviceFrame, ImageSize, View};
use transect_geometry::{
    Curve, CurvedGuide, LengthUnit, PlaneFamily, PlaneIndex, Point3, StraightGuide, Vector3,
};
use transect_scene::{Description, Noise, SensorParameters, Station};
use transect_sensors::{AngularScan, ImagingRadar};

fn bundled(text: &str) -> Description {
    Description::parse(text).unwrap()
}

/// A station's scanner with a third of its rows and columns.
fn frame(station: &Station) -> Arc<dyn DeviceFrame> {
    let SensorParameters::Spherical { theta0, dtheta, phi0, dphi } = station.sensor else {
        panic!("the tunnels are seen by scanners")
    };
    let size = ImageSize { rows: station.size.rows / 3, cols: station.size.cols / 3 };
    let theta = AngularScan::from_radians(theta0 + dtheta, 3.0 * dtheta);
    let phi = AngularScan::from_radians(phi0 + dphi, 3.0 * dphi);
    Arc::new(ImagingRadar::new(size, theta, phi).unwrap())
}

fn views(description: &Description, noise: &Noise) -> Vec<View> {
    let scene = description.scene();
    let view = |(k, s): (usize, &Station)| {
        scene.view(s.name.clone(), frame(s), s.world_from_sensor, noise, k as u64).unwrap()
    };
    description.stations.iter().enumerate().map(view).collect()
}

fn run(views: &[View], planes: &PlaneFamily) -> Reconstruction {
    reconstruct(views, &Setup::new(LengthUnit::Metre, planes.clone()), &Unwatched).unwrap()
}

fn curves(result: &Reconstruction) -> BTreeMap<PlaneIndex, Vec<Curve>> {
    result.model.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect()
}

fn accuracy(description: &Description, noise: &Noise) -> Accuracy {
    let planes = &description.planes;
    let found = curves(&run(&views(description, noise), planes));
    let truth = description.scene().sections(planes, 1e-4).unwrap();
    let options = EvaluateOptions::new(0.02);
    evaluate(planes, &found, &truth, &options).unwrap()
}

/// Station of a point along the axis of the bend tunnel, by formulas of its own. The axis has 10
/// straight along x, an arc of radius 15 and 60° to the left, 10 straight.
fn axis_station(p: &Point3) -> f64 {
    let (x, y) = (p.x - 10.0, 15.0 - p.y);
    let angle = x.atan2(y);
    if angle < 0.0 {
        return p.x;
    }
    if angle <= FRAC_PI_3 {
        return 10.0 + 15.0 * angle;
    }
    let (sin, cos) = FRAC_PI_3.sin_cos();
    let along = (p.x - 10.0 - 15.0 * sin) * cos + (p.y - 15.0 * (1.0 - cos)) * sin;
    10.0 + 15.0 * FRAC_PI_3 + along
}

#[test]
fn sections_along_the_bend_are_perpendicular_to_its_axis() {
    let description = bundled(transect_scene::BUNDLED_BEND_TUNNEL);
    let result = run(&views(&description, &description.noise), &description.planes);
    let planes = result.model.planes();
    let mut nodes = 0;
    for (k, section) in result.model.sections() {
        let frame = planes.frame(k);
        for node in section.curves().flat_map(Curve::nodes) {
            let p = frame.world_from_plane(&node.position);
            let off = axis_station(&p) - planes.station(k);
            assert!(off.abs() < 1e-6, "plane {k}: {off}");
            nodes += 1;
        }
    }
    assert!(result.model.sections().len() >= 68, "{}", result.model.sections().len());
    assert!(nodes > 10_000, "{nodes}");
    let lost: usize = result.report.views.iter().map(|v| v.beyond_guide_reach).sum();
    assert_eq!(lost, 0, "everything in the tunnel is near enough to the guide");
}

#[test]
fn the_bend_is_as_accurate_as_the_straight_tunnel() {
    for noisy in [false, true] {
        let [straight, bend] =
            [transect_scene::BUNDLED_TUNNEL, transect_scene::BUNDLED_BEND_TUNNEL]
                .map(bundled)
                .map(|d| accuracy(&d, if noisy { &d.noise } else { &Noise::NONE }));
        let (a, b) = (straight.median.unwrap(), bend.median.unwrap());
        assert!(b < 1.3 * a + 3e-4, "{noisy}: median {b} against {a}");
        let (a, b) = (straight.p95.unwrap(), bend.p95.unwrap());
        assert!(b < 1.3 * a + 1e-3, "{noisy}: 95 % {b} against {a}");
        let oriented = bend.oriented.unwrap();
        assert!(oriented > 0.999, "{noisy}: {oriented}");
    }
}

#[test]
fn a_guide_that_does_not_bend_gives_the_curves_of_a_line() {
    let description = bundled(transect_scene::BUNDLED_TUNNEL);
    let views = views(&description, &description.noise);
    let line = PlaneFamily::new(StraightGuide::along(Vector3::x()).unwrap(), 0.237, 0.5).unwrap();
    let points = vec![Point3::origin(), Point3::new(20.0, 0.0, 0.0)];
    let curve = CurvedGuide::polyline(points, None).unwrap();
    let curve = PlaneFamily::new(curve, 0.237, 0.5).unwrap();
    let (line, curve) = (curves(&run(&views, &line)), curves(&run(&views, &curve)));
    assert!(line.len() == 40 && line.keys().eq(curve.keys()));
    let (mut nodes, mut differing) = (0, 0);
    for (a, b) in line.values().flatten().zip(curve.values().flatten()) {
        if a.nodes().len() != b.nodes().len() {
            differing += 1;
            continue;
        }
        for (a, b) in a.nodes().iter().zip(b.nodes()) {
            nodes += 1;
            differing += usize::from((a.position - b.position).norm() > 0.05 * f64::from(a.sigma));
        }
    }
    // Levels are rounded to f32 in other ways, which may turn a sample on a plane to its other
    // side. Errors that views have in common are measured from all of a plane, so then all of it
    // moves, by a part of its error.
    assert!(nodes > 5000 && differing <= nodes / 250, "{differing} of {nodes}");
}

#[test]
fn a_guide_elsewhere_says_what_became_of_the_pixels() {
    let description = bundled(transect_scene::BUNDLED_TUNNEL);
    let views = views(&description, &Noise::NONE);
    let valid: usize = views.iter().map(|v| v.image().valid_count()).sum();
    // A bend of 2 m radius, beside which nothing is near enough.
    let points = [(200.0, 0.0), (204.0, 0.0), (204.0, 4.0)].map(|(x, y)| Point3::new(x, y, 0.0));
    let guide = CurvedGuide::polyline(points.to_vec(), Some(2.0)).unwrap();
    let setup = Setup::new(LengthUnit::Metre, PlaneFamily::new(guide, 0.0, 0.1).unwrap());
    let error = reconstruct(&views, &setup, &Unwatched).unwrap_err();
    match &error {
        ReconstructError::OffGuide { views, beyond_ends, beyond_reach, .. } => {
            assert_eq!((*views, beyond_ends + beyond_reach), (3, valid));
        }
        other => panic!("{other}"),
    }
    let told = error.to_string();
    let guide = "The guide reaches over x 200.0 to 204.0, y 0 to 4.000, z 0 to 0 m";
    assert!(told.contains("usable distance of 1.800 m") && told.contains(guide), "{told}");
}
