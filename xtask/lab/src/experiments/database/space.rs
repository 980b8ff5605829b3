//! Inside, outside or unknown: the answers for many points whose truth is known.

use super::super::lab::Lab;
use super::super::trial;
use super::{Surrounded, footprint, surround};
use crate::failure::Failure;
use crate::table::{cells, digits, say};
use transect_device::{Pixel, View};
use transect_geometry::{Point3, Vector3};
use transect_model::{Location, ModelIndex};
use transect_scene::Scene;
use transect_workflow::simulation::{PreparedScene, SensorPlan};

const POINTS: usize = 100_000;

/// Millimetres between planes of the solids.
const INTERVAL: f64 = 4.0;

const SOLIDS: &str = "
{ shape = 'ball', radius = 25, at = [60, 45, 20] },
{ shape = 'torus', radius = 30, tube = 12, at = [-55, 50, -10], rotate = { axis = [1, 0, 0], degrees = 50 } },
{ shape = 'box', size = [50, 40, 60], at = [-50, -55, 0], rotate = { axis = [1, 1, 1], degrees = 40 } },
{ shape = 'cylinder', radius = 20, height = 70, at = [55, -50, -15], rotate = { axis = [0, 1, 0], degrees = 25 } },
";

/// The number of answers of each kind.
#[derive(Default)]
struct Tally {
    points: usize,
    inside: usize,
    unknown: usize,
    wrong: usize,
    wrong_beyond_sampling: usize,
}

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    say(&format!("Inside or outside, {POINTS} points\n"));
    // Where two samples see a surface under 60°, they lie two footprints apart.
    let sampling = 2.0 * footprint();
    let tallies = [solids(sampling)?, room(ROOM_SAMPLING)?];
    let lines = [
        row("four solids, seen from all sides", &tallies[0], sampling, "mm"),
        row("free space of the room", &tallies[1], ROOM_SAMPLING, "m"),
    ];
    let heads =
        "points in | points | in solid, % | unknown, % | wrong | sampling error | wrong beyond it";
    lab.table("space", heads, lines)?;
    let beyond: usize = tallies.iter().map(|tally| tally.wrong_beyond_sampling).sum();
    if beyond == 0 {
        Ok(())
    } else {
        Err(Failure::because("answers are wrong beyond the sampling error"))
    }
}

fn row(name: &str, tally: &Tally, sampling: f64, unit: &str) -> Vec<String> {
    let percent = |part: usize| digits(100.0 * part as f64 / tally.points.max(1) as f64);
    let Tally { points, inside, unknown, wrong, wrong_beyond_sampling } = tally;
    let (inside, unknown, sampling) = (percent(*inside), percent(*unknown), digits(sampling));
    cells(&format!(
        "{name} | {points} | {inside} | {unknown} | {wrong} | {sampling} {unit} | \
         {wrong_beyond_sampling}"
    ))
}

/// Points in a box around solids that were seen from everywhere.
fn solids(sampling: f64) -> Result<Tally, Failure> {
    let Surrounded { scene, views } = surround(SOLIDS)?;
    // No higher than the lowest of the solids: beyond the planes every answer is unknown.
    let sides = Vector3::new(220.0, 220.0, 80.0);
    let at = |i| (spread(i) - Vector3::repeat(0.5)).component_mul(&sides);
    let points = (0..POINTS).map(|i| Point3::from(at(i)));
    tally(&scene, &views, INTERVAL, points, sampling)
}

/// Distance between samples in the room, in metres: its scanners have 400 pixels over their field,
/// and walls are up to 4 m away.
const ROOM_SAMPLING: f64 = 0.03;

/// Points on rays of the room's scanners, before the surface: certainly free space.
fn room(sampling: f64) -> Result<Tally, Failure> {
    let scene = trial::bundled("room")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let interval = scene.description.planes.interval();
    let points: Vec<Point3> = (0..POINTS).filter_map(|i| on_a_ray(&views, i)).collect();
    tally(&scene, &views, interval, points.into_iter(), sampling)
}

fn on_a_ray(views: &[View], i: usize) -> Option<Point3> {
    let (view, at) = (views.get(i % views.len())?, spread(i));
    let size = view.image().size();
    let pixel = Pixel::new((at.x * size.rows as f64) as usize, (at.y * size.cols as f64) as usize);
    let (seen, ray) = (view.point_in_sensor(pixel)?, view.frame().ray(pixel)?);
    // Not the last twentieth of the ray: noise moves its end.
    Some(view.world_from_sensor() * (ray.start + (seen - ray.start) * (0.95 * at.z)))
}

fn tally(
    scene: &PreparedScene,
    views: &[View],
    interval: f64,
    points: impl Iterator<Item = Point3>,
    sampling: f64,
) -> Result<Tally, Failure> {
    let planes = &scene.description.planes;
    let planes = transect_geometry::PlaneFamily::new(planes.guide(), planes.offset(), interval)?;
    let model = trial::model(views, scene.description.unit, planes)?;
    let (index, mut tally) = (ModelIndex::new(&model), Tally::default());
    for p in points {
        let inside = scene.scene.contains(&p);
        tally.points += 1;
        tally.inside += usize::from(inside);
        match index.locate(&p).location {
            Location::Unknown => tally.unknown += 1,
            Location::Inside if inside => (),
            Location::Outside if !inside => (),
            _ => {
                tally.wrong += 1;
                tally.wrong_beyond_sampling +=
                    usize::from(!near_surface(&scene.scene, &p, sampling));
            }
        }
    }
    Ok(tally)
}

/// Whether the surface comes within a distance of a point: whether it lies between the point and
/// one of 26 points at that distance.
fn near_surface(scene: &Scene, p: &Point3, distance: f64) -> bool {
    let inside = scene.contains(p);
    let steps = [-1.0, 0.0, 1.0];
    let directions = steps.iter().flat_map(|x| steps.iter().map(move |y| (*x, *y)));
    let mut directions =
        directions.flat_map(|(x, y)| steps.iter().map(move |z| Vector3::new(x, y, *z)));
    directions.any(|d| {
        let far = d.try_normalize(0.5).map(|d| scene.contains(&(p + d * distance)));
        far.is_some_and(|there| there != inside)
    })
}

/// Numbers from 0 to 1 in three directions, evenly spread (R3 sequence, a generalised golden
/// ratio).
fn spread(i: usize) -> Vector3 {
    let part = |step: f64| (0.5 + i as f64 * step).fract();
    Vector3::new(part(0.819_172_513_4), part(0.671_043_606_7), part(0.549_700_477_9))
}
