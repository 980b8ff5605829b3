//! The cost of each error of a depth camera: the kitchen with all errors, and without one of them.
//! The gain of refined poses and corrected images.

use super::lab::Lab;
use super::trial::{self, Public};
use crate::failure::Failure;
use crate::table::{self, say};
use std::collections::BTreeMap;
use std::path::Path;
use transect::evaluate::{Accuracy, EvaluateOptions, evaluate};
use transect_device::View;
use transect_geometry::{Curve, LengthUnit, PlaneIndex};
use transect_model::Model;
use transect_register::RefineOptions;
use transect_scene::{Description, Noise, Station};
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};

/// Removes an error.
type Without = fn(&mut Noise);

/// The errors by the keys of a scene file.
const ERRORS: [(&str, Without); 8] = [
    ("all", |_| ()),
    ("without `correlation`", |n| n.correlation = 0.0),
    ("without `distortion`", |n| n.depth_camera.distortion = 0.0),
    ("without `pose`", |n| n.pose = Noise::NONE.pose),
    ("without `disparity_step`", |n| n.depth_camera.disparity_step = 0.0),
    ("without `shuffle`", |n| n.depth_camera.shuffle = 0.0),
    ("without `mixed`", |n| n.mixed = 0.0),
    ("`quantum` and `dropout` alone", |n| {
        *n = Noise { quantum: n.quantum, dropout: n.dropout, seed: n.seed, ..Noise::NONE };
    }),
];

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let lines: Vec<_> = ERRORS.into_iter().map(line).collect::<Result<_, _>>()?;
    lab.table("table", "errors | median | 95 % | spread between views", lines)?;
    say("In mm: distances from the true sections, and the spread that the run measures.\n");
    let lines: Vec<_> = KITCHENS.into_iter().map(of_kitchen).collect::<Result<_, _>>()?;
    lab.table("corrected", "kitchen | as given | poses refined | images corrected, too", lines)?;
    say("Median and 95 % distance in mm, and the share of the visible truth that is found.\n");
    lab.table("halves", "red kitchen | median | 95 % | within 2 cm", of_halves(lab.scans()?)?)?;
    say("In mm: distances of the even frames' model from that of the odd frames, and back.");
    Ok(())
}

/// The model of the red kitchen's even frames against that of the odd ones.
fn of_halves(data: &Path) -> Result<Vec<Vec<String>>, Failure> {
    let Public { views, planes } = trial::red_kitchen(data)?;
    let refined = trial::at_refined_poses(&views)?;
    let corrected = trial::corrected(&views)?;
    let half =
        |views: &[View], first| views.iter().skip(first).step_by(2).cloned().collect::<Vec<View>>();
    let apart = [trial::corrected(&half(&views, 0))?, trial::corrected(&half(&views, 1))?];
    let together = |views: &[View]| [half(views, 0), half(views, 1)];
    let cases = [
        ("as given", together(&views)),
        ("poses refined", together(&refined)),
        ("images corrected, too", together(&corrected)),
        ("the same, each half by itself", apart),
    ];
    let options = EvaluateOptions::new(0.02);
    let line = |(name, halves): (&str, [Vec<View>; 2])| {
        let model = |views: &Vec<View>| trial::model(views, LengthUnit::Metre, planes.clone());
        let [even, odd] = [model(&halves[0])?, model(&halves[1])?].map(|model| curves(&model));
        let accuracies =
            [evaluate(&planes, &even, &odd, &options)?, evaluate(&planes, &odd, &even, &options)?];
        let mean = |f: fn(&Accuracy) -> Option<f64>| {
            accuracies.iter().map(|a| f(a).unwrap_or(f64::INFINITY)).sum::<f64>() / 2.0
        };
        let within = format!("{:.1} %", 100.0 * (1.0 - mean(|a| a.off)));
        let [median, p95] = [mean(|a| a.median), mean(|a| a.p95)].map(|m| three_digits(1e3 * m));
        Ok(table::line(name, [median, p95, within]))
    };
    cases.into_iter().map(line).collect()
}

fn curves(model: &Model) -> BTreeMap<PlaneIndex, Vec<Curve>> {
    model.sections().map(|(k, section)| (k, section.curves().cloned().collect())).collect()
}

/// Kitchens that refinement is measured with: the seed of the noise, or the scene's own, and how
/// often frames are taken between those of the scene.
const KITCHENS: [(Option<u64>, u32); 6] =
    [(None, 0), (Some(2027), 0), (Some(2028), 0), (None, 1), (Some(2027), 1), (Some(2028), 1)];

/// The kitchen as given, at refined poses, and with corrected images, too.
fn of_kitchen((seed, denser): (Option<u64>, u32)) -> Result<Vec<String>, Failure> {
    let description = kitchen(seed, denser)?;
    let name = seed.map_or("its own seed".to_owned(), |seed| format!("seed {seed}"));
    let name = format!("{name}, {} frames", description.stations.len());
    let scene = PreparedScene::new(description)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let refined = trial::at_refined_poses(&views)?;
    let mut cells = vec![name];
    for (views, options) in
        [(&views, None), (&refined, None), (&views, Some(RefineOptions::default()))]
    {
        let mut setup = trial::setup(&scene);
        setup.refine_poses = options;
        let (_, found) = trial::scored(&scene, views, &setup)?;
        let length =
            |metres: Option<f64>| metres.map_or("∞".to_owned(), |m| three_digits(1e3 * m));
        let complete = 100.0 * found.completeness.unwrap_or(0.0);
        cells.push(format!("{} / {}, {complete:.1} %", length(found.median), length(found.p95)));
    }
    Ok(cells)
}

/// The kitchen with a seed of its noise, or its own. `denser` tells how often frames are taken
/// between those of the scene.
pub fn kitchen(seed: Option<u64>, denser: u32) -> Result<Description, Failure> {
    let mut description = describe("kitchen".as_ref())?;
    description.noise.seed = seed.unwrap_or(description.noise.seed);
    (0..denser).for_each(|_| description.stations = with_frames_between(&description.stations));
    Ok(description)
}

/// The stations, and one half way between each and the next.
fn with_frames_between(stations: &[Station]) -> Vec<Station> {
    let half_way = |pair: &[Station]| {
        let mut between = pair[0].clone();
        // Registration takes the frames in the order of their names, as they follow each other.
        between.name = format!("{}, half way", pair[0].name);
        let next = &pair[1].world_from_sensor;
        between.world_from_sensor = pair[0].world_from_sensor.lerp_slerp(next, 0.5);
        between
    };
    let between = stations.windows(2).map(|pair| [pair[0].clone(), half_way(pair)]);
    between.flatten().chain(stations.last().cloned()).collect()
}

fn line((name, without): (&str, Without)) -> Result<Vec<String>, Failure> {
    let mut description = describe("kitchen".as_ref())?;
    without(&mut description.noise);
    let scene = PreparedScene::new(description)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let (run, accuracy) = trial::scored(&scene, &views, &trial::setup(&scene))?;
    let figure = |metres: Option<f64>| metres.map_or("none".to_owned(), |m| three_digits(1e3 * m));
    let spread = Some(run.report.fusion.spread);
    let figures = [accuracy.median, accuracy.p95, spread].map(figure);
    Ok(table::line(name, figures))
}

fn three_digits(value: f64) -> String {
    let decimals = (2 - value.abs().log10().floor() as i32).clamp(0, 9) as usize;
    format!("{value:.decimals$}")
}
