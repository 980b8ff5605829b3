//! All nodes of all views on a plane, in canonical order, with direction and weight.

use super::super::options::Steps;
use super::super::tuning::observations::*;
use super::arc::Arc;
use super::view_error::ViewError;
use nalgebra::Vector3;
use std::cmp::Ordering;
use transect_geometry::{Curve, EndReason, Node, Point2, Vector2};

/// The number of no observation and of no node.
pub(crate) const NONE: u32 = u32::MAX;

/// One node of one view.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Observation {
    pub position: Point2,
    /// Unit direction of the view's curve.
    pub tangent: Vector2,
    /// Standard deviation across the curve from noise and sampling, without the view's systematic
    /// error.
    pub sigma: f64,
    pub footprint: f64,
    /// Length along the curve over which nodes of the view share their errors.
    pub correlation: f64,
    /// Tangent of the angle between the ray and the surface's normal; `None` where not known.
    pub tan_incidence: Option<f32>,
    /// Standard deviation of the view's systematic error here, which neighbouring nodes share. Set
    /// by [`Observations::weigh`].
    pub view_error: f64,
    /// Standard deviation of the common course of all views that it moved onto, which neighbouring
    /// nodes of all views share; 0 if it did not move. Set by `settle`.
    pub course_error: f64,
    /// Outward unit normal of the surface; `None` where not known.
    pub normal: Option<Vector3<f32>>,
    /// How many observations the node counts as: its weight times the taper.
    pub support: f64,
    /// Weight in an average: support over variance. [`Observations::weigh`] adds the view's error.
    pub weight: f64,
    /// Number of the view in canonical order.
    pub view: u32,
    /// The observation that follows on the view's curve, or [`NONE`].
    pub next: u32,
    /// Whether the view did not measure the ground up to the next observation.
    pub bridged: bool,
}

impl Observation {
    /// Squared tangent of the incidence. Unknown counts as head-on, which adds no error.
    pub fn squared_tangent(&self) -> f64 {
        self.tan_incidence.map_or(0.0, |tan| f64::from(tan).powi(2))
    }

    /// Variance of its view's systematic error here.
    pub fn view_variance(&self, error: &ViewError) -> f64 {
        error.variance(self.sigma, self.squared_tangent())
    }
}

/// Where a view's curve begins or ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ViewEnd {
    /// Number of the observation there.
    pub observation: u32,
    /// Number of the curve's first observation.
    pub curve: u32,
    /// Whether the curve ends there; otherwise it begins.
    pub is_last: bool,
    pub reason: EndReason,
}

/// All observations of a plane.
#[derive(Debug, Default)]
pub(crate) struct Observations {
    pub all: Vec<Observation>,
    /// For each different view in canonical order, its place among the views as given.
    pub sources: Vec<usize>,
    /// Where the views' curves begin and end, if the reason is known.
    pub ends: Vec<ViewEnd>,
    /// Median footprint.
    spacing: f64,
}

impl Observations {
    /// Collects the curves of all views. The order of views and of the curves within a view has no
    /// effect. A view that comes twice counts once, since it measured nothing new.
    pub fn collect(views: &[&[Curve]], steps: &Steps) -> Self {
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
        let mut observations = Self::default();
        sorted.dedup_by(|(_, b), (_, a)| order(a, b).is_eq());
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

    /// Adds the views' systematic errors to all weights. Nodes of one view share such an error, so
    /// averaging them does not reduce it, however well they agree with each other.
    pub fn weigh(&mut self, view_error: &ViewError) {
        for o in &mut self.all {
            let variance = o.view_variance(view_error);
            // What has moved onto a common course has the course's error instead.
            o.view_error = if o.course_error > 0.0 { 0.0 } else { variance.sqrt() };
            o.weight = o.support / (o.sigma * o.sigma + variance);
        }
    }

    /// Whether no observation has an error that it shares with others of its view.
    pub fn err_by_noise_alone(&self) -> bool {
        self.all.iter().all(|o| o.course_error == 0.0 && o.view_error == 0.0)
    }

    /// Median standard deviation of a single pixel across a curve. A node that shares its error
    /// over a width of w pixels is an average of w² pixels, so the error of one is w times as
    /// large.
    pub fn pixel_noise(&self) -> f64 {
        let of_pixel = |o: &Observation| o.sigma * (o.correlation / o.footprint).max(1.0);
        median(self.all.iter().map(of_pixel))
    }

    fn push(&mut self, curve: &Curve, view: u32, steps: &Steps) {
        let arc = Arc::new(curve);
        let measured = measured_nodes(curve);
        // A curve whose nodes are all in one place has no direction.
        let Some(last) = measured.len().checked_sub(1).filter(|_| arc.length > 0.0) else { return };
        let start = self.all.len() as u32;
        let closing = measured.first().filter(|_| curve.is_closed()).map(|first| (start, *first));
        for (number, &k) in measured.iter().enumerate() {
            let next = measured.get(number + 1).map(|k| (start + number as u32 + 1, *k));
            let next = next.or(closing);
            let after = (k + 1) % curve.nodes().len();
            let follows = next.map_or(measured[0], |next| next.1) == after;
            let seen = observation(&arc, k, steps);
            self.all.push(Observation {
                view,
                next: next.map_or(NONE, |next| next.0),
                bridged: seen.bridged || !follows,
                ..seen
            });
        }
        let ends = [(start, false), (start + last as u32, true)];
        for (reason, (observation, is_last)) in curve.ends().into_iter().zip(ends) {
            self.ends.extend(reason.map(|reason| ViewEnd {
                observation,
                curve: start,
                is_last,
                reason,
            }));
        }
    }
}

/// A node of a curve with its direction and errors, not yet linked to others.
fn observation(arc: &Arc<'_>, k: usize, steps: &Steps) -> Observation {
    let node = &arc.curve.nodes()[k];
    let mean_step = arc.length / arc.curve.units().len() as f64;
    // Without a stated sample spacing, the distance between nodes stands for it.
    let known = f64::from(node.footprint) > LEAST_FOOTPRINT * mean_step;
    let footprint = if known { f64::from(node.footprint) } else { mean_step };
    let (least, most) = (SAMPLING_SHARES[0] * footprint, SAMPLING_SHARES[1] * footprint);
    let sampling = if steps.sampling_error { arc.roughness(k).clamp(least, most) } else { least };
    let own = f64::from(node.sigma);
    let sigma = (own * own + sampling * sampling).sqrt();
    let full_weight = FULL_WEIGHT_FOOTPRINTS * footprint;
    let taper = if steps.end_taper {
        (arc.to_open_end(k) / full_weight).clamp(LEAST_TAPER, 1.0)
    } else {
        1.0
    };
    let support = f64::from(node.weight) * taper;
    let reach = (TANGENT_FOOTPRINTS * footprint).max(TANGENT_SIGMAS * own);
    Observation {
        position: node.position,
        tangent: arc.tangent(k, reach),
        sigma,
        footprint,
        correlation: if steps.shared_errors { f64::from(node.correlation) } else { 0.0 },
        tan_incidence: node.tan_incidence,
        view_error: 0.0,
        course_error: 0.0,
        normal: node.normal,
        support,
        weight: support / (sigma * sigma),
        view: NONE,
        next: NONE,
        bridged: node.bridged,
    }
}

/// The nodes of a curve with a measured unit on at least one side; a node between two bridges has
/// no direction.
fn measured_nodes(curve: &Curve) -> Vec<usize> {
    let nodes = curve.nodes();
    let n = nodes.len();
    let measured = |k: usize| !nodes[k % n].bridged && (k % n + 1 < n || curve.is_closed());
    (0..n).filter(|&k| measured(k + n - 1) || measured(k)).collect()
}

/// A total order of curves by everything known of them, so that results do not depend on the order
/// of the input.
pub(crate) fn canonical(a: &Curve, b: &Curve) -> Ordering {
    let pairs = a.nodes().iter().zip(b.nodes());
    let differing = pairs.map(|(a, b)| canonical_node(a, b)).find(|o| o.is_ne());
    differing
        .unwrap_or(a.nodes().len().cmp(&b.nodes().len()))
        .then(a.is_closed().cmp(&b.is_closed()))
        .then(a.ends().cmp(&b.ends()))
}

fn canonical_node(a: &Node, b: &Node) -> Ordering {
    let values = |n: &Node| {
        let normal = n.normal.unwrap_or_default();
        let tan_incidence = n.tan_incidence.unwrap_or(0.0);
        let [bridged, has_normal, has_incidence] =
            [n.bridged, n.normal.is_some(), n.tan_incidence.is_some()]
                .map(|b| f32::from(u8::from(b)));
        let flags = [bridged, has_normal, has_incidence];
        let known = [n.correlation, tan_incidence, normal.x, normal.y, normal.z];
        let places = [n.position.x, n.position.y].into_iter();
        let measures = [n.sigma, n.footprint, n.weight, n.view_count() as f32];
        places.chain(measures.into_iter().chain(known).chain(flags).map(f64::from))
    };
    let mut orders = values(a).zip(values(b)).map(|(a, b)| a.total_cmp(&b));
    orders.find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_between_nodes_stands_for_an_unknown_footprint() {
        let places = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
        for closed in [false, true] {
            let nodes = places.map(|(x, y)| Node::at(Point2::new(x, y))).to_vec();
            let curves = [Curve::new(nodes, closed).unwrap()];
            let observations = Observations::collect(&[&curves], &Steps::default());
            assert!(observations.all.iter().all(|o| o.footprint == 1.0), "{closed}");
        }
    }
}
