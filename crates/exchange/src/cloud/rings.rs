//! The rings of a rotating lidar whose file has no field for them.
//!
//! Two orders of points are known. KITTI writes ring after ring, so the azimuth goes round once per
//! ring. Other files have any order, and the elevations of the rings are separated by gaps. Both
//! are checked against the stated number of rings; files that pass neither check are refused.

use super::cells::{MOST_RINGS, Rings, elevation, is_valid};
use crate::error::Problem;
use std::f64::consts::{PI, TAU};
use transect_device::median;
use transect_geometry::Point3;

/// The least gap between rings over the largest gap within rings. Chosen by hand: the ratio of a
/// 32-ring lidar with 32-bit coordinates is above 10⁵, and 1 means no gap. Doubled, lidars with
/// rounded coordinates are refused.
const GAP_RATIO: f64 = 2.0;

/// Fewest points of a ring. Chosen by hand. Doubled, rings that mostly look at the sky are refused.
const FEWEST_POINTS: usize = 4;

/// The ring of every point, for a stated number of rings.
pub(super) fn find(
    points: &[Point3],
    count: usize,
    notes: &mut Vec<String>,
) -> Result<Rings, Problem> {
    if !(1..=MOST_RINGS).contains(&count) {
        let problem = format!("the setting `rings` {count}: expected 1 to {MOST_RINGS}");
        return Err(Problem::damaged(problem));
    }
    if let Some(rings) = by_elevation(points, count) {
        notes.push(format!("{count} rings by the gaps between elevations"));
        return Ok(rings);
    }
    if let Some(rings) = by_laps(points, count) {
        notes.push(format!("{count} rings by order: the azimuth goes round once per ring"));
        return Ok(rings);
    }
    Err(Problem::unsupported(format!(
        "the setting `rings` {count}: neither the elevations nor the order of the points show \
         {count} rings; check the number of lasers, or export the scan with a ring field"
    )))
}

/// Rings between the widest gaps of the elevations.
fn by_elevation(points: &[Point3], count: usize) -> Option<Rings> {
    let mut sorted: Vec<f64> = points.iter().filter(|p| is_valid(p)).map(elevation).collect();
    sorted.sort_by(f64::total_cmp);
    let gap = |pair: &[f64]| Some((pair.last()? - pair.first()?, *pair.first()?));
    let mut gaps: Vec<(f64, f64)> = sorted.windows(2).filter_map(gap).collect();
    gaps.sort_by(|a, b| b.0.total_cmp(&a.0));
    let within = gaps.get(count - 1)?.0;
    let mut below: Vec<f64> = gaps.get(..count - 1)?.iter().map(|g| g.1).collect();
    let least = gaps.get(count.checked_sub(2)?)?.0;
    below.sort_by(f64::total_cmp);
    let ring = |p: &Point3| below.partition_point(|b| *b < elevation(p)) as u16;
    let numbers: Vec<u16> = points.iter().map(ring).collect();
    let mut sizes = vec![0_usize; count];
    for (number, _) in numbers.iter().zip(points).filter(|(_, p)| is_valid(p)) {
        sizes.get_mut(usize::from(*number)).into_iter().for_each(|n| *n += 1);
    }
    let holds = least > GAP_RATIO * within && sizes.iter().all(|n| *n >= FEWEST_POINTS);
    holds.then_some(Rings { count, numbers })
}

/// Rings that follow each other in the file, from the top down or from the bottom up.
fn by_laps(points: &[Point3], count: usize) -> Option<Rings> {
    let mut numbers = Vec::with_capacity(points.len());
    let (mut before, mut turned, mut farthest) = (None, 0.0_f64, 0.0_f64);
    for point in points {
        if is_valid(point) {
            let azimuth = point.y.atan2(point.x);
            let step = azimuth - before.replace(azimuth).unwrap_or(azimuth);
            turned += (step + PI).rem_euclid(TAU) - PI;
            // Azimuths jitter at the ends of a lap; a point never returns to the ring before.
            farthest = if turned.abs() > farthest.abs() { turned } else { farthest };
        }
        numbers.push((farthest.abs() / TAU) as usize);
    }
    let laps = farthest.abs() / TAU;
    if (count as f64 - laps).abs() >= 0.5 {
        return None;
    }
    let numbers: Vec<u16> = numbers.iter().map(|n| (*n).min(count - 1) as u16).collect();
    let mut elevations = vec![Vec::new(); count];
    for (number, point) in numbers.iter().zip(points).filter(|(_, p)| is_valid(p)) {
        elevations.get_mut(usize::from(*number))?.push(elevation(point));
    }
    let medians: Vec<f64> = elevations.into_iter().filter_map(median).collect();
    let is_sorted = medians.is_sorted_by(|a, b| a < b) || medians.is_sorted_by(|a, b| a > b);
    (medians.len() == count && is_sorted).then_some(Rings { count, numbers })
}
