//! Groups: observations so close to each other that one place stands for all of them in a rough fit.
//!
//! Many views of one surface put many observations into every footprint. Rough fits through all of
//! them, one for each, would cost observations × views; between groups they cost the same for any
//! number of views. The observations themselves stay: clusters are made of their original places.

use super::Scale;
use super::observations::{NONE, Observation, Observations};
use super::window::Window;
use crate::grid::PointGrid;
use transect_geometry::{Point2, Vector2};

/// Half-widths of a group: along, in footprints, and across, as a share of the overlap threshold.
const ALONG_FOOTPRINTS: f64 = 0.3;
const ACROSS_SHARE: f64 = 0.25;

/// The same as a share of the room.
const ROOM_SHARE: f64 = 0.5;

/// Smallest cosine between directions within a group (25°).
const SAME_WAY: f64 = 0.906;

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
    /// Half the gap to the next layer at the first of them.
    pub room: f64,
}

/// The groups, and for every observation the number of its group.
pub(super) struct Groups {
    pub all: Vec<Group>,
    pub of: Vec<u32>,
}

/// Groups observations, each ungrouped one in canonical order taking in those beside it.
pub(super) fn group(observations: &Observations, grid: &PointGrid, scale: &Scale) -> Groups {
    let seen = &observations.all;
    let mut groups = Groups { all: Vec::new(), of: vec![NONE; seen.len()] };
    for (k, here) in seen.iter().enumerate() {
        if groups.of[k] != NONE {
            continue;
        }
        let number = groups.all.len() as u32;
        let room = observations.room(k);
        groups.of[k] = number;
        let window = Window {
            centre: here.position,
            tangent: here.tangent,
            reach: ALONG_FOOTPRINTS * here.footprint,
            across: across(scale, here, room),
            same_way: SAME_WAY,
        };
        let (of, mut sums) = (&mut groups.of, Sums::of(here));
        if !scale.steps.groups {
            groups.all.push(sums.group(here, room));
            continue;
        }
        window.visit(
            grid,
            |j| seen[j].tangent,
            |j, x, _| {
                // What was seen more finely is not lumped together.
                if of[j] == NONE && x.abs() <= ALONG_FOOTPRINTS * seen[j].footprint {
                    of[j] = number;
                    sums.add(here, &seen[j]);
                }
            },
        );
        groups.all.push(sums.group(here, room));
    }
    groups
}

/// Half-width of a group across, with a layer's room in view.
fn across(scale: &Scale, here: &Observation, room: f64) -> f64 {
    (ACROSS_SHARE * scale.across(here.sigma, f64::INFINITY)).min(ROOM_SHARE * room)
}

/// Sums over the members of a group; places relative to the first.
struct Sums {
    place: Vector2,
    tangent: Vector2,
    weight: f64,
    footprint: f64,
    /// Highest quality, and the standard deviation of the one that has it.
    best: (f64, f64),
}

impl Sums {
    fn of(first: &Observation) -> Self {
        let (place, tangent) = (Vector2::zeros(), first.tangent * first.weight);
        Self {
            place,
            tangent,
            weight: first.weight,
            footprint: first.weight * first.footprint,
            best: (quality(first), first.sigma),
        }
    }

    fn add(&mut self, first: &Observation, o: &Observation) {
        self.place += (o.position - first.position) * o.weight;
        self.tangent += o.tangent * o.weight;
        self.weight += o.weight;
        self.footprint += o.weight * o.footprint;
        let quality = quality(o);
        if quality > self.best.0 {
            self.best = (quality, o.sigma);
        }
    }

    fn group(&self, first: &Observation, room: f64) -> Group {
        // Nodes of no weight stand where the first of them is.
        let share = if self.weight > 0.0 { 1.0 / self.weight } else { 0.0 };
        Group {
            position: first.position + self.place * share,
            tangent: self.tangent.try_normalize(0.0).unwrap_or(first.tangent),
            weight: self.weight,
            sigma: self.best.1,
            footprint: if share > 0.0 { self.footprint * share } else { first.footprint },
            room,
        }
    }
}

fn quality(o: &Observation) -> f64 {
    o.weight / o.footprint
}

#[cfg(test)]
mod tests {
    use super::*;
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
        Observations::collect(&slices, &super::super::Steps::ALL)
    }

    fn grouped(observations: &Observations) -> Groups {
        let grid = PointGrid::new(&observations.positions(), 0.02);
        group(
            observations,
            &grid,
            &Scale {
                spacing: 0.02,
                threshold: 0.02,
                threshold_spreads: 8.0,
                same_way: 0.6,
                steps: super::super::Steps::ALL,
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
