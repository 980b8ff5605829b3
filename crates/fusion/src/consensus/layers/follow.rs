//! The neighbours of a kept node that lie in its own layer.

use super::super::Kept;

/// How far across the curve the place on its rough line lies from each kept node's cluster. Empty where no
/// node has a layer beside it.
pub(in super::super) fn off_line(kept: &[Kept]) -> Vec<f64> {
    if kept.iter().all(|k| k.room.is_infinite()) {
        return Vec::new();
    }
    kept.iter().map(|k| k.tangent.perp(&(k.position - k.cluster))).collect()
}

/// A place along and across a curve, and its slope there.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Step {
    pub x: f64,
    pub y: f64,
    pub slope: f64,
}

/// Of places in order along a curve through the origin keeps those of its own layer: from the origin on
/// each lies within the room of where the one before it leads.
pub(in super::super) fn keep_own<T>(all: &mut Vec<T>, place: impl Fn(&T) -> Step, room: f64) {
    let follow = |from: Step, to: Step| {
        let expected = from.y + from.slope * (to.x - from.x);
        (to.y - expected).abs() <= room
    };
    let mut keep = vec![false; all.len()];
    let middle = all.partition_point(|p| place(p).x < 0.0);
    let origin = Step { x: 0.0, y: 0.0, slope: 0.0 };
    let mut walk = |numbers: &mut dyn Iterator<Item = usize>| {
        let mut last = origin;
        for k in numbers {
            let here = place(&all[k]);
            if follow(last, here) {
                (keep[k], last) = (true, here);
            }
        }
    };
    walk(&mut (middle..all.len()));
    walk(&mut (0..middle).rev());
    let mut keep = keep.into_iter();
    all.retain(|_| keep.next() == Some(true));
}
