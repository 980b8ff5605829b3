//! `transect gaps`: the surface that no view saw, and proposed next views.

use super::open_model;
use crate::failure::Failure;
use crate::table::{Lengths, Row, print, print_grid, say};
use std::collections::BTreeMap;
use std::path::PathBuf;
use transect_geometry::{EndReason, LengthUnit, PlaneFamily, PlaneIndex, Point3};
use transect_model::Section;
use transect_model::gaps::{Gap, KnownSpace, NextView, NextViewOptions, UnseenPatch, next_views};
use transect_model::store::Snapshot;
use transect_workflow::ModelFile;

/// Options of `gaps`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote. Only a store keeps the curves
    /// of each view, from which next views are proposed.
    file: PathBuf,
    /// Number of gaps to list, the widest first.
    #[arg(long, default_value_t = 20)]
    list: usize,
    /// Number of views to propose.
    #[arg(long, default_value_t = 3)]
    views: usize,
    /// Also list the unseen part of every plane.
    #[arg(long)]
    planes: bool,
    /// Largest incidence of a next view on the surface, in degrees from the surface's normal.
    #[arg(long, value_name = "DEGREES", default_value_t = 75.0)]
    incidence: f64,
}

/// Pieces into which a gap is cut, per interval between planes. Chosen by hand. Doubled, the
/// search for next views has twice as many pieces to look at.
const PIECES_PER_INTERVAL: f64 = 2.0;
/// Number of rays from which the free space follows. Chosen by hand. Doubled, memory and time
/// double.
const RAYS: u64 = 300_000;

/// Incidence in degrees at which every place in sight of a surface sees it. Theory: below 90, where
/// the surface is seen edge-on. Doubling has no meaning.
const GRAZING: f64 = 89.9;

/// The gaps of a model.
#[derive(Default)]
struct Missing {
    length: f64,
    width: f64,
    gaps: Vec<(PlaneIndex, Gap)>,
    by_plane: Vec<UnseenPart>,
}

/// The unseen part of one plane: station, length of curves, number and width of gaps.
type UnseenPart = (PlaneIndex, f64, f64, usize, f64);

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if !(0.0..90.0).contains(&arguments.incidence) {
        let found = arguments.incidence;
        let problem = format!("--incidence is {found}; expected degrees, from 0 to below 90");
        return Err(Failure::Usage(problem));
    }
    let file = open_model(&arguments.file)?;
    let mut missing = Missing::default();
    let planes = file.planes().clone();
    file.for_each_section(|plane, section| missing.add(plane, &planes, section))?;
    missing.gaps.sort_by(|a, b| b.1.width().total_cmp(&a.1.width()).then(a.0.cmp(&b.0)));
    if arguments.planes {
        missing.print_by_plane(file.unit());
    }
    missing.print_widest(&planes, file.unit(), arguments.list);
    print(&missing.rows(file.unit()));
    match &file {
        ModelFile::Store(store) => propose(&missing, &planes, &store.snapshot, arguments),
        ModelFile::Plain(_) if arguments.views > 0 => {
            say(
                "\nNo views are proposed: a model file does not keep the curves of each view. A store does:",
            );
            say("make one with reconstruct --store FILE.");
            Ok(())
        }
        ModelFile::Plain(_) => Ok(()),
    }
}

impl Missing {
    fn add(&mut self, plane: PlaneIndex, planes: &PlaneFamily, section: &Section) {
        let (length, gaps) = (section.length(), section.gaps());
        let width: f64 = gaps.iter().map(Gap::width).sum();
        self.by_plane.push((plane, planes.station(plane), length, gaps.len(), width));
        self.length += length;
        self.width += width;
        self.gaps.extend(gaps.into_iter().map(|gap| (plane, gap)));
    }

    fn print_by_plane(&self, unit: LengthUnit) {
        let longest = self.by_plane.iter().map(|part| part.2).fold(0.0, f64::max);
        let lengths = Lengths::new(unit, longest);
        let [station, curves, widths] = ["station", "curves' length", "gaps' width"]
            .map(|head| format!("{head}, {}", lengths.unit));
        let line = |&(plane, station, length, gaps, width): &UnseenPart| {
            let share = format!("{:.1}", percent(width, length));
            let station = lengths.coordinate(station);
            let [length, width] = [length, width].map(|l| lengths.digits(l, 1));
            vec![plane.to_string(), station, length, gaps.to_string(), width, share]
        };
        let lines: Vec<_> = self.by_plane.iter().map(line).collect();
        print_grid(&["plane", &station, &curves, "gaps", &widths, "unseen, %"], &lines);
        say("");
    }

    fn print_widest(&self, planes: &PlaneFamily, unit: LengthUnit, count: usize) {
        let Some((_, widest)) = self.gaps.first() else { return };
        let lengths = Lengths::new(unit, widest.width());
        let line = |gap| line(gap, planes, &lengths);
        let lines: Vec<_> = self.gaps.iter().take(count).map(line).collect();
        let [width, from, to] = ["width", "from", "to"].map(|h| format!("{h}, {}", lengths.unit));
        if !lines.is_empty() {
            print_grid(&["plane", &width, &from, &to, "reason at from", "reason at to"], &lines);
            say("");
        }
    }

    fn rows(&self, unit: LengthUnit) -> Vec<Row> {
        let mut rows = vec![
            Row::plain("gaps", self.gaps.len()),
            Row::length("width of gaps", self.width, unit),
            Row::length("length of curves", self.length, unit),
            Row::new("unseen, at least", format!("{:.1}", percent(self.width, self.length)), "%"),
        ];
        let mut by_reason = BTreeMap::<_, f64>::new();
        for (_, gap) in &self.gaps {
            for reason in gap.reasons {
                *by_reason.entry(word(reason)).or_default() += gap.width() / 2.0;
            }
        }
        let row = |(reason, width)| Row::length(format!("of it for {reason}"), width, unit);
        rows.extend(by_reason.into_iter().map(row));
        rows
    }
}

/// The share of the gaps in the whole boundary, in per cent, as if gaps were straight.
fn percent(width: f64, length: f64) -> f64 {
    if width + length > 0.0 { 100.0 * width / (width + length) } else { 0.0 }
}

fn line((plane, gap): &(PlaneIndex, Gap), planes: &PlaneFamily, lengths: &Lengths) -> Vec<String> {
    let frame = planes.frame(*plane);
    let [from, to] = gap.ends.map(|end| lengths.place(&frame.world_from_plane(&end)));
    let [ends, begins] = gap.reasons.map(word);
    vec![plane.to_string(), lengths.digits(gap.width(), 1), from, to, ends, begins]
}

fn word(reason: Option<EndReason>) -> String {
    reason.map_or("unknown reason".to_owned(), |r| r.to_string())
}

fn propose(
    missing: &Missing,
    planes: &PlaneFamily,
    snapshot: &Snapshot,
    arguments: &Arguments,
) -> Result<(), Failure> {
    if arguments.views == 0 || missing.gaps.is_empty() {
        return Ok(());
    }
    let rays = rays(snapshot)?;
    let reach = rays.iter().map(|(sensor, seen)| (seen - sensor).norm()).fold(0.0, f64::max);
    let Some(space) = KnownSpace::from_rays(&rays) else {
        say("\nNo next views: the store has no ray of a view, so no space is known to be free.");
        return Ok(());
    };
    let spacing = planes.interval() / PIECES_PER_INTERVAL;
    let patches = |(plane, gap): &(PlaneIndex, Gap)| {
        gap.patches(&planes.frame(*plane), spacing, planes.interval())
    };
    let patches: Vec<UnseenPatch> = missing.gaps.iter().flat_map(patches).collect();
    let max_incidence_rad = arguments.incidence.to_radians();
    let options = NextViewOptions::new(arguments.views, max_incidence_rad, reach);
    let unseen: f64 = patches.iter().map(|p| p.area).sum();
    let found = next_views(&patches, &space, &options);
    if found.is_empty() {
        let any_incidence = NextViewOptions::new(1, GRAZING.to_radians(), reach);
        let is_limited = !next_views(&patches, &space, &any_incidence).is_empty();
        say(&no_views(is_limited.then_some(arguments.incidence)));
        return Ok(());
    }
    say("\nNext views that would see most of that, if no hidden surface stands in their way:\n");
    let lengths = Lengths::new(snapshot.header().unit, reach);
    let line = |view: &NextView| {
        let share = format!("{:.1}", 100.0 * view.area / unseen);
        let [position, target] = [view.position, view.target].map(|p| lengths.place(&p));
        vec![position, target, lengths.digits(view.area, 2), share]
    };
    let lines: Vec<_> = found.iter().map(line).collect();
    let [at, to] = ["sensor at", "looking at"].map(|head| format!("{head}, {}", lengths.unit));
    let area = format!("area, {}²", lengths.unit);
    print_grid(&[&at, &to, &area, "of the unseen, %"], &lines);
    Ok(())
}

/// Why no view is proposed. `limiting` is the largest incidence, in degrees, if a larger one would
/// give proposals.
fn no_views(limiting: Option<f64>) -> String {
    let cause = match limiting {
        Some(degrees) => format!(
            " at an incidence of {degrees}° or less. Places at a larger one do: pass a larger \
             --incidence."
        ),
        None => ". A view far from all others makes that space too coarse: check its pose, or \
                 remove it."
            .to_owned(),
    };
    format!(
        "\nNo place in the free space that the views looked through would see more of that{cause}"
    )
}

/// Rays from each view's sensor to its nodes on the planes, evenly thinned.
fn rays(snapshot: &Snapshot) -> Result<Vec<(Point3, Point3)>, Failure> {
    let (views, planes) = (snapshot.views()?, snapshot.header().planes.clone());
    let nodes: u64 = views.iter().map(|view| view.nodes).sum();
    let stride = usize::try_from(nodes.div_ceil(RAYS).max(1)).unwrap_or(usize::MAX);
    let sensor = |v: &transect_model::store::StoredView| {
        (v.entry.id.clone(), Point3::from(v.entry.world_from_sensor.translation.vector))
    };
    let sensors: BTreeMap<_, _> = views.iter().map(sensor).collect();
    let mut rays = Vec::new();
    for plane in snapshot.planes()? {
        let (plane, _) = plane?;
        let frame = planes.frame(plane);
        for (view, curves) in snapshot.partials(plane)? {
            let Some(&sensor) = sensors.get(&view) else { continue };
            let nodes = curves.iter().flat_map(|curve| curve.nodes()).step_by(stride);
            rays.extend(nodes.map(|node| (sensor, frame.world_from_plane(&node.position))));
        }
    }
    Ok(rays)
}
