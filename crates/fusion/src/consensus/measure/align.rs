//! Each view is shifted and turned within the plane, so that its curves lie on those of all views.
//!
//! **Problem.** A wrong pose moves all curves of a view together. An average of the curves at one
//! place leaves the view's corners and the surface that it alone measured where they are.
//!
//! **Idea.** Two shifts and a turn of each view bring its beads onto the common courses, by least
//! squares. Poses are as wrong as views differ, which is the prior (ridge regression).
//! Neighbouring windows share errors that are no motion, such as a camera's distortion; several of
//! them therefore count as one observation. Without both, the views would follow such errors far
//! from the truth.
//!
//! **Not for** the views' heights over the plane and their tilts, which the plane's curves do not
//! show. Poses themselves stay as they are: every plane has motions of its own.
//!
//! **Source.** Not in the dissertation. Point-to-line registration of all views at once follows
//! Bergevin et al. (1996).

use super::super::tuning::settle::*;
use super::super::window::left_of;
use super::bead::{Bead, beads, joined};
use super::common_course::{averaged_view_error, on_common_courses};
use super::observations::Observations;
use super::reach::Reach;
use nalgebra::{Matrix3, Vector3};
use transect_geometry::{Point2, Vector2};

/// Moves each view's observations. Returns the standard deviation of the error of a typical view as
/// the courses show it before any view moves, averaged along them.
pub(super) fn align(observations: &mut Observations, reach: &Reach) -> f64 {
    let error = reach.typical;
    let (given, _) = beads(observations, reach);
    let given: Vec<Bead> = joined(&given, ALIGN_BEADS).into_iter().map(|(_, bead)| bead).collect();
    let mut motions = vec![Motion::default(); observations.sources.len()];
    given.iter().for_each(|bead| motions[bead.view as usize].add_to_centre(bead));
    given.iter().for_each(|bead| motions[bead.view as usize].add_to_radius(bead));
    let mut given_error = None;
    for _ in 0..ALIGN_ROUNDS {
        let mut moved = given.clone();
        for bead in &mut moved {
            motions[bead.view as usize].apply(&mut bead.position, &mut bead.tangent);
        }
        let courses = on_common_courses(&moved, motions.len(), reach);
        given_error = given_error.or_else(|| Some(averaged_view_error(&courses)));
        let mut equations = vec![Equations::default(); motions.len()];
        for (bead, course) in moved.iter().zip(&courses).filter(|(_, course)| course.tells_error())
        {
            let view = bead.view as usize;
            let off = course.off / (error * bead.variance.sqrt());
            equations[view].add(bead, off, &motions[view], reach.along);
        }
        motions.iter_mut().zip(&equations).for_each(|(motion, e)| motion.improve(e, error));
    }
    for o in &mut observations.all {
        motions[o.view as usize].apply(&mut o.position, &mut o.tangent);
    }
    given_error.unwrap_or(error)
}

/// A small rigid motion of a view within the plane.
#[derive(Debug, Clone, Copy, Default)]
struct Motion {
    /// Mean place of the view's beads, about which it turns.
    centre: Point2,
    /// Mean squared distance of the beads from the centre.
    squared_radius: f64,
    length: f64,
    shift: Vector2,
    turn: f64,
}

impl Motion {
    fn add_to_centre(&mut self, bead: &Bead) {
        self.length += bead.length;
        if self.length > 0.0 {
            self.centre += (bead.position - self.centre) * (bead.length / self.length);
        }
    }

    fn add_to_radius(&mut self, bead: &Bead) {
        if self.length > 0.0 {
            let share = bead.length / self.length;
            self.squared_radius += share * (bead.position - self.centre).norm_squared();
        }
    }

    fn apply(&self, position: &mut Point2, tangent: &mut Vector2) {
        let (sin, cos) = self.turn.sin_cos();
        let turned = |v: &Vector2| v * cos + left_of(v) * sin;
        *position = self.centre + turned(&(*position - self.centre)) + self.shift;
        *tangent = turned(tangent);
    }

    /// The motion that fits the equations, while the whole of it stays as likely as it can.
    fn improve(&mut self, equations: &Equations, error: f64) {
        let unit = Vector3::new(1.0, 1.0, self.squared_radius.max(f64::MIN_POSITIVE));
        let prior = Matrix3::from_diagonal(&unit) / (error * error);
        let so_far = Vector3::new(self.shift.x, self.shift.y, self.turn);
        let wanted = equations.vector / error - prior * so_far;
        let matrix = equations.matrix / (error * error) + prior;
        if let Some(step) = matrix.cholesky().map(|matrix| matrix.solve(&wanted)) {
            self.shift += Vector2::new(step.x, step.y);
            self.turn += step.z;
        }
    }
}

/// Normal equations of a view's motion.
#[derive(Debug, Clone, Copy, Default)]
struct Equations {
    matrix: Matrix3<f64>,
    vector: Vector3<f64>,
}

impl Equations {
    /// Adds a bead that is `off` errors of its view away from its course.
    fn add(&mut self, bead: &Bead, off: f64, motion: &Motion, half_length: f64) {
        let normal = left_of(&bead.tangent);
        let lever = bead.position - motion.centre - motion.shift;
        let change = Vector3::new(normal.x, normal.y, normal.dot(&left_of(&lever)));
        // Tukey's biweight: a bead far from its course may be of another surface.
        let trust = (1.0 - (off / ALIGN_CUT).powi(2)).max(0.0).powi(2);
        let count = trust * bead.length / (half_length * REACHES_PER_OBSERVATION);
        self.matrix += change * change.transpose() * (count / bead.variance);
        self.vector -= change * (off * count / bead.variance.sqrt());
    }
}
