//! The neighbours of a node that lie in its own layer.

use super::cluster::Cluster;

/// How far across the curve the place on the rough line lies from each cluster's mean. Empty where no
/// node has a layer beside it.
pub(super) fn off_line(clusters: &[Cluster]) -> Vec<f64> {
    if clusters.iter().all(|c| c.evidence.half_gap.is_infinite()) {
        return Vec::new();
    }
    clusters.iter().map(|c| c.tangent.perp(&(c.position - c.mean))).collect()
}

/// A place along and across a curve, and its slope there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub x: f64,
    pub y: f64,
    pub slope: f64,
}

/// Keeps the places of the layer through the origin: from there on, each place lies within half the
/// gap of where the one before it leads. The places are in order along the curve.
pub(super) fn keep_own<T>(all: &mut Vec<T>, place: impl Fn(&T) -> Step, half_gap: f64) {
    let follow = |from: Step, to: Step| {
        let expected = from.y + from.slope * (to.x - from.x);
        (to.y - expected).abs() <= half_gap
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bent_layer_is_followed_and_the_next_one_left() {
        let layer = |height: f64| {
            (-20..=20).map(move |k| {
                let x = 0.1 * f64::from(k);
                (Step { x, y: 0.5 * x * x + height, slope: x }, height)
            })
        };
        let mut all: Vec<(Step, f64)> = layer(0.0).chain(layer(0.2)).chain(layer(-0.2)).collect();
        all.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        keep_own(&mut all, |p| p.0, 0.1);
        assert_eq!(all.len(), 41);
        assert!(all.iter().all(|p| p.1 == 0.0));
    }
}
