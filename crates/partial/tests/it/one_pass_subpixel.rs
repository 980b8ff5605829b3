//! Subpixel solutions through the one-pass method: orders without noise, accuracy with it.

use crate::common::observed_orders;
use crate::surfaces::{Distance, camera, look, quantile};
use std::sync::Arc;
use transect_device::{DeviceFrame, ImageSize, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_partial::one_pass::{OnePassOptions, partial_model};
use transect_partial::subpixel::Subpixel;
use transect_sensors::{AngularScan, ImagingRadar};

/// A round room, seen from inside off its middle: smooth all over, and no rims.
const ROOM: Distance = |p| 3.0 - (p.x - 0.8).hypot(p.y - 0.5).hypot(p.z - 0.3);

/// A room like a pipe.
const PIPE: Distance = |p| 2.0 - (p.x - 0.4).hypot(0.8 * p.y - 0.6 * p.z - 0.5);

/// The inside of a torus.
const RING: Distance = |p| 1.5 - ((p.x - 2.5).hypot(p.y) - 3.0).hypot(p.z - 0.4);

fn planes(normal: Vector3) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), 0.0123, 0.05).unwrap()
}

fn normals() -> [Vector3; 3] {
    [Vector3::z(), Vector3::new(0.3, 1.0, 0.2), Vector3::new(1.0, 0.5, 0.6)]
}

/// Looks along +x, its field 1.2 by 0.9 radians.
fn radar(step: f64) -> Arc<dyn DeviceFrame> {
    let count = |field: f64| (field / step).round() as usize;
    let scan = |n: usize| AngularScan::from_radians(-0.5 * step * (n - 1) as f64, step);
    let size = ImageSize { rows: count(0.9), cols: count(1.2) };
    Arc::new(ImagingRadar::new(size, scan(size.cols), scan(size.rows)).unwrap())
}

/// Distances of all nodes from the surface, on planes of some directions.
fn errors(view: &View, surface: Distance, subpixel: Subpixel, inner: usize) -> Vec<f64> {
    let mut options = OnePassOptions::default();
    options.subpixel = subpixel;
    let size = view.image().size();
    let mut found = Vec::new();
    for normal in normals() {
        let planes = planes(normal);
        let model = partial_model(view, &planes, &options).unwrap();
        for plane in &model.planes {
            let frame = planes.frame(plane.plane);
            for curve in &plane.curves {
                for (node, p) in curve.curve.nodes().iter().zip(&curve.pixels) {
                    // At the border there are no four points.
                    let inside = |at: usize, count: usize| at >= inner && at + inner < count;
                    if inside(p.row, size.rows) && inside(p.col, size.cols) {
                        found.push(surface(&frame.world_from_plane(&node.position)));
                    }
                }
            }
        }
    }
    found
}

#[test]
fn linear_errors_fall_with_the_square_and_four_point_errors_with_the_fourth_power() {
    let steps = [0.12, 0.085, 0.06];
    for (name, surface) in [("room", ROOM), ("pipe", PIPE), ("ring", RING)] {
        for method in Subpixel::ALL {
            let medians = steps.map(|step| {
                let view = look(&radar(step), surface, 0.0, Some(0.0));
                let found = errors(&view, surface, method, 2);
                assert!(found.len() > 100, "{}", found.len());
                quantile(found.into_iter(), 0.5)
            });
            let orders = observed_orders(&steps, &medians);
            let medians = medians.map(|e| e * 1e6);
            println!("{name}, {method}: errors in 1e-6 {medians:.1?}, orders {orders:.2?}");
            let expected = if method == Subpixel::FourPoint { 4.0 } else { 2.0 };
            let mean = orders.iter().sum::<f64>() / orders.len() as f64;
            assert!((mean - expected).abs() < 0.4, "{name}, {method}: {orders:?}");
        }
    }
}

#[test]
fn four_points_are_no_worse_than_two_on_noisy_surfaces() {
    let ball: Distance = |p| p.x.hypot(p.y).hypot(p.z - 4.0) - 1.2;
    let torus: Distance = |p| (p.x.hypot(p.y) - 0.9).hypot(p.z - 3.5) - 0.4;
    let cylinder: Distance = |p| p.x.hypot(p.z - 4.0) - 1.0;
    let plane: Distance = |p| 0.8 * (3.0 - p.z + 0.5 * p.x);
    let surfaces = [("plane", plane), ("cylinder", cylinder), ("ball", ball), ("torus", torus)];
    for (name, surface) in surfaces {
        // Of a scene of size 3.
        for sigma in [0.0, 0.003, 0.015] {
            let view = look(&camera(), surface, sigma, Some(sigma));
            let [linear, four] = [Subpixel::Cartesian, Subpixel::FourPoint].map(|method| {
                let found = errors(&view, surface, method, 0);
                [0.5, 0.95].map(|share| 1e5 * quantile(found.iter().copied(), share))
            });
            println!(
                "{name}, noise {sigma}, errors in 1e-5: linear {linear:.2?}, four points {four:.2?}"
            );
            if sigma > 0.0 {
                for (linear, four) in linear.iter().zip(four) {
                    assert!(four < 1.02 * linear, "{name}, noise {sigma}: {four} for {linear}");
                }
            }
        }
    }
}
