//! What one wrong view costs among right ones, as given and refined.
//!
//! One view after the other is turned about its own vertical axis. All other views are at their
//! exact poses, so refined sections should err as those of exact poses do.

use super::errors;
use crate::experiments::{lab::Lab, trial};
use crate::failure::Failure;
use crate::table::{digits, line, say};
use nalgebra::{Isometry3, Vector3};
use transect_device::View;
use transect_workflow::simulation::SensorPlan;

/// Scenes, and the number of views of each; the scene's own number if `None`.
const SCANS: [(&str, Option<usize>); 4] =
    [("room", Some(12)), ("face_mask", None), ("machined_part", None), ("tunnel", None)];

/// Most views of a scan that are turned, evenly over its views. No unit. Chosen by hand: each is
/// two reconstructions. Doubled, the table takes twice the time.
const TURNED: usize = 4;

/// The turns, in degrees.
const DEGREES: [f64; 3] = [3.0, 10.0, 30.0];

/// Prints the table.
pub fn table(lab: &Lab) -> Result<(), Failure> {
    let mut lines = Vec::new();
    for (name, views) in SCANS {
        let scene = trial::bundled(name)?;
        let views = scene.simulate(&SensorPlan { views, ..SensorPlan::OWN })?.views;
        let exact = trial::errors(&scene, &views, &trial::setup(&scene))?;
        let mut cells = vec![both(exact)];
        let chosen = || (0..views.len()).step_by(views.len().div_ceil(TURNED));
        for degrees in DEGREES {
            let mut worst = [[0.0_f64; 2]; 2];
            for view in chosen() {
                let turned = turned(&views, view, degrees)?;
                for (worst, error) in worst.iter_mut().zip(errors(&scene, &turned)?) {
                    *worst = std::array::from_fn(|k| worst[k].max(error[k]));
                }
            }
            if degrees == DEGREES[0] {
                cells.push(both(worst[0]));
            }
            cells.push(both(worst[1]));
        }
        lines.push(line(format!("{name}, {} views", views.len()), cells));
    }
    let heads = "scan | exact poses | one view 3° off | refined | 10°, refined | 30°, refined";
    lab.table("one-wrong", heads, lines)?;
    say(
        "Median and p95 of the distances from the true sections, of the worst of the turned views.",
    );
    Ok(())
}

fn both([median, p95]: [f64; 2]) -> String {
    format!("{} / {}", digits(median), digits(p95))
}

fn turned(views: &[View], view: usize, degrees: f64) -> Result<Vec<View>, Failure> {
    let turn = Isometry3::rotation(Vector3::y() * degrees.to_radians());
    let mut views = views.to_vec();
    views[view] = views[view].with_pose(views[view].world_from_sensor() * turn)?;
    Ok(views)
}
