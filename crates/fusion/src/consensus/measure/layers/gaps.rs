//! How far apart the stretches of a view are that run side by side.

use super::super::super::tuning::layers::{
    FAR_MEAN_NODES, LEAST_TAPER, MEAN_NODES, MIN_GAP_SIGMAS, MIN_ROW, NEIGHBOUR_NODES, WAY_ROUND,
};
use super::super::observations::Observation;
use super::super::spread::search_distance;
use super::stretches::Stretch;

/// Length of each curve up to each of its nodes.
fn lengths_up_to(seen: &[Observation]) -> Vec<f64> {
    let mut lengths: Vec<f64> = Vec::with_capacity(seen.len());
    for (k, o) in seen.iter().enumerate() {
        let before = k.checked_sub(1).filter(|b| seen[*b].next == k as u32);
        lengths.push(before.map_or(0.0, |b| lengths[b] + (o.position - seen[b].position).norm()));
    }
    lengths
}

/// A node that another stretch of its view runs beside.
#[derive(Debug, Clone, Copy)]
struct Beside {
    gap: f64,
    /// Sum of the variances of both nodes.
    variance: f64,
    /// Whether both nodes are far enough from open ends.
    counts: bool,
    /// The other node, and its distance along the curve.
    node: usize,
    along: f64,
}

impl Beside {
    /// Whether this node is beside rather than another: of one surface's nodes the nearest along the
    /// curve, of two surfaces the nearer one.
    fn rather_than(&self, other: &Self) -> bool {
        let one_surface = self.node.abs_diff(other.node) < NEIGHBOUR_NODES;
        if one_surface { self.along < other.along } else { self.gap < other.gap }
    }
}

/// The nodes that lie beside each other on different stretches of one view.
#[derive(Debug)]
pub(super) struct Gaps<'a> {
    seen: &'a [Observation],
    same_way: f64,
    /// For each observation the node beside it; empty until there is one.
    beside: Vec<Option<Beside>>,
    /// Length of its curve up to each observation; empty until then.
    lengths: Vec<f64>,
}

impl<'a> Gaps<'a> {
    pub fn new(seen: &'a [Observation], same_way: f64) -> Self {
        Self { seen, same_way, beside: Vec::new(), lengths: Vec::new() }
    }

    /// Finds the nodes of one stretch that lie beside another.
    pub fn compare(&mut self, a: &Stretch, b: &Stretch) {
        if self.beside.is_empty() {
            self.beside.resize(self.seen.len(), None);
            self.lengths = lengths_up_to(self.seen);
        }
        for i in a.first as usize..a.end as usize {
            let nearest = self.nearest(i, b).filter(|found| {
                let way = (self.lengths[i] - self.lengths[found.node]).abs();
                a.curve != b.curve || way >= WAY_ROUND * found.gap
            });
            let before = &mut self.beside[i];
            if let Some(found) = nearest
                && before.as_ref().is_none_or(|b| found.rather_than(b))
            {
                *before = Some(found);
            }
        }
    }

    fn nearest(&self, i: usize, b: &Stretch) -> Option<Beside> {
        let there = |j: usize| lies_beside(&self.seen[i], &self.seen[j], j, self.same_way);
        let beside = (b.first as usize..b.end as usize).filter_map(there);
        beside.min_by(|a, b| a.along.total_cmp(&b.along))
    }

    /// The gaps that several nodes in a row show.
    pub fn in_rows(&self) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let mut row: Vec<Beside> = Vec::new();
        for (k, here) in self.beside.iter().enumerate() {
            let counted = here.filter(|h| h.counts);
            row.extend(counted);
            let goes_on = counted.is_some() && self.seen[k].next == k as u32 + 1;
            if !goes_on {
                let first = k + usize::from(counted.is_some()) - row.len();
                gaps_of_row(&row, first, &mut gaps);
                row.clear();
            }
        }
        gaps
    }
}

/// Node `node` of a view as one beside another of the same view, if it runs the same way.
fn lies_beside(
    here: &Observation,
    there: &Observation,
    node: usize,
    same_way: f64,
) -> Option<Beside> {
    let d = there.position - here.position;
    let along = d.dot(&here.tangent).abs();
    let beside = along <= here.footprint.max(there.footprint)
        && here.tangent.dot(&there.tangent) >= same_way;
    if !beside {
        return None;
    }
    let gap = (here.tangent + there.tangent).try_normalize(1e-9)?.perp(&d).abs();
    let counts = here.taper.min(there.taper) >= LEAST_TAPER;
    let variance = here.sigma.powi(2) + there.sigma.powi(2);
    (gap <= search_distance(here)).then_some(Beside { gap, variance, counts, node, along })
}

/// Where a view saw two layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub observation: u32,
    pub gap: f64,
    /// Mean gap over more nodes around, in standard deviations.
    pub sigmas: f64,
}

fn gaps_of_row(row: &[Beside], first: usize, gaps: &mut Vec<Gap>) {
    if row.len() < MIN_ROW {
        return;
    }
    for k in 0..row.len() {
        let (near, far) =
            (MeanGap::around(row, k, MEAN_NODES), MeanGap::around(row, k, FAR_MEAN_NODES));
        // Noise makes gaps of its own size.
        if near.sigmas >= MIN_GAP_SIGMAS && far.sigmas >= MIN_GAP_SIGMAS {
            let observation = (first + k) as u32;
            gaps.push(Gap { observation, gap: near.gap, sigmas: far.sigmas });
        }
    }
}

/// The mean gap of nodes in a row.
struct MeanGap {
    gap: f64,
    /// The same in standard deviations of a node.
    sigmas: f64,
}

impl MeanGap {
    /// Of a node of a row and some on each side of it.
    fn around(row: &[Beside], k: usize, around: usize) -> Self {
        let around = &row[k.saturating_sub(around)..(k + around + 1).min(row.len())];
        let count = around.len() as f64;
        let gap = around.iter().map(|b| b.gap).sum::<f64>() / count;
        let variance = 0.5 * around.iter().map(|b| b.variance).sum::<f64>() / count;
        Self { gap, sigmas: gap / variance.sqrt() }
    }
}
