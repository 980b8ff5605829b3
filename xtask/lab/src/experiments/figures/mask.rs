//! How a model grows with each view, and how good the face mask of 5.6.2 is in the end.
//!
//! The dissertation's methods and today's defaults get the same eight views of the line scanner at
//! its true size. One section of each result is drawn beside the other, with its error enlarged.

use super::super::lab::Lab;
use super::super::trial;
use crate::failure::Failure;
use crate::table::{self, digits, length, say, share};
use transect::evaluate::Accuracy;
use transect::{Reconstruction, Setup};
use transect_device::View;
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_fusion::FusionMethod;
use transect_fusion::pairwise::GrowthCounts;
use transect_geometry::{Curve, LengthUnit, Point2};
use transect_model::Model;
use transect_partial::Method;
use transect_workflow::simulation::PreparedScene;
use transect_workflow::{ScoreLimits, simulated_accuracy};

/// Height of the section that is drawn, in millimetres: through the nose and both cheeks.
const DRAWN: f64 = -15.63;

/// Factor on the errors in the drawing. Chosen by hand: 0.006 mm, a usual error, is 6 pixels long.
/// Doubled, errors of both sides of the nose reach into each other.
const ENLARGED: f64 = 300.0;

/// Largest error that is drawn, in millimetres; larger ones are drawn as long as this one.
const LARGEST: f64 = 0.04;

/// Distance between two drawn errors along a curve, in millimetres.
const STEP: f64 = 0.25;

/// Width and height of one panel, in pixels of the figure.
const PANEL: [f64; 2] = [560.0, 400.0];

/// Both methods, by the names that the tables give them.
pub fn setups(scene: &PreparedScene) -> [(&'static str, Setup); 2] {
    let default = trial::setup(scene);
    let mut dissertation = default.clone();
    dissertation.partial = Method::Dissertation(Default::default());
    dissertation.fusion = FusionMethod::Pairwise(Default::default());
    [("dissertation, pairwise", dissertation), ("one_pass, consensus (default)", default)]
}

/// The growth table, view by view.
pub struct Growth {
    unit: LengthUnit,
    before: GrowthCounts,
    lines: Vec<Vec<String>>,
}

/// The columns of the growth table. Captions name all but the first two.
const COLUMNS: &str = "view | length | case 1 | case 2 | case 3 | merged | a | b | c | d | e | refused | \
                       gaps | length of gaps";

impl Growth {
    /// An empty table in a unit.
    pub fn new(unit: LengthUnit) -> Self {
        Self { unit, before: GrowthCounts::default(), lines: Vec::new() }
    }

    /// Adds the model after one more view, and tells its counts in a sentence.
    pub fn add(&mut self, result: &Reconstruction) -> String {
        let now = result.report.fusion.growth.unwrap_or_default();
        let widths = result.model.sections().flat_map(|(_, section)| section.gaps());
        let gaps: Vec<f64> = widths.map(|gap| gap.width()).collect();
        let new = |all: usize, before: usize| all.saturating_sub(before).to_string();
        let mut line = vec![(self.lines.len() + 1).to_string(), self.length(result.model.length())];
        line.extend((0..3).map(|k| new(now.cases[k], self.before.cases[k])));
        line.push(new(now.merged, self.before.merged));
        line.extend((0..5).map(|k| new(now.patterns[k], self.before.patterns[k])));
        line.push(new(now.refused(), self.before.refused()));
        line.push(gaps.len().to_string());
        line.push(self.length(gaps.iter().sum()));
        let counts = COLUMNS.split(" | ").zip(&line).skip(2).filter(|(_, count)| *count != "0");
        let told: Vec<_> = counts.map(|(what, count)| format!("{what} {count}")).collect();
        self.lines.push(line);
        self.before = now;
        told.join(", ")
    }

    /// A length in the table: four digits or more.
    fn length(&self, length: f64) -> String {
        format!("{} {}", digits(length), self.unit)
    }

    /// Prints the table and writes it into `NAME.md`.
    pub fn print(&self, name: &str, lab: &Lab) -> Result<(), Failure> {
        lab.table(name, COLUMNS, self.lines.clone())?;
        say("The model after each view: planes of cases 1 to 3 (5.2.2), merged pairs and their \
             patterns (Figure 5.7), pairs that the rules refuse, and gaps that are left.\n");
        Ok(())
    }
}

/// The results of both methods, in the order of [`setups`].
pub struct Judged<'a> {
    /// The scene.
    pub scene: &'a PreparedScene,
    /// Its views.
    pub views: &'a [View],
    /// Name and model of each method.
    pub models: Vec<(&'static str, Model)>,
}

impl Judged<'_> {
    /// Prints the accuracy of both.
    ///
    /// # Errors
    /// [`Failure`] if a model cannot be scored.
    pub fn print(&self, lab: &Lab) -> Result<(), Failure> {
        let line = |(name, model): &(&'static str, Model)| -> Result<Vec<String>, Failure> {
            let limits = ScoreLimits::default();
            let found = simulated_accuracy(model, &self.scene.truth, self.views.to_vec(), &limits)?;
            Ok(table::line(*name, figures(&found, model)))
        };
        let lines: Result<Vec<_>, _> = self.models.iter().map(line).collect();
        let heads = "method | median, mm | 95 %, mm | complete % | oriented % | duplicates % | off the truth % | curves";
        lab.table("methods", heads, lines?)?;
        say("Distances from the true sections, on what the views could see.");
        Ok(())
    }

    /// One section of both, side by side, with enlarged errors.
    ///
    /// # Errors
    /// [`Failure`] if the truth cannot be cut.
    pub fn drawn(&self) -> Result<Figure, Failure> {
        let planes = &self.scene.description.planes;
        let chord = 1e-3 * planes.interval();
        let truth = self.scene.scene.sections(planes, chord)?;
        let near = |k: &&transect_geometry::PlaneIndex| {
            (planes.station(**k) - DRAWN).abs() < 0.5 * planes.interval()
        };
        let plane = truth.keys().find(near).copied();
        let Some((plane, truth)) = plane.and_then(|k| Some((k, truth.get(&k)?))) else {
            return Err(Failure::because("no plane cuts the nose of the mask"));
        };
        let height = format!("{:.2}", planes.station(plane)).replace('-', "\u{2212}");
        let caption = format!(
            "One section through nose and cheeks, at z = {height} mm. Errors are drawn {ENLARGED} times \
             larger, and at most as {LARGEST} mm."
        );
        let size = [2.0 * PANEL[0] + 20.0, PANEL[1]];
        let mut figure =
            Figure::new("The face mask from eight views, by two methods", caption, size);
        for (k, (name, model)) in self.models.iter().enumerate() {
            let left = k as f64 * (PANEL[0] + 20.0);
            let curves: Vec<&Curve> =
                model.sections().filter(|s| s.0 == plane).flat_map(|(_, s)| s.curves()).collect();
            panel(&mut figure, left, name, truth, &curves);
        }
        figure.legend(Mark::Line("#888"), "true section");
        figure.legend(Mark::Line("#1b5e9c"), "curve of the model");
        figure.legend(Mark::Line("#d95f02"), "its error, enlarged");
        Ok(figure)
    }
}

/// The cells of a method.
fn figures(found: &Accuracy, model: &Model) -> Vec<String> {
    let lengths = [found.median, found.p95].map(length);
    let shares = [found.completeness, found.oriented, found.duplicated, found.off].map(share);
    let curves: usize = model.sections().map(|(_, s)| s.curves().len()).sum();
    lengths.into_iter().chain(shares).chain([curves.to_string()]).collect()
}

/// The true section, the curves and their enlarged errors, the nose upwards.
fn panel(figure: &mut Figure, left: f64, name: &str, truth: &[Curve], curves: &[&Curve]) {
    /// Pixels of the figure per millimetre.
    const SCALE: f64 = 3.5;
    let corner = Point2::new(left, 0.0);
    let place = |p: &Point2| {
        Point2::new(left + 0.5 * PANEL[0] - SCALE * p.x, PANEL[1] - 60.0 + SCALE * p.y)
    };
    let line = |figure: &mut Figure, points: &[Point2], closed: bool, style: &str| {
        let places: Vec<Point2> = points.iter().map(place).collect();
        figure.line(&places, closed, &format!("fill=\"none\" {style}"));
    };
    let positions = |c: &Curve| c.nodes().iter().map(|n| n.position).collect::<Vec<_>>();
    figure.clipped(corner, PANEL, |figure| {
        for curve in truth {
            line(figure, &positions(curve), true, "stroke=\"#888\" stroke-width=\"1\"");
        }
        for curve in curves {
            let style = "stroke=\"#1b5e9c\" stroke-width=\"2.5\"";
            line(figure, &positions(curve), curve.is_closed(), style);
            let errors = enlarged(curve, truth);
            line(figure, &errors, false, "stroke=\"#d95f02\" stroke-width=\"1\"");
        }
    });
    figure.rectangle(corner, PANEL, "fill=\"none\" stroke=\"#222\"");
    let at = Point2::new(left + 14.0, 26.0);
    figure.text(at, Anchor::Start, 18.0, "#222", name);
    figure.scale_bar(Point2::new(left + PANEL[0] - 140.0, 20.0), [SCALE, 80.0], "mm");
}

/// Points along a curve, moved away from the truth by enlarged errors.
fn enlarged(curve: &Curve, truth: &[Curve]) -> Vec<Point2> {
    let along = curve.units().flat_map(|unit| {
        let count = (unit.vector().norm() / STEP).ceil().max(1.0) as usize;
        (0..count).map(move |k| unit.at((k as f64 + 0.5) / count as f64))
    });
    let moved = along.filter_map(|p| {
        let feet = truth.iter().map(|t| t.foot(&p));
        let foot = feet.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        Some(p + ENLARGED * (p - foot.point).cap_magnitude(LARGEST))
    });
    moved.collect()
}
