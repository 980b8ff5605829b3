//! Where nodes are wrong, and how well a model knows the errors of its nodes.
//!
//! Each node's distance from the reference is held against the standard deviation that the model
//! states for it. The reference is the exact truth of a bundled scene, or the model of other
//! frames.

use super::lab::Lab;
use super::poses;
use super::trial::{self, Public};
use crate::failure::Failure;
use crate::statistics::median;
use crate::table::line;
use std::collections::BTreeMap;
use transect::nalgebra::{Matrix3x6, Matrix6, Vector6};
use transect::{PoseReport, Posed, Unwatched, reconstruct};
use transect_device::{Isometry3, View};
use transect_geometry::{Curve, LengthUnit, PlaneFamily, PlaneIndex};
use transect_model::Model;
use transect_register::{CoarseView, RefineOptions};
use transect_scene::sections;
use transect_workflow::simulation::{PlacedInstrument, PreparedScene, SensorPlan, SimulatedScan};

/// A node farther from the reference than this is wrong, in metres, for depth cameras in a room.
/// Chosen by hand: four times their usual error. Doubled, only spurious surface is wrong.
const WRONG: f64 = 0.02;

/// Curves shorter than this are short, in metres.
const SHORT: f64 = 0.4;

/// Nodes nearer to the end of an open curve than this, along the curve, are near it, in metres.
const NEAR_END: f64 = 0.05;

/// A node that some view measured.
struct Judged {
    /// Length of the curve that it stands for.
    length: f64,
    /// Distance from the nearest curve of the reference.
    off: f64,
    /// The standard deviation that the model states.
    sigma: f64,
    /// How many views measured it.
    views: u32,
    curve_length: f64,
    to_end: f64,
}

/// Whether a node is in a class.
type Class = fn(&Judged) -> bool;

/// The classes of nodes whose errors are told.
const CLASSES: [(&str, Class); 6] = [
    ("all", |_| true),
    ("of three views or more", |n| n.views > 2),
    ("of two views", |n| n.views == 2),
    ("of one view", |n| n.views == 1),
    ("of one view, in curves shorter than 0.4 m", |n| n.views == 1 && n.curve_length < SHORT),
    ("of one view, within 5 cm of an end", |n| n.views == 1 && n.to_end < NEAR_END),
];

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let Public { views, planes } = trial::red_kitchen(lab.scans()?)?;
    let kitchen = of_scene("kitchen", as_given)?;
    let mut ratios = vec![
        ratio("`room`, against the truth", &of_scene("room", as_given)?, f64::INFINITY),
        ratio("`kitchen`, against the truth", &kitchen, f64::INFINITY),
        ratio(
            "`kitchen`, registered, common motion out, against the truth",
            &refined("kitchen", as_given)?,
            f64::INFINITY,
        ),
    ];
    ratios.extend(of_part()?);
    let half = views.len() / 2;
    let of_half = |is_first: &dyn Fn(usize) -> bool| {
        let part = |first: bool| {
            let chosen = views.iter().enumerate().filter(|(k, _)| is_first(*k) == first);
            chosen.map(|(_, view)| view.clone()).collect()
        };
        halves([part(true), part(false)], &planes)
    };
    let (even, first) = (of_half(&|k| k % 2 == 0)?, of_half(&|k| k < half)?);
    for (name, nodes) in [("first half against the second", &first), ("even against odd", &even)] {
        for limit in [0.02, 0.06] {
            let name = format!("red kitchen, frames: {name}, within {:.0} cm", 100.0 * limit);
            // Both models err.
            let nodes: Vec<_> =
                nodes.iter().map(|n| Judged { sigma: n.sigma * 2_f64.sqrt(), ..*n }).collect();
            ratios.push(ratio(&name, &nodes, limit));
        }
    }
    lab.table("predicted", "set | nodes | predicted over observed", ratios)?;
    let sets = [kitchen, even];
    let of_class = |(name, is_in): &(&str, Class)| {
        let cells = sets.iter().map(|nodes| shares(nodes, *is_in));
        line(*name, cells)
    };
    let heads = "nodes | `kitchen`: share, wrong | red kitchen's halves: share, wrong";
    lab.table("wrong", heads, CLASSES.iter().map(of_class))
}

/// A line of the table: the predicted over the observed errors of the nodes nearer than a limit.
fn ratio(name: &str, nodes: &[Judged], limit: f64) -> Vec<String> {
    let near = nodes.iter().filter(|n| n.off < limit && n.sigma > 0.0);
    let off: Vec<f64> = near.map(|n| n.off / n.sigma).collect();
    // Half of normally distributed errors are below 0.6745 standard deviations.
    let ratio = 0.6745 / median(&off);
    vec![name.to_owned(), off.len().to_string(), format!("{ratio:.2}")]
}

/// The lines of the machined part: at true, wrong and registered poses.
fn of_part() -> Result<[Vec<String>; 3], Failure> {
    let line = |name: &str, nodes: &[Judged]| {
        ratio(&format!("`machined_part`, {name}against the truth"), nodes, f64::INFINITY)
    };
    Ok([
        line("", &of_scene("machined_part", as_given)?),
        line("poses wrong by 0.1° and 0.1 mm, ", &of_scene("machined_part", turned)?),
        line("these poses registered, common motion out, ", &refined("machined_part", turned)?),
    ])
}

/// The share of the length that a class has, and the share of that which is wrong.
fn shares(nodes: &[Judged], is_in: Class) -> String {
    let length = |is_counted: &dyn Fn(&Judged) -> bool| {
        nodes.iter().filter(|n| is_counted(n)).map(|n| n.length).sum::<f64>()
    };
    let (all, class) = (length(&|_| true), length(&is_in));
    let wrong = length(&|n| is_in(n) && n.off >= WRONG);
    format!("{:.1} %, {:.0} %", 100.0 * class / all, 100.0 * wrong / class)
}

/// What becomes of the views of a scene.
type Change = fn(&PreparedScene, Vec<View>) -> Result<Vec<View>, Failure>;

/// The views of a scene as they are.
fn as_given(_: &PreparedScene, views: Vec<View>) -> Result<Vec<View>, Failure> {
    Ok(views)
}

/// The views, each turned by 0.1° and shifted.
fn turned(scene: &PreparedScene, views: Vec<View>) -> Result<Vec<View>, Failure> {
    poses::moved(scene, &views, 0.1)
}

/// The nodes of a bundled scene's model against the truth.
fn of_scene(name: &str, change: Change) -> Result<Vec<Judged>, Failure> {
    let scene = trial::bundled(name)?;
    let views = change(&scene, scene.simulate(&SensorPlan::OWN)?.views)?;
    let model = trial::scene_model(&scene, &views)?;
    Ok(judged(&model, &sections(&scene.truth, &scene.description.planes)?))
}

/// The same with refined poses and corrected images, without the motion that all views share: no
/// view tells of it.
fn refined(name: &str, change: Change) -> Result<Vec<Judged>, Failure> {
    let scene = trial::bundled(name)?;
    let SimulatedScan { views, instruments, .. } = scene.simulate(&SensorPlan::OWN)?;
    let views = change(&scene, views)?;
    let setup = trial::setup(&scene);
    let poses = PoseReport::new(&views, Some(&RefineOptions::default()), setup.unit, &Unwatched)?;
    let mut posed = poses.posed(&views);
    let of_view = |(view, placed): (&Posed<'_, View>, &PlacedInstrument)| {
        [view.pose, placed.instrument.world_from_sensor]
    };
    let poses: Vec<_> = posed.iter().zip(&instruments).map(of_view).collect();
    let back = common_motion(&views, &poses)
        .ok_or_else(|| Failure::because("the views tell no common motion"))?;
    posed.iter_mut().for_each(|view| view.pose = back * view.pose);
    let result = reconstruct(&posed, &setup, &Unwatched)?;
    let truth = sections(&scene.truth, &scene.description.planes)?;
    Ok(judged(&result.model, &truth))
}

/// The small motion that takes the surfaces of views from their first poses to their second ones,
/// by least squares.
fn common_motion(views: &[View], poses: &[[Isometry3; 2]]) -> Option<Isometry3> {
    let (mut matrix, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for (view, poses) in views.iter().zip(poses) {
        for (_, patch) in CoarseView::new(view).patches() {
            let [from, to] = poses.map(|pose| pose * patch.point());
            let mut moves = Matrix3x6::identity();
            moves.fixed_view_mut::<3, 3>(0, 3).copy_from(&-from.coords.cross_matrix());
            matrix += moves.tr_mul(&moves);
            right += moves.tr_mul(&(to - from));
        }
    }
    let motion = matrix.cholesky()?.solve(&right);
    let [shift, turn] = [0, 3].map(|first| motion.fixed_rows::<3>(first).into_owned());
    Some(Isometry3::new(shift, turn))
}

/// The nodes of the red kitchen by some frames against the model of the others.
fn halves(views: [Vec<View>; 2], planes: &PlaneFamily) -> Result<Vec<Judged>, Failure> {
    let [model, other] = views.map(|views| trial::model(&views, LengthUnit::Metre, planes.clone()));
    let other = other?;
    let reference = other.sections().map(|(k, s)| (k, s.curves().cloned().collect())).collect();
    Ok(judged(&model?, &reference))
}

/// Every measured node of a model on the planes that the reference has.
fn judged(model: &Model, reference: &BTreeMap<PlaneIndex, Vec<Curve>>) -> Vec<Judged> {
    let of_plane = |(index, section): (PlaneIndex, &transect_model::Section)| {
        let Some(truth) = reference.get(&index).filter(|truth| !truth.is_empty()) else {
            return Vec::new();
        };
        section.curves().flat_map(|curve| of_curve(curve, truth)).collect()
    };
    model.sections().flat_map(of_plane).collect()
}

fn of_curve(curve: &Curve, truth: &[Curve]) -> Vec<Judged> {
    let steps: Vec<f64> = curve.units().map(|unit| unit.vector().norm()).collect();
    let curve_length: f64 = steps.iter().sum();
    let step = |k: Option<usize>| k.and_then(|k| steps.get(k)).copied().unwrap_or(0.0);
    let mut at = 0.0_f64;
    let mut judged = Vec::new();
    for (k, node) in curve.nodes().iter().enumerate() {
        let before = k.checked_sub(1).or(curve.is_closed().then(|| steps.len() - 1));
        if let Some(views) = node.views {
            let off = truth.iter().map(|c| c.foot(&node.position).distance);
            judged.push(Judged {
                length: 0.5 * (step(before) + step(Some(k))),
                off: off.fold(f64::INFINITY, f64::min),
                sigma: f64::from(node.sigma),
                views: views.get(),
                curve_length,
                to_end: if curve.is_closed() { f64::INFINITY } else { at.min(curve_length - at) },
            });
        }
        at += step(Some(k));
    }
    judged
}
