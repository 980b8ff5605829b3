//! The views' curves are moved onto their common course, before the topology is decided.
//!
//! **Problem.** Poses, distortion and correlated noise displace each view's curve by more than a
//! sample is wide. The nodes of several views then interleave. Links hop from the curve of one view
//! to that of another, so the result zigzags, doubles and crosses itself.
//!
//! **Idea.** A volumetric method averages the distances to all views' surfaces first, and only then
//! looks for the surface. Here every node moves across the curve onto the average of all views
//! around it. This is a projection onto a moving least squares parabola (Alexa et al., 2003). A
//! view counts by how far it errs there (`view_error.rs`), not by how densely it sampled. Direction
//! still tells surfaces apart, so both sides of a thin wall stay.
//!
//! **Steps.**
//! 1. Each view is shifted and turned as a whole (`align.rs`).
//! 2. Each view's curves are cut into beads, which are short pieces. Each bead moves onto the
//!    course through the beads around it (`common_course.rs`). The course is the one of the widest
//!    window that agrees with those of narrower windows. Twice, as the first courses pass through
//!    beads that have not moved yet.
//! 3. Each observation moves onto the course of its bead, as far as errors of views exceed its own
//!    noise.
//! 4. The distances of the views from the first courses tell how far a view is off *after averaging
//!    along the window*. This, or the error of a typical view if that is larger, over the views
//!    that share a course, is the course's own error. Views that were shifted agree better
//!    afterwards, but their mean is as far from the truth as before.
//!
//! **Source.** Not in the dissertation, whose averages move two curves at a time (5.5.2).

use super::super::tuning::settle::*;
use super::super::window::left_of;
use super::align::align;
use super::bead::beads;
use super::common_course::{OnCourse, ViewErrors, averaged_view_error, on_widest_courses};
use super::observations::{Observations, median};
use super::reach::Reach;
use super::scale::Scale;
use super::view_error::ViewError;

/// Whether the error of a view, a standard deviation, asks for views to be moved.
pub(super) fn stands_out(error: f64, noise: f64, scale: &Scale) -> bool {
    error >= LEAST_FOOTPRINTS * scale.spacing && error >= LEAST_NOISE_RATIO * noise
}

/// Moves the observations of views with these errors. `noise` is the median of their own one.
pub(super) fn settle(
    observations: &mut Observations,
    scale: &Scale,
    of_view: &ViewError,
    noise: f64,
) {
    let variances = observations.all.iter().map(|o| o.view_variance(of_view));
    let typical = median(variances).sqrt().max(noise);
    let reach = Reach::new(*of_view, typical, scale);
    let mut averaged = scale.steps().align.then(|| align(observations, &reach));
    let (mut beads, bead_of) = beads(observations, &reach);
    let (mut courses, mut errors) = (Vec::new(), ViewErrors::default());
    for _ in 0..ROUNDS {
        courses = on_widest_courses(&beads, observations.sources.len(), &reach, &mut errors);
        averaged = averaged.or_else(|| Some(averaged_view_error(&courses)));
        beads = courses.iter().map(|course| course.bead).collect();
    }
    for (o, &k) in observations.all.iter_mut().zip(&bead_of) {
        let OnCourse { bead, views, .. } = &courses[k as usize];
        o.course_error = averaged.unwrap_or(typical).max(typical) / views.sqrt();
        let variance = o.view_variance(of_view);
        let trust = variance / (variance + o.sigma * o.sigma);
        let normal = left_of(&bead.tangent);
        o.position += normal * (trust * normal.dot(&(bead.position - o.position)));
        let turned = o.tangent + (bead.tangent - o.tangent) * trust;
        o.tangent = turned.try_normalize(0.0).unwrap_or(o.tangent);
    }
}
