//! Firings: all lasers of a rotating lidar measure once, then they turn on and measure again.
//!
//! Drivers that keep missing returns write one point per laser and firing. Point k is then laser k
//! mod n of firing k / n, or point k mod m of laser k / m. No header says so, but the points prove
//! it: a field of rings repeats, or the elevation of every laser is constant. This file looks for
//! the proof, and finds nothing in doubt.

use super::cells::{Cells, elevation, is_valid};
use transect_geometry::Point3;

/// Largest difference of elevations within a laser, in radians. Theory: coordinates of 32 bits
/// round angles by 1e-7; the elevations of neighbouring lasers differ by 1e-3 and more. Measured
/// on a 32-laser lidar: 9e-8. Doubled, nothing changes.
const CONSTANT: f64 = 1e-5;

/// Fewest lasers and fewest firings. Chosen by hand: a proof needs this many agreeing points. With
/// 2, a few points in a plane through the sensor count as firings.
const FEWEST: usize = 4;

/// The order of the points in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Order {
    /// Point k is laser k mod n.
    FiringByFiring,
    /// Point k is laser k / m, with m points per laser.
    LaserByLaser,
}

/// A cloud in firings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Firings {
    pub(super) lasers: usize,
    cols: usize,
    order: Order,
    by_field: bool,
}

impl Firings {
    /// The laser and the firing of a point.
    fn place(&self, k: usize) -> (usize, usize) {
        match self.order {
            Order::FiringByFiring => (k % self.lasers, k / self.lasers),
            Order::LaserByLaser => (k / self.cols, k % self.cols),
        }
    }

    pub(super) fn cells(&self, points: usize) -> Cells {
        let place = |k| {
            let (laser, col) = self.place(k);
            Some((u16::try_from(laser).ok()?, u32::try_from(col).ok()?))
        };
        Cells { lasers: self.lasers, cols: self.cols, cell: (0..points).map(place).collect() }
    }

    pub(super) fn note(&self) -> String {
        let Self { lasers, cols, .. } = self;
        let order = match self.order {
            Order::FiringByFiring => {
                format!("point k is laser k mod {lasers} of firing k / {lasers}")
            }
            Order::LaserByLaser => format!("point k is firing k mod {cols} of laser k / {cols}"),
        };
        let proof = if self.by_field {
            "the field of rings repeats"
        } else {
            "each laser has one elevation"
        };
        format!("{cols} firings of {lasers} lasers found: {order}; {proof}")
    }
}

/// The firings that the rings prove, where the file has a field for them, or else the elevations.
pub(super) fn find(points: &[Point3], rings: Option<&[u16]>) -> Option<Firings> {
    let by_field = rings.is_some();
    let divisors = (FEWEST..=points.len() / FEWEST).filter(|n| points.len().is_multiple_of(*n));
    let candidates = divisors.flat_map(|n| {
        let cols = points.len() / n;
        [Order::FiringByFiring, Order::LaserByLaser].map(|order| Firings {
            lasers: n,
            cols,
            order,
            by_field,
        })
    });
    let candidates = candidates.filter(|f| f.lasers <= super::cells::MOST_RINGS);
    match rings {
        Some(rings) => candidates.into_iter().find(|f| rings_repeat(f, rings)),
        None => {
            let elevations: Vec<f64> = points.iter().map(known_elevation).collect();
            candidates.into_iter().find(|f| elevations_repeat(f, &elevations))
        }
    }
}

/// Whether every laser has one ring, and every ring one laser.
fn rings_repeat(firings: &Firings, rings: &[u16]) -> bool {
    let mut of_laser = vec![None; firings.lasers];
    for (k, ring) in rings.iter().enumerate() {
        let Some(known) = of_laser.get_mut(firings.place(k).0) else { return false };
        if *known.get_or_insert(*ring) != *ring {
            return false;
        }
    }
    of_laser.sort_unstable();
    of_laser.windows(2).all(|pair| pair.first() != pair.last())
}

/// NaN where nothing came back.
fn known_elevation(point: &Point3) -> f64 {
    if is_valid(point) { elevation(point) } else { f64::NAN }
}

/// Whether every laser has one elevation, and the lasers have different ones.
fn elevations_repeat(firings: &Firings, elevations: &[f64]) -> bool {
    let mut of_laser = vec![(f64::NAN, f64::NAN, 0_usize); firings.lasers];
    for (k, elevation) in elevations.iter().enumerate() {
        let Some((low, high, count)) = of_laser.get_mut(firings.place(k).0) else { return false };
        // The least and the greatest of a number and NaN is the number.
        (*low, *high) = (low.min(*elevation), high.max(*elevation));
        *count += usize::from(!elevation.is_nan());
        if *high - *low > CONSTANT {
            return false;
        }
    }
    of_laser.retain(|(_, _, count)| *count >= FEWEST);
    of_laser.sort_by(|a, b| a.0.total_cmp(&b.0));
    let is_apart = |pair: &[(f64, f64, usize)]| match pair {
        [(_, high, _), (low, ..)] => low - high > CONSTANT,
        _ => false,
    };
    of_laser.len() >= FEWEST.max(firings.lasers / 2) && of_laser.windows(2).all(is_apart)
}
