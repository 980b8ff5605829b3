//! Clusters: the weighted mean of the observations that one thinned node (a stand) took in, at
//! their *original* places.
//!
//! Members of one view share errors, so they count as fewer than they are.

use super::super::measure::{Observation, Observations, Scale};
use super::fit;
use super::node::Evidence;
use super::thin::Stand;
use nalgebra::Vector3;
use transect_geometry::{Point2, Vector2};

/// A thinned node before its final fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cluster {
    /// The place on its rough line, and the direction there.
    pub position: Point2,
    pub tangent: Vector2,
    /// Weighted mean of the places it absorbed.
    pub mean: Point2,
    /// Variance of these places along the curve.
    pub along_variance: f64,
    /// Their weighted mean correlation length.
    pub correlation: f64,
    pub evidence: Evidence,
}

/// Gathers what each stand absorbed.
pub(super) fn clusters(
    observations: &Observations,
    absorbed_by: &[u32],
    stands: &[Stand],
    scale: &Scale,
) -> Vec<Cluster> {
    let mut sums = vec![Sums::default(); stands.len()];
    for (o, &by) in observations.all.iter().zip(absorbed_by) {
        let window = &stands[by as usize].window;
        sums[by as usize].add(o, (o.position - window.centre).dot(&window.tangent));
    }
    let cluster = |(stand, sums): (&Stand, &Sums)| {
        let mut cluster = sums.cluster(stand);
        if !scale.steps().bend_shift {
            cluster.along_variance = 0.0;
        }
        cluster
    };
    stands.iter().zip(&sums).map(cluster).collect()
}

/// Sums over what a stand absorbed. Members come view by view, and along the view's curves.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    weight: f64,
    support: f64,
    position: Vector2,
    along: f64,
    along_squared: f64,
    normal: Vector3<f32>,
    correlation: f64,
    /// Weighted tangent of the incidence, and weight, of members whose incidence is known.
    tan_incidence: f64,
    known_weight: f64,
    views: u32,
    last_view: Option<u32>,
    last_along: f64,
    variance: f64,
    /// Weighted error of earlier members of the same view that the next one shares.
    shared: f64,
    /// Weighted systematic error of the last view's members, and sum of squares of earlier views'.
    of_view: f64,
    of_views: f64,
    /// Weighted error of the common courses that members moved onto. Members of all views share it.
    of_courses: f64,
}

impl Sums {
    fn add(&mut self, o: &Observation, along: f64) {
        if self.last_view != Some(o.view) {
            // Views err independently of each other.
            (self.last_view, self.shared) = (Some(o.view), 0.0);
            self.of_views += self.of_view * self.of_view;
            self.of_view = 0.0;
            self.views += 1;
        }
        let error = o.weight * o.sigma;
        self.shared *= fit::shared(along - self.last_along, o.correlation);
        self.variance += error * (error + 2.0 * self.shared);
        self.shared += error;
        self.last_along = along;
        self.weight += o.weight;
        self.of_view += o.weight * o.view_error;
        self.of_courses += o.weight * o.course_error;
        self.support += o.support;
        self.position += o.position.coords * o.weight;
        self.along += o.weight * along;
        self.along_squared += o.weight * along * along;
        self.normal += o.normal.unwrap_or_default() * o.weight as f32;
        self.correlation += o.weight * o.correlation;
        if let Some(tan) = o.tan_incidence {
            self.tan_incidence += o.weight * f64::from(tan);
            self.known_weight += o.weight;
        }
    }

    fn cluster(&self, stand: &Stand) -> Cluster {
        // A stand whose members have no weight keeps its own place and knows no errors.
        let has_weight = self.weight > 0.0;
        let per_weight = |sum: f64| if has_weight { sum / self.weight } else { 0.0 };
        let squares = self.of_views + self.of_view.powi(2) + self.of_courses.powi(2);
        let along = per_weight(self.along);
        let mean = Point2::from(self.position / self.weight);
        let tan_incidence = (self.tan_incidence / self.known_weight) as f32;
        Cluster {
            position: stand.window.centre,
            tangent: stand.window.tangent,
            mean: if has_weight { mean } else { stand.window.centre },
            along_variance: (per_weight(self.along_squared) - along * along).max(0.0),
            correlation: per_weight(self.correlation),
            evidence: Evidence {
                footprint: stand.footprint,
                random_sigma: per_weight(self.variance.sqrt()),
                view_variance: if has_weight { squares / (self.weight * self.weight) } else { 0.0 },
                weight: self.weight,
                support: self.support,
                views: self.views,
                last_view: self.last_view,
                normal: self.normal.try_normalize(0.0),
                tan_incidence: (self.known_weight > 0.0).then_some(tan_incidence),
            },
        }
    }
}
