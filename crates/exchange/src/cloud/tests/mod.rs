mod files;
mod grids;
mod scans;

use super::*;
use crate::test_data::write_to_folder;
use transect_geometry::Point3;

/// Elevations of eight lasers in degrees, in the order in which they fire.
const LASERS: [f64; 8] = [-20.0, 1.0, -16.0, 4.0, -9.0, 7.5, -4.0, 10.0];

/// A point of a simulated rotating lidar.
#[derive(Debug, Clone, Copy)]
struct Return {
    laser: u16,
    firing: usize,
    point: Point3,
}

/// One turn of a lidar in a room of 8 m × 6 m × 3 m, firing by firing. The speed varies by a fifth,
/// and each laser is ahead of the one before by `stagger` steps.
fn sweep(firings: usize, stagger: f64) -> Vec<Return> {
    let step = std::f64::consts::TAU / firings as f64;
    let mut returns = Vec::new();
    for firing in 0..firings {
        let turn = firing as f64 * step;
        let start = -3.0 + turn + 0.2 * step * (7.0 * turn).sin() / (7.0 * step);
        for (laser, elevation) in (0..).zip(LASERS) {
            let (azimuth, e) =
                (start + stagger * f64::from(laser) * step, f64::to_radians(elevation));
            let (x, y, z) = (e.cos() * azimuth.cos(), e.cos() * azimuth.sin(), e.sin());
            let wall = (4.0 / x.abs()).min(3.0 / y.abs()).min(1.5 / z.abs());
            returns.push(Return { laser, firing, point: Point3::new(x, y, z) * wall });
        }
    }
    returns
}

fn points(returns: &[Return]) -> Vec<Point3> {
    returns.iter().map(|r| r.point).collect()
}

fn rings(returns: &[Return]) -> Vec<u16> {
    returns.iter().map(|r| r.laser).collect()
}

/// A text PLY of points, with lines for its header and with rings.
fn ply_text(header: &str, points: &[Point3], rings: Option<&[u16]>) -> String {
    let field = if rings.is_some() { "property ushort scalar_Ring\n" } else { "" };
    let count = points.len();
    let axes = "property double x\nproperty double y\nproperty double z\n";
    let mut text =
        format!("ply\nformat ascii 1.0\n{header}element vertex {count}\n{axes}{field}end_header\n");
    for (k, p) in points.iter().enumerate() {
        let ring = rings.map_or_else(String::new, |rings| rings[k].to_string());
        text += &format!("{} {} {} {ring}\n", p.x, p.y, p.z);
    }
    text
}
