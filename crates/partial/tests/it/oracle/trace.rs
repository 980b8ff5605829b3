//! From links to chains: open ones from their heads, then what is left, which is closed.

use super::sweep::{Linked, NONE};
use transect_device::Handedness;

/// Crossings in the order of a curve, solid on the left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Chain {
    pub crossings: Vec<u32>,
    pub closed: bool,
}

/// All chains, sorted by plane and then by the number of their first crossing.
pub(super) fn trace(linked: &Linked, handedness: Handedness) -> Vec<Chain> {
    let count = linked.crossings.len();
    let mut visited = vec![false; count];
    let mut chains = Vec::new();
    for closed in [false, true] {
        for start in 0..count {
            let begins = if closed { !visited[start] } else { !linked.has_previous[start] };
            if begins {
                chains.push(Chain { crossings: follow(linked, start, &mut visited), closed });
            }
        }
    }
    chains.sort_by_key(|c| {
        let first = c.crossings[0];
        (linked.crossings[first as usize].level, first)
    });
    if handedness == Handedness::ColumnsLeft {
        chains.iter_mut().for_each(|c| c.crossings.reverse());
    }
    chains
}

fn follow(linked: &Linked, start: usize, visited: &mut [bool]) -> Vec<u32> {
    let mut chain = Vec::new();
    let mut at = start as u32;
    while at != NONE && !visited[at as usize] {
        visited[at as usize] = true;
        chain.push(at);
        at = linked.next[at as usize];
    }
    chain
}
