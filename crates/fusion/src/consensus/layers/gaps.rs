//! How far apart the stretches of a view are that run side by side.

use super::super::observations::Observation;
use super::super::spread::search_distance;
use super::stretches::{Stretch, WAY_ROUND};

/// Nodes whose numbers differ by less are of one surface.
const NEIGHBOURS: usize = 8;

/// Smallest taper of nodes that tell of a gap: those near open ends do not.
const LEAST_TAPER: f64 = 0.3;

/// Fewest nodes in a row that tell of a gap, and of how many on each side its mean is taken.
const ROW: usize = 5;
const AROUND: usize = 4;

/// The same for deciding whether there is one: by few it would be decided now this way, now that.
const FAR_AROUND: usize = 20;

/// Smallest gap of one view, in standard deviations of a node.
const LEAST_SIGMAS: f64 = 3.0;

/// Length of each curve up to each of its nodes.
fn ways(seen: &[Observation]) -> Vec<f64> {
    let mut ways: Vec<f64> = Vec::with_capacity(seen.len());
    for (k, o) in seen.iter().enumerate() {
        let before = k.checked_sub(1).filter(|b| seen[*b].next == k as u32);
        ways.push(before.map_or(0.0, |b| ways[b] + (o.position - seen[b].position).norm()));
    }
    ways
}

/// A node that another stretch of its view runs beside.
#[derive(Debug, Clone, Copy)]
struct Beside {
    gap: f64,
    /// Sum of the variances of both nodes.
    variance: f64,
    /// Whether both are far enough from open ends.
    told: bool,
    /// The other node, and its distance along the curve.
    node: usize,
    along: f64,
}

impl Beside {
    /// Whether this one rather than another is beside the node: of one surface's nodes the one that is
    /// nearest along the curve, of two surfaces the nearer.
    fn rather_than(&self, other: &Self) -> bool {
        let one_surface = self.node.abs_diff(other.node) < NEIGHBOURS;
        if one_surface { self.along < other.along } else { self.gap < other.gap }
    }
}

/// What lies beside the nodes of a plane on other stretches of their views.
#[derive(Debug)]
pub(super) struct Gaps<'a> {
    seen: &'a [Observation],
    same_way: f64,
    /// For each observation what lies beside it; empty until there is something.
    beside: Vec<Option<Beside>>,
    /// Length of its curve up to each observation; empty as long.
    ways: Vec<f64>,
}

impl<'a> Gaps<'a> {
    pub fn new(seen: &'a [Observation], same_way: f64) -> Self {
        Self { seen, same_way, beside: Vec::new(), ways: Vec::new() }
    }

    /// Looks for what lies beside the nodes of one stretch on another.
    pub fn look(&mut self, a: &Stretch, b: &Stretch) {
        if self.beside.is_empty() {
            self.beside.resize(self.seen.len(), None);
            self.ways = ways(self.seen);
        }
        for i in a.first as usize..a.end as usize {
            let nearest = self.nearest(i, b).filter(|found| {
                let way = (self.ways[i] - self.ways[found.node]).abs();
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
        let there = |j: usize| lies_beside(&self.seen[i], (j, &self.seen[j]), self.same_way);
        let beside = (b.first as usize..b.end as usize).filter_map(there);
        beside.min_by(|a, b| a.along.total_cmp(&b.along))
    }

    /// The gaps that several nodes in a row tell of.
    pub fn in_rows(&self) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let mut row: Vec<Beside> = Vec::new();
        for (k, here) in self.beside.iter().enumerate() {
            let told = here.filter(|h| h.told);
            row.extend(told);
            let goes_on = told.is_some() && self.seen[k].next == k as u32 + 1;
            if !goes_on {
                let first = k + usize::from(told.is_some()) - row.len();
                gaps_of_row(&row, first, &mut gaps);
                row.clear();
            }
        }
        gaps
    }
}

/// A node as one beside another of its view, if it runs the same way.
fn lies_beside(
    here: &Observation,
    (node, there): (usize, &Observation),
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
    let told = here.taper.min(there.taper) >= LEAST_TAPER;
    let variance = here.sigma.powi(2) + there.sigma.powi(2);
    (gap <= search_distance(here)).then_some(Beside { gap, variance, told, node, along })
}

/// Where a view saw two layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gap {
    pub observation: u32,
    pub gap: f64,
    /// Mean gap in standard deviations, of more nodes around.
    pub sigmas: f64,
}

fn gaps_of_row(row: &[Beside], first: usize, gaps: &mut Vec<Gap>) {
    if row.len() < ROW {
        return;
    }
    for k in 0..row.len() {
        let (gap, variance) = mean_around(row, k, AROUND);
        let (of_many, variance_of_many) = mean_around(row, k, FAR_AROUND);
        // Noise makes gaps of its own size.
        if gap * gap >= LEAST_SIGMAS * LEAST_SIGMAS * variance
            && of_many * of_many >= LEAST_SIGMAS * LEAST_SIGMAS * variance_of_many
        {
            gaps.push(Gap {
                observation: (first + k) as u32,
                gap,
                sigmas: of_many / variance_of_many.sqrt(),
            });
        }
    }
}

/// Mean gap and mean variance of a node, of those around one in a row.
fn mean_around(row: &[Beside], k: usize, around: usize) -> (f64, f64) {
    let around = &row[k.saturating_sub(around)..(k + around + 1).min(row.len())];
    let count = around.len() as f64;
    let gap = around.iter().map(|b| b.gap).sum::<f64>() / count;
    (gap, 0.5 * around.iter().map(|b| b.variance).sum::<f64>() / count)
}
