//! Points of a guide, and which of them are near a place.

use crate::Point3;
use crate::guide::path::Path;
use rstar::RTree;
use rstar::primitives::GeomWithData;

/// A point and its number.
type Sample = GeomWithData<[f64; 3], u32>;

/// Equally spaced points of a path, both ends included, in a tree. A search takes about as long for
/// 65 536 points as for 257. For most places some of the points alone tell that nothing is near.
#[derive(Debug, Clone)]
pub struct Samples {
    spacing: f64,
    tree: RTree<Sample>,
    /// Every so many points, at most 257 of them.
    some: Vec<Point3>,
    /// Length of the path between these.
    some_spacing: f64,
}

/// Most steps between the points that are looked at first. No unit. Measured with a guide of three
/// points: a search of the tree alone takes a run from 0.20 to 0.37 s. Doubled, twice as many are
/// looked at where none can be left out, and the tree is searched less often.
const SOME: usize = 256;

impl Samples {
    /// Points so dense that Newton's method converges from the nearest one.
    pub fn of(path: &Path) -> Self {
        let least = (8 * path.starts().len()).clamp(SOME, 1 << 16);
        let step = least.div_ceil(SOME);
        let count = least.next_multiple_of(step);
        let spacing = path.length() / count as f64;
        let point = |k: usize| path.at(spacing * k as f64).point;
        let sample = |k: usize| Sample::new(point(k).coords.into(), k as u32);
        Self {
            spacing,
            tree: RTree::bulk_load((0..=count).map(sample).collect()),
            some: (0..=count).step_by(step).map(point).collect(),
            some_spacing: spacing * step as f64,
        }
    }

    /// Length of the path between neighbours.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Station of the sample nearest to a point.
    pub fn nearest(&self, p: &Point3) -> f64 {
        self.tree.nearest_neighbor(p.coords.into()).map_or(0.0, |sample| self.station(sample))
    }

    /// Whether a sample that is not between two stations lies within a distance of a point.
    pub fn is_any_within(&self, distance: f64, p: &Point3, [from, to]: [f64; 2]) -> bool {
        if !self.may_be_within(distance + self.some_spacing, p, [from, to]) {
            return false;
        }
        let within = self.tree.locate_within_distance(p.coords.into(), distance * distance);
        within.map(|sample| self.station(sample)).any(|station| station <= from || station >= to)
    }

    /// Whether one of some samples, not well between two stations, lies within a distance.
    ///
    /// From one to the next the distance changes by at most their spacing. So after one that is
    /// farther, as many can be left out as spacings fit into the difference.
    fn may_be_within(&self, distance: f64, p: &Point3, [from, to]: [f64; 2]) -> bool {
        let (spacing, mut k) = (self.some_spacing, 0);
        while let Some(sample) = self.some.get(k) {
            let station = k as f64 * spacing;
            if station > from + spacing && station < to - spacing {
                k = ((to / spacing) as usize).saturating_sub(1).max(k + 1);
                continue;
            }
            let beyond = (p - sample).norm() - distance;
            if beyond <= 0.0 {
                return true;
            }
            // One less than the bound allows, because of rounding.
            k += 1.max(((beyond / spacing) as usize).saturating_sub(1));
        }
        false
    }

    fn station(&self, sample: &Sample) -> f64 {
        self.spacing * f64::from(sample.data)
    }
}

/// Samples follow from their path.
impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        self.spacing == other.spacing && self.tree.size() == other.tree.size()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector3;
    use crate::guide::spline::Spline;

    /// A guide that bends to and fro, through so many points.
    fn samples(points: usize) -> Samples {
        let at = |k: usize| {
            let x = k as f64 * 40.0 / points as f64;
            Point3::new(x, 3.0 * x.sin(), (0.3 * x).cos())
        };
        Samples::of(&Path::Spline(Spline::new(&(0..=points).map(at).collect::<Vec<_>>())))
    }

    #[test]
    fn searches_find_what_looking_at_every_sample_finds() {
        for samples in [samples(4), samples(100)] {
            let all: Vec<(f64, Point3)> = samples
                .tree
                .iter()
                .map(|s| (samples.station(s), Point3::from(*s.geom())))
                .collect();
            assert!(samples.some.len() <= SOME + 1);
            let length = samples.spacing() * (all.len() - 1) as f64;
            let wave = |k: u32, size: f64| size * (f64::from(k) * 1.618).sin();
            let mut found = [0, 0];
            for k in 0..600 {
                let near = all[k as usize * 37 % all.len()].1;
                let p = near + Vector3::new(wave(k, 2.0), wave(k + 7, 2.0), wave(3 * k, 2.0));
                let off = |sample: &(f64, Point3)| (sample.1 - p).norm();
                let least = all.iter().map(off).fold(f64::INFINITY, f64::min);
                let nearest = samples.nearest(&p);
                assert!(all.iter().any(|s| s.0 == nearest && off(s) == least), "{p}");
                let middle = 0.5 * length + wave(k + 3, 0.6 * length);
                let around = [middle - 3.0, middle + 3.0];
                let distance = 1.0 + wave(k, 0.99);
                let outside = |s: &&(f64, Point3)| s.0 <= around[0] || s.0 >= around[1];
                let any = all.iter().filter(outside).any(|s| off(s) <= distance);
                assert_eq!(samples.is_any_within(distance, &p, around), any, "{p} {distance}");
                found[usize::from(any)] += 1;
            }
            assert!(found.iter().all(|count| *count > 20), "{found:?}");
        }
    }
}
