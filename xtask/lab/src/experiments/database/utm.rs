//! The bundled room, and the same room at UTM coordinates: the same model, shifted.

use super::super::trial;
use crate::failure::Failure;
use crate::table::{Row, digits, print, say};
use transect_device::View;
use transect_geometry::{Isometry3, PlaneFamily, Vector3};
use transect_model::Model;
use transect_workflow::simulation::SensorPlan;

/// Easting, northing and height of a place, in metres.
const FAR: Vector3 = Vector3::new(500_000.0, 5_400_000.0, 300.0);
/// The largest difference that is accepted, in metres.
const LIMIT: f64 = 1e-6;

/// Runs the experiment.
pub fn run() -> Result<(), Failure> {
    say(
        "The room at UTM coordinates (500 000, 5 400 000, 300) m, against the room at home, shifted\n",
    );
    let scene = trial::bundled("room")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let far: Result<Vec<View>, _> = views.iter().map(moved).collect();
    let (near_planes, unit) = (scene.description.planes.clone(), scene.description.unit);
    let up = near_planes.guide().direction(0.0).dot(&FAR);
    let far_planes =
        PlaneFamily::new(near_planes.guide(), near_planes.offset() + up, near_planes.interval())?;
    let (near, far) =
        (trial::model(&views, unit, near_planes)?, trial::model(&far?, unit, far_planes)?);
    let largest = largest_difference(&near, &far)?;
    print(&[
        Row::plain("planes", near.sections().len()),
        Row::plain("curves", near.curve_count()),
        Row::plain("nodes compared", near.node_count()),
        Row::new("largest difference", format!("{largest:.2e}"), unit.symbol()),
        Row::new("accepted", digits(LIMIT), unit.symbol()),
    ]);
    say("");
    if largest <= LIMIT { Ok(()) } else { Err(Failure::because("the models differ by more")) }
}

fn moved(view: &View) -> Result<View, transect_device::ViewError> {
    view.with_pose(Isometry3::translation(FAR.x, FAR.y, FAR.z) * view.world_from_sensor())
}

fn largest_difference(near: &Model, far: &Model) -> Result<f64, Failure> {
    let other = || Failure::because("the models have other planes, curves or nodes");
    let mut largest: f64 = 0.0;
    if near.sections().len() != far.sections().len() {
        return Err(other());
    }
    for ((k, a), (l, b)) in near.sections().zip(far.sections()) {
        let shapes = |s: &transect_model::Section| -> Vec<(bool, usize)> {
            s.curves().map(|c| (c.is_closed(), c.nodes().len())).collect()
        };
        if k != l || shapes(a) != shapes(b) {
            return Err(other());
        }
        let (here, there) = (near.planes().frame(k), far.planes().frame(l));
        let nodes = a.curves().flat_map(|c| c.nodes()).zip(b.curves().flat_map(|c| c.nodes()));
        for (p, q) in nodes {
            let p = here.world_from_plane(&p.position) + FAR;
            largest = largest.max((p - there.world_from_plane(&q.position)).norm());
        }
    }
    Ok(largest)
}
