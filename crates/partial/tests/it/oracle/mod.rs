//! The slow and obvious way to the same lines: one crossing, one cell, one link at a time, in
//! `f64`, chains followed over the whole image.

mod cell;
mod crossing;
mod sweep;
mod trace;

pub use crossing::Crossing;
use transect_device::View;
use transect_partial::SectionAxes;
use transect_partial::one_pass::Seen;

/// A line as a list of crossings, solid on the left.
#[derive(Debug, Clone)]
pub struct Chain {
    pub closed: bool,
    pub crossings: Vec<Crossing>,
}

/// All lines of a view, from the levels and pairs that the sweep sees.
pub fn chains(view: &View, axes: &SectionAxes, seen: &Seen) -> Vec<Chain> {
    let linked = sweep::sweep(view, axes, seen);
    let of = |chain: trace::Chain| Chain {
        closed: chain.closed,
        crossings: chain.crossings.iter().map(|&k| linked.crossings[k as usize]).collect(),
    };
    trace::trace(&linked, view.frame().handedness()).into_iter().map(of).collect()
}
