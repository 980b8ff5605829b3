//! One view before and after the noise step: every view of a bundled scene, each by itself.

use crate::failure::Failure;
use crate::statistics::quantile;
use crate::table::{digits, print_grid, say};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;
use transect_device::View;
use transect_geometry::{Curve, CurveUnit, Node, PlaneIndex};
use transect_partial::one_pass::OnePassOptions;
use transect_partial::{Method, PartialModel, PlaneCurves, partial_model};
use transect_scene::{Noise, merge_overlaps, sections};
use transect_workflow::simulation::{PreparedScene, SensorPlan, describe};

/// Range noise, as shares of the scene's size.
const NOISE: [f64; 2] = [0.001, 0.005];

const SCENES: [&str; 4] = ["machined_part", "room", "face_mask", "thin_sheet"];

/// What is said of the curves of all views of a scene.
struct Score {
    median: f64,
    p95: f64,
    pieces: usize,
    /// Diameter of the smoothing window, at the median of the views.
    window: f64,
}

/// Prints the table.
pub fn run() -> Result<(), Failure> {
    let mut lines = Vec::new();
    for name in SCENES {
        for share in NOISE {
            lines.push(line(name, share)?);
        }
    }
    say("\nOne view before and after smoothing:\n");
    let heads = [
        "scene", "noise", "median", "smoothed", "gain", "p95", "smoothed", "gain", "pieces",
        "smoothed", "window",
    ];
    print_grid(&heads, &lines);
    say(
        "\nDistances of the views' nodes from the true sections, in thousandths of the scene's size; window in pixels.",
    );
    Ok(())
}

fn line(name: &str, share: f64) -> Result<Vec<String>, Failure> {
    let mut description = describe(Path::new(name))?;
    let size = PreparedScene::new(description.clone())?.bounds.size();
    description.noise = Noise { sigma: share * size, seed: 11, ..Noise::NONE };
    let stage = PreparedScene::new(description)?;
    let views = stage.simulate(&SensorPlan::OWN)?.views;
    let cut = sections(&stage.truth, &stage.description.planes)?;
    let truth = cut.into_iter().map(|(k, curves)| (k, merge_overlaps(curves))).collect();
    let before = score(&stage, &views, &truth, false)?;
    let after = score(&stage, &views, &truth, true)?;
    let pair = |before: f64, after: f64| {
        let shares = [before, after].map(|length| digits(1e3 * length / size));
        shares.into_iter().chain([format!("{:.2}", before / after)])
    };
    let mut line = vec![name.to_owned(), format!("{:.1} %", 100.0 * share)];
    line.extend(pair(before.median, after.median));
    line.extend(pair(before.p95, after.p95));
    line.extend([before.pieces, after.pieces].map(|count| count.to_string()));
    line.push(format!("{:.1}", after.window));
    Ok(line)
}

type Truth = BTreeMap<PlaneIndex, Vec<Curve>>;

fn score(
    stage: &PreparedScene,
    views: &[View],
    truth: &Truth,
    smooth: bool,
) -> Result<Score, Failure> {
    let method = Method::OnePass({
        let mut options = OnePassOptions::default();
        options.smooth = smooth;
        options
    });
    let model = |view| partial_model(view, &stage.description.planes, &method);
    let models: Vec<PartialModel> = views.par_iter().map(model).collect::<Result<_, _>>()?;
    let planes: Vec<_> = models.iter().flat_map(|m| &m.planes).collect();
    let errors = planes.par_iter().flat_map_iter(|found| errors(found, truth)).collect::<Vec<_>>();
    Ok(Score {
        median: quantile(errors.clone(), 0.5),
        p95: quantile(errors, 0.95),
        pieces: planes.iter().map(|p| p.curves.len()).sum(),
        window: quantile(models.iter().map(|m| m.counts.window).collect(), 0.5),
    })
}

/// Distances of the nodes on one plane from the true curves there.
fn errors(found: &PlaneCurves, truth: &Truth) -> Vec<f64> {
    let truth = truth.get(&found.plane).map_or(&[][..], Vec::as_slice);
    let units: Vec<CurveUnit> = truth.iter().flat_map(Curve::units).collect();
    let nodes = found.curves.iter().flat_map(|c| c.curve.nodes());
    let nearest = |node: &Node| {
        let distances = units.iter().map(|unit| unit.distance(&node.position));
        distances.fold(f64::INFINITY, f64::min)
    };
    nodes.map(nearest).collect()
}
