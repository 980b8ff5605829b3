//! All nodes of all views on a plane, in canonical order, with direction and weight.

use super::arc::Arc;
use super::common::Common;
use nalgebra::Vector3;
use std::cmp::Ordering;
use transect_geometry::{Curve, EndReason, Node, Point2, Vector2};

/// No observation.
pub(crate) const NONE: u32 = u32::MAX;

/// How many footprints from an open end a node reaches its full weight. Real scanners overshoot
/// silhouettes by a few pixels; doubling this costs little on clean data.
const TAPER_FOOTPRINTS: f64 = 8.0;

/// Weight of a node at an open end: small, but enough to stand where nothing else was seen.
const LEAST_TAPER: f64 = 0.02;

/// Arc on each side of a node that gives its direction, in footprints and in standard deviations.
const TANGENT_FOOTPRINTS: f64 = 2.5;
const TANGENT_SIGMAS: f64 = 3.0;

/// Bounds of the sampling error of a node, as shares of its footprint: where a curve bends sharply no
/// more is said of it, and the least keeps noise-free data finite.
const SAMPLING_SHARES: (f64, f64) = (0.002, 0.06);

/// Smallest believable footprint, as a share of the mean distance between a curve's nodes.
const LEAST_FOOTPRINT: f64 = 1e-3;

/// One node of one view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Observation {
    pub position: Point2,
    /// Unit direction of the view's curve.
    pub tangent: Vector2,
    /// Standard deviation across the curve: noise and sampling, not what its view has in common.
    pub sigma: f64,
    pub footprint: f64,
    /// Length along the curve over which nodes of its view share their errors.
    pub correlation: f64,
    /// Tangent of the angle between the ray and the surface's normal.
    pub tan_incidence: f64,
    /// Standard deviation of what its view errs by in common, of which [`Observations::weigh`] has a say.
    pub common: f64,
    /// Outward unit normal of the surface, or zero.
    pub normal: Vector3<f32>,
    /// How far it is from an open end of its curve: from little at the end to 1.
    pub taper: f64,
    /// How much it counts as an observation: the node's weight, less towards open ends.
    pub credit: f64,
    /// Weight in an average: the credit over the variance, of which [`Observations::weigh`] has a say.
    pub weight: f64,
    /// Number of the view in canonical order.
    pub view: u32,
    /// The observation that follows on the view's curve, or [`NONE`].
    pub next: u32,
    /// Whether the view did not see the ground up to the next.
    pub bridged: bool,
}

/// Where a view's curve begins or ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewEnd {
    /// Number of the observation there.
    pub observation: u32,
    /// Whether the curve ends there; else it begins.
    pub is_last: bool,
    pub reason: EndReason,
}

/// All observations of a plane.
#[derive(Debug, Default)]
pub(crate) struct Observations {
    pub all: Vec<Observation>,
    /// For each different view in canonical order, its place among the views as given.
    pub sources: Vec<usize>,
    /// Where the views' curves begin and end, as far as anyone knows why.
    pub ends: Vec<ViewEnd>,
    /// Median footprint.
    spacing: f64,
    /// Half the gap between layers around each observation; empty where no view saw layers.
    pub rooms: Vec<f64>,
}

impl Observations {
    /// Collects the curves of all views. Neither the order of views nor that of the curves within a
    /// view matters, and a view that comes twice counts once: it saw nothing new.
    pub fn collect(views: &[&[Curve]], steps: &super::Steps) -> Self {
        let mut sorted: Vec<(usize, Vec<&Curve>)> = Vec::new();
        for (source, curves) in views.iter().enumerate().filter(|(_, c)| !c.is_empty()) {
            let mut curves: Vec<&Curve> = curves.iter().collect();
            curves.sort_by(|a, b| canonical(a, b));
            sorted.push((source, curves));
        }
        let order = |a: &[&Curve], b: &[&Curve]| {
            let differing = a.iter().zip(b).map(|(a, b)| canonical(a, b)).find(|o| o.is_ne());
            differing.unwrap_or(a.len().cmp(&b.len()))
        };
        sorted.sort_by(|(_, a), (_, b)| order(a, b));
        sorted.dedup_by(|(_, b), (_, a)| order(a, b).is_eq());
        let mut observations = Self::default();
        let curves = sorted.iter().flat_map(|(_, curves)| curves);
        observations.all.reserve(curves.map(|c| c.nodes().len()).sum());
        for (view, (source, curves)) in sorted.iter().enumerate() {
            observations.sources.push(*source);
            curves.iter().for_each(|c| observations.push(c, view as u32, steps));
        }
        observations.spacing = median(observations.all.iter().map(|o| o.footprint));
        observations
    }

    pub fn positions(&self) -> Vec<Point2> {
        self.all.iter().map(|o| o.position).collect()
    }

    /// Median footprint.
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Half the gap to the next layer at an observation; infinite where no view saw one.
    pub fn room(&self, k: usize) -> f64 {
        self.rooms.get(k).copied().unwrap_or(f64::INFINITY)
    }

    /// Takes into account, in all weights, what the nodes of a view err by in common: a view whose own
    /// nodes agree ever so well is no nearer to the truth than views agree with each other.
    pub fn weigh(&mut self, common: &Common) {
        for o in &mut self.all {
            let variance = common.variance(o.tan_incidence * o.tan_incidence);
            o.common = variance.sqrt();
            o.weight = o.credit / (o.sigma * o.sigma + variance);
        }
    }

    /// Median standard deviation across a curve of a single pixel: errors shared over n pixels are what
    /// is left of one n times as large.
    pub fn pixel_noise(&self) -> f64 {
        let of_pixel = |o: &Observation| o.sigma * (o.correlation / o.footprint).max(1.0);
        median(self.all.iter().map(of_pixel))
    }

    fn push(&mut self, curve: &Curve, view: u32, steps: &super::Steps) {
        let nodes = curve.nodes();
        let arc = Arc::new(curve);
        // A curve whose nodes are all in one place has no direction.
        if arc.length <= 0.0 {
            return;
        }
        let mean_step = arc.length / nodes.len() as f64;
        let seen = seen(curve);
        let (Some(&first), Some(last)) = (seen.first(), seen.len().checked_sub(1)) else { return };
        let start = self.all.len() as u32;
        for (number, &k) in seen.iter().enumerate() {
            let node = &nodes[k];
            // Where nobody says how far the samples are apart, the nodes do.
            let known = f64::from(node.footprint) > LEAST_FOOTPRINT * mean_step;
            let footprint = if known { f64::from(node.footprint) } else { mean_step };
            let (least, most) = SAMPLING_SHARES;
            let sampling = arc.roughness(k).clamp(least * footprint, most * footprint);
            let sampling = if steps.sampling_error { sampling } else { least * footprint };
            let own = f64::from(node.sigma);
            let sigma = (own * own + sampling * sampling).sqrt();
            let taper =
                (arc.to_open_end(k) / (TAPER_FOOTPRINTS * footprint)).clamp(LEAST_TAPER, 1.0);
            let taper = if steps.taper { taper } else { 1.0 };
            let credit = f64::from(node.weight) * taper;
            let next = match seen.get(number + 1) {
                Some(_) => start + number as u32 + 1,
                None if curve.is_closed() => start,
                None => NONE,
            };
            let follower = seen.get(number + 1).copied().unwrap_or(first);
            self.all.push(Observation {
                position: node.position,
                tangent: arc.tangent(k, reach(footprint, node)),
                sigma,
                footprint,
                correlation: if steps.shared_errors { f64::from(node.correlation) } else { 0.0 },
                tan_incidence: node
                    .tan_incidence
                    .filter(|_| steps.incidence_error)
                    .map_or(0.0, f64::from),
                common: 0.0,
                normal: node.normal.unwrap_or_default(),
                taper,
                credit,
                weight: credit / (sigma * sigma),
                view,
                next,
                bridged: node.bridged || follower != (k + 1) % nodes.len(),
            });
        }
        let ends = [(start, false), (start + last as u32, true)];
        for (reason, (observation, is_last)) in curve.ends().into_iter().zip(ends) {
            self.ends.extend(reason.map(|reason| ViewEnd { observation, is_last, reason }));
        }
    }
}

/// The nodes of a curve with a unit that was seen: one between two bridges has no direction.
fn seen(curve: &Curve) -> Vec<usize> {
    let nodes = curve.nodes();
    let n = nodes.len();
    if !nodes.iter().any(|node| node.bridged) {
        return (0..n).collect();
    }
    let before = |k: usize| {
        let before = if k > 0 { Some(k - 1) } else { curve.is_closed().then_some(n - 1) };
        before.is_some_and(|b| !nodes[b].bridged)
    };
    let after = |k: usize| !nodes[k].bridged && (k + 1 < n || curve.is_closed());
    (0..n).filter(|&k| before(k) || after(k)).collect()
}

fn reach(footprint: f64, node: &Node) -> f64 {
    (TANGENT_FOOTPRINTS * footprint).max(TANGENT_SIGMAS * f64::from(node.sigma))
}

/// Incidence and normal of a node as numbers to be ordered by; 0 where they are not known.
fn directions(node: &Node) -> [f32; 4] {
    let normal = node.normal.unwrap_or_default();
    [node.tan_incidence.unwrap_or(0.0), normal.x, normal.y, normal.z]
}

/// A total order of curves by all that is known of them, so that results depend on what was seen
/// alone.
pub(crate) fn canonical(a: &Curve, b: &Curve) -> Ordering {
    let node = |a: &Node, b: &Node| {
        let (p, q) = (&a.position, &b.position);
        (p.x.total_cmp(&q.x).then(p.y.total_cmp(&q.y)))
            .then(a.sigma.total_cmp(&b.sigma))
            .then(a.footprint.total_cmp(&b.footprint))
            .then(a.weight.total_cmp(&b.weight))
            .then(a.views.cmp(&b.views))
            .then(a.correlation.total_cmp(&b.correlation))
            .then(a.bridged.cmp(&b.bridged))
            .then_with(|| {
                let differing = directions(a).into_iter().zip(directions(b));
                differing.fold(Ordering::Equal, |o, (a, b)| o.then(a.total_cmp(&b)))
            })
    };
    let differing = a.nodes().iter().zip(b.nodes()).map(|(a, b)| node(a, b)).find(|o| o.is_ne());
    differing
        .unwrap_or(a.nodes().len().cmp(&b.nodes().len()))
        .then(a.is_closed().cmp(&b.is_closed()))
        .then(a.ends().cmp(&b.ends()))
}

/// The median of some values; 0 without values.
pub(crate) fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}
