//! Groups: observations so close to each other that a rough fit can treat them as one.
//!
//! Many views of one surface put many observations into every footprint. One rough fit for each,
//! through all of them, would cost observations × views. Fits between groups cost the same for any
//! number of views. The observations are kept: clusters are means of their original places.

use super::super::measure::{NONE, Observation, Observations, Scale};
use super::super::tuning::groups::*;
use super::super::window::Window;
use crate::grid::PointGrid;
use transect_geometry::{Point2, Vector2};

/// Observations beside each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Group {
    /// Weighted mean of their places.
    pub position: Point2,
    /// Unit vector: their weighted mean direction.
    pub tangent: Vector2,
    /// Sum of their weights.
    pub weight: f64,
    /// Standard deviation of the best of them.
    pub sigma: f64,
    /// Their weighted mean footprint.
    pub footprint: f64,
}

/// The groups, and for every observation the number of its group.
pub(super) struct Groups {
    pub all: Vec<Group>,
    pub of: Vec<u32>,
}

/// Groups observations: in canonical order, each ungrouped one takes in those beside it.
pub(super) fn group(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Groups {
    let seen = &observations.all;
    let mut groups = Groups { all: Vec::new(), of: vec![NONE; seen.len()] };
    for (k, here) in seen.iter().enumerate() {
        if groups.of[k] != NONE {
            continue;
        }
        let number = groups.all.len() as u32;
        groups.of[k] = number;
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: ALONG_FOOTPRINTS * here.footprint,
            across: ACROSS_SHARE * scale.across(here.sigma),
            same_way: SAME_WAY,
        };
        let (of, mut sums) = (&mut groups.of, Sums::of(here));
        if !scale.steps().groups {
            groups.all.push(sums.group(here));
            continue;
        }
        window.visit(grid, |j, x, _| {
            if of[j] != NONE {
                return;
            }
            let there = &seen[j];
            // A finer observation is grouped within its own footprint.
            let beside = x.abs() <= ALONG_FOOTPRINTS * there.footprint;
            if beside && window.goes_along(&there.tangent) {
                of[j] = number;
                sums.add(here, there);
            }
        });
        groups.all.push(sums.group(here));
    }
    groups
}

/// Sums over the members of a group; places relative to the first.
#[derive(Default)]
struct Sums {
    place: Vector2,
    tangent: Vector2,
    weight: f64,
    footprint: f64,
    /// Highest quality of a member, and this member's standard deviation.
    best_quality: f64,
    best_sigma: f64,
}

impl Sums {
    fn of(first: &Observation) -> Self {
        let mut sums = Self { best_quality: f64::NEG_INFINITY, ..Self::default() };
        sums.add(first, first);
        sums
    }

    fn add(&mut self, first: &Observation, o: &Observation) {
        self.place += (o.position - first.position) * o.weight;
        self.tangent += o.tangent * o.weight;
        self.weight += o.weight;
        self.footprint += o.weight * o.footprint;
        let quality = quality(o);
        if quality > self.best_quality {
            (self.best_quality, self.best_sigma) = (quality, o.sigma);
        }
    }

    fn group(&self, first: &Observation) -> Group {
        // Without any weight the group stands at its first member.
        let share = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        Group {
            position: first.position + self.place * share,
            tangent: self.tangent.try_normalize(0.0).unwrap_or(first.tangent),
            weight: self.weight,
            sigma: self.best_sigma,
            footprint: if share > 0.0 { self.footprint * share } else { first.footprint },
        }
    }
}

fn quality(o: &Observation) -> f64 {
    o.weight / o.footprint
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::consensus::options::ConsensusOptions;
    use transect_geometry::{Curve, Node};

    /// Lines seen by some views that differ by less than the threshold.
    fn lines(views: u32) -> Observations {
        let line = |v: u32| {
            let node = |k: u32| {
                let place = Point2::new(0.02 * f64::from(k), 1e-5 * f64::from(v));
                Node::at(place).with_sigma(0.001).with_footprint(0.02)
            };
            vec![Curve::new((0..100).map(node).collect(), false).unwrap()]
        };
        let views: Vec<Vec<Curve>> = (0..views).map(line).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        Observations::collect(&slices, &ConsensusOptions::default().steps)
    }

    fn grouped(observations: &Observations) -> Groups {
        let grid = PointGrid::new(&observations.positions(), 0.02);
        group(
            observations,
            &grid,
            &Scale {
                spacing: 0.02,
                threshold: 0.02,
                same_way: 0.6,
                settled: false,
                options: ConsensusOptions::default(),
            },
        )
    }

    #[test]
    fn the_number_of_groups_does_not_grow_with_the_number_of_views() {
        assert_eq!(grouped(&lines(2)).all.len(), 100);
        assert_eq!(grouped(&lines(200)).all.len(), 100);
    }

    #[test]
    fn every_observation_is_in_one_group_and_weights_add_up() {
        let observations = lines(70);
        let groups = grouped(&observations);
        let mut weights = vec![0.0; groups.all.len()];
        for (o, &g) in observations.all.iter().zip(&groups.of) {
            weights[g as usize] += o.weight;
        }
        for (found, g) in weights.iter().zip(&groups.all) {
            assert!((found / g.weight - 1.0).abs() < 1e-9);
        }
    }
}
