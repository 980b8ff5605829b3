//! A room with people in it: what is left of them where other views looked through.

use super::lab::Lab;
use super::trial::{scored, setup};
use crate::failure::Failure;
use crate::table::{digits, say};
use transect_scene::{BUNDLED_ROOM, Description};
use transect_workflow::simulation::{PreparedScene, SensorPlan};

/// Where scanners stand in the bundled room, and a person while each of them measures; in metres.
const STATIONS: [[[f64; 2]; 2]; 6] = [
    [[0.8, 0.8], [2.2, 0.9]],
    [[5.2, 0.8], [4.2, 1.6]],
    [[5.2, 4.2], [5.1, 2.9]],
    [[0.8, 4.2], [1.9, 3.6]],
    [[1.2, 2.4], [1.2, 1.2]],
    [[4.0, 2.9], [3.9, 4.3]],
];

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let mut lines = Vec::new();
    let cases = [("nobody", false, true), ("people", true, true), ("people, kept", true, false)];
    for (name, people, free_space) in cases {
        let scene = room(people)?;
        let views = scene.simulate(&SensorPlan::OWN)?.views;
        let mut setup = setup(&scene);
        setup.free_space = free_space;
        let (result, accuracy) = scored(&scene, &views, &setup)?;
        let millimetres = |error: Option<f64>| error.map(|e| digits(1e3 * e)).unwrap_or_default();
        lines.push(vec![
            name.to_owned(),
            millimetres(accuracy.median),
            millimetres(accuracy.p95),
            accuracy.off.map(|share| digits(100.0 * share)).unwrap_or_default(),
            accuracy.completeness.map(|share| digits(100.0 * share)).unwrap_or_default(),
            result.report.fusion.seen_through.to_string(),
        ]);
    }
    let heads = "room with | median, mm | 95 % below, mm | off the truth, % | complete, % | nodes \
                 left out";
    lab.table("visitors", heads, lines)?;
    say("Six scanners that turn around, each with a person in another place.");
    Ok(())
}

/// The bundled room with other stations, and perhaps with people.
fn room(people: bool) -> Result<PreparedScene, Failure> {
    let solids = BUNDLED_ROOM.split("[[station]]").next().unwrap_or_default();
    let person = |(station, [_, [x, y]]): (usize, &[[f64; 2]; 2])| {
        format!(
            "\n[[solid]]\nname = \"person\"\nshape = \"cylinder\"\nradius = 0.22\nheight = 1.7\n\
             at = [{x}, {y}, 0.85]\nstations = [{station}]\n"
        )
    };
    let station = |[[x, y], _]: &[[f64; 2]; 2]| {
        format!(
            "\n[[station]]\nsensor = \"spherical\"\nrows = 360\ncols = 1080\ntheta = [180, -180]\n\
             phi = [60, -60]\nat = [{x}, {y}, 1.4]\nheading = 0\n"
        )
    };
    let mut text: String =
        std::iter::once(solids.to_owned()).chain(STATIONS.iter().map(station)).collect();
    if people {
        text.extend(STATIONS.iter().enumerate().map(person));
    }
    let described = Description::parse(&text);
    Ok(PreparedScene::new(described.map_err(|e| Failure::because(e.to_string()))?)?)
}
