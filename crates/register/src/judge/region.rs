//! Parts of a view that contradict the other views while the rest of it agrees: objects that moved
//! between two views, and mirrors.
//!
//! **Problem.** A patch of A lies where B saw free space. Either A saw an object that was not
//! always there, or B looked through a surface (a mirror, a window).
//!
//! **Idea.** The others decide: a cell is named where two other views or more contradict it, and
//! cells beside each other make a region.

use super::evidence::Evidence;
use super::pair::{Placed, Sample, probes, samples};
use super::tuning::{REACH, REGION_CELLS, REGION_FRONT, REGION_HINTS, REGION_WITNESSES};
use super::{Region, RegionKind};
use std::collections::{BTreeMap, BTreeSet};

/// Largest distance between cells of one region, in cells. Chosen by hand: a cell that lacks
/// samples does not part a region. Doubled, things beside each other are one region.
const APART: usize = 2;

/// Regions of a view, and the cells they have.
pub(super) struct Regions {
    pub regions: Vec<Region>,
    pub cells: BTreeSet<usize>,
}

/// The regions of a view that two or more of the `right` views contradict.
pub(super) fn regions(evidence: &Evidence<'_>, view: usize, right: &[usize]) -> Regions {
    let mut found = Regions { regions: Vec::new(), cells: BTreeSet::new() };
    for kind in [RegionKind::InFront, RegionKind::SeenThrough] {
        let hints = |other: &usize| {
            let pair = match kind {
                RegionKind::InFront => evidence.between(view, *other),
                RegionKind::SeenThrough => evidence.between(*other, view),
            };
            pair.iter().filter(|s| gross(evidence, s)).count()
        };
        let mut accusers: Vec<(usize, usize)> =
            right.iter().map(|other| (hints(other), *other)).collect();
        accusers.retain(|(hints, _)| *hints >= REGION_HINTS);
        accusers.sort_by_key(|(hints, other)| (std::cmp::Reverse(*hints), *other));
        accusers.truncate(REGION_WITNESSES);
        if accusers.len() < 2 {
            continue;
        }
        let accusers: Vec<usize> = accusers.into_iter().map(|(_, other)| other).collect();
        let accused = accused_cells(evidence, view, &accusers, kind);
        for cells in neighbours(evidence, view, &accused) {
            found.regions.push(region(evidence, view, &accused, &cells, kind));
            found.cells.extend(cells);
        }
    }
    found
}

/// Whether a patch is so far in front of what the other view saw that no pose explains it.
fn gross(evidence: &Evidence<'_>, sample: &Sample) -> bool {
    let errors = REGION_FRONT[0] * (evidence.usual + sample.sigma);
    !sample.met && sample.distance > errors.max(REGION_FRONT[1] * sample.radius)
}

/// The cells that two views contradict: each with the views and the distances.
type Accused = BTreeMap<usize, BTreeMap<usize, f64>>;

fn accused_cells(
    evidence: &Evidence<'_>,
    view: usize,
    accusers: &[usize],
    kind: RegionKind,
) -> Accused {
    let (views, at) = (evidence.views, &evidence.placings);
    let mut accused = Accused::new();
    for &other in accusers {
        let (from, to) = match kind {
            RegionKind::InFront => (view, other),
            RegionKind::SeenThrough => (other, view),
        };
        let all = probes(views[from], usize::MAX);
        let placed = |k: usize| Placed { view: views[k], at: at[k] };
        for sample in samples(&all, placed(from), placed(to), REACH) {
            if gross(evidence, &sample) {
                let cell = match kind {
                    RegionKind::InFront => sample.cell,
                    RegionKind::SeenThrough => sample.other_cell,
                };
                let distance = accused.entry(cell).or_default().entry(other).or_insert(0.0);
                *distance = sample.distance.max(*distance);
            }
        }
    }
    accused.retain(|_, by| by.len() > 1);
    accused
}

/// Cells within [`APART`] of each other, where they are many.
fn neighbours(evidence: &Evidence<'_>, view: usize, accused: &Accused) -> Vec<Vec<usize>> {
    let coarse = evidence.views[view];
    let mut left: BTreeSet<usize> = accused.keys().copied().collect();
    let mut groups = Vec::new();
    while let Some(first) = left.pop_first() {
        let (mut group, mut next) = (vec![first], vec![first]);
        while let Some(cell) = next.pop() {
            for near in coarse.around(cell, APART) {
                if left.remove(&near) {
                    group.push(near);
                    next.push(near);
                }
            }
        }
        if group.len() >= coarse.as_many_as(REGION_CELLS) {
            groups.push(group);
        }
    }
    groups
}

fn region(
    evidence: &Evidence<'_>,
    view: usize,
    accused: &Accused,
    cells: &[usize],
    kind: RegionKind,
) -> Region {
    let coarse = evidence.views[view];
    let cols = coarse.size().cols;
    let rows: BTreeSet<usize> = cells.iter().map(|cell| cell / cols).collect();
    let in_row: BTreeSet<usize> = cells.iter().map(|cell| cell % cols).collect();
    let span = |cells: &BTreeSet<usize>| [cells.first(), cells.last()].map(|c| *c.unwrap_or(&0));
    // Only a region across the seam of an image has a gap: it begins behind it.
    let gap = in_row.iter().zip(in_row.iter().skip(1)).find(|(a, b)| *b - *a > APART);
    let of_cols = gap.map_or_else(|| span(&in_row), |(before, behind)| [*behind, *before]);
    // The last cells may reach beyond the image.
    let (image, step) = (coarse.image_size(), coarse.step());
    let pixels = |[low, high]: [usize; 2], size: usize| {
        [low * step, ((high + 1) * step - 1).min(size.saturating_sub(1))]
    };
    let by = || cells.iter().filter_map(|cell| accused.get(cell)).flatten();
    let distances = by().map(|(_, distance)| *distance);
    Region {
        view: coarse.name().to_owned(),
        kind,
        rows: pixels(span(&rows), image.rows),
        cols: pixels(of_cols, image.cols),
        distance: transect_device::median(distances).unwrap_or(0.0),
        views: by().map(|(other, _)| other).collect::<BTreeSet<_>>().len(),
        cells: cells.len(),
    }
}
