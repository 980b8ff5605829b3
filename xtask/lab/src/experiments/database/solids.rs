//! Areas and volumes of simulated solids against the exact ones, by interval.

use super::super::lab::Lab;
use super::super::trial;
use super::{STATIONS, surround};
use crate::failure::Failure;
use crate::table::{cells, digits, say};
use std::f64::consts::PI;
use transect_geometry::{LengthUnit, PlaneFamily};
use transect_model::{Model, Volume};

/// A solid with exact volume and section areas. Lengths in millimetres, heights from its middle.
struct Solid {
    name: &'static str,
    scene: &'static str,
    volume: f64,
    area: fn(f64) -> f64,
}

fn disc(radius_squared: f64) -> f64 {
    PI * radius_squared.max(0.0)
}

fn solids() -> [Solid; 4] {
    [
        Solid {
            name: "ball",
            scene: "shape = 'ball', radius = 60",
            volume: 4.0 / 3.0 * PI * 60_f64.powi(3),
            area: |z| disc(60.0 * 60.0 - z * z),
        },
        Solid {
            name: "torus",
            scene: "shape = 'torus', radius = 70, tube = 25",
            volume: 2.0 * PI * PI * 70.0 * 25.0 * 25.0,
            area: |z| 4.0 * PI * 70.0 * (25.0 * 25.0 - z * z).max(0.0).sqrt(),
        },
        Solid {
            name: "box",
            scene: "shape = 'box', size = [120, 80, 90], rotate = { axis = [0, 0, 1], degrees = 20 }",
            volume: 120.0 * 80.0 * 90.0,
            area: |z| if z.abs() <= 45.0 { 120.0 * 80.0 } else { 0.0 },
        },
        Solid {
            name: "cylinder",
            scene: "shape = 'cylinder', radius = 50, height = 100",
            volume: PI * 50.0 * 50.0 * 100.0,
            area: |z| if z.abs() <= 50.0 { PI * 50.0 * 50.0 } else { 0.0 },
        },
    ]
}

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    say(&format!("Areas and volumes of solids seen by {STATIONS} cameras, without noise\n"));
    let mut lines = Vec::new();
    for solid in solids() {
        let seen = surround(&format!("{{ at = [0, 0, 0], {} }}", solid.scene))?;
        for interval in [16.0, 8.0, 4.0, 2.0] {
            let guide = seen.scene.description.planes.guide();
            let mut models = Vec::new();
            for offset in OFFSETS {
                let planes = PlaneFamily::new(guide, offset * interval, interval)?;
                models.push(trial::model(&seen.views, LengthUnit::Millimetre, planes)?);
            }
            lines.push(line(&solid, interval, &models));
        }
    }
    let heads = "solid | interval, mm | open curves | area off, % | volume off, % | bound, %";
    lab.table("solids", heads, lines)?;
    say(
        "Area: sum of the differences from the exact areas over their sum. Volume: from the exact \
         one, the worst of four places of the planes.\nBound: the smallest bound of the models on \
         the volume's error, from the interval.\n",
    );
    Ok(())
}

/// Offsets of the planes, in intervals: off every solid's symmetry, and never in a face.
const OFFSETS: [f64; 4] = [0.13, 0.37, 0.61, 0.87];

fn line(solid: &Solid, interval: f64, models: &[Model]) -> Vec<String> {
    let (mut off, mut sum, mut open) = (0.0, 0.0, 0);
    for (model, (plane, section)) in models.iter().flat_map(|m| m.sections().map(move |s| (m, s))) {
        let exact = (solid.area)(model.planes().station(plane));
        off += (section.measures().solid.estimate - exact).abs();
        sum += exact;
        open += section.open_curve_count();
    }
    let volumes: Vec<Volume> = models.iter().map(|model| model.volume().solid).collect();
    let off_by = |v: &Volume| (v.bracket.estimate - solid.volume).abs();
    let worst = volumes.iter().map(off_by).fold(0.0, f64::max);
    let bound = volumes.iter().map(|v| v.interval_error).fold(f64::INFINITY, f64::min);
    let percents = [(off, sum), (worst, solid.volume), (bound, solid.volume)];
    let percents = percents.map(|(part, whole)| digits(100.0 * part / whole)).join(" | ");
    cells(&format!("{} | {} | {open} | {percents}", solid.name, digits(interval)))
}
