//! `transect inspect`: the contents of a scan, before it is modelled, or of a model.

use super::inspect_model;
use super::scan::ScanArguments;
use crate::failure::Failure;
use crate::notes;
use crate::table::{Lengths, Row, digits, length, print, print_grid, say};
use std::path::PathBuf;
use transect::Unwatched;
use transect_device::Note;
use transect_geometry::{LengthUnit, Point3};
use transect_workflow::{OpenScan, PlaneSettings, ViewSurvey, is_model, with_causes};

/// Options of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// A scan: scan.json or its folder, a Stanford .conf, a folder of depth images, an E57 or PTX
    /// file, an organised cloud (PCD, PLY, KITTI). Or a model file, a model store, or a folder that
    /// `reconstruct` wrote.
    scan: PathBuf,
    #[command(flatten)]
    open: ScanArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    if is_model(&arguments.scan) {
        if !arguments.open.is_empty() {
            let problem = "a model is inspected as it is; leave out the options that open a scan \
                           or choose a part of it";
            return Err(Failure::Usage(problem.to_owned()));
        }
        return inspect_model::run(&arguments.scan);
    }
    let scan = arguments.open.open(&arguments.scan)?;
    let (surveyed, refusal) = scan.survey_all();
    let (mut views, mut failures) = (Vec::new(), Vec::new());
    for (number, surveyed) in surveyed.into_iter().enumerate() {
        match surveyed {
            Ok(view) => views.push((number, view)),
            Err(error) => failures.push(with_causes(&error)),
        }
    }
    let told: Vec<Note> = views.iter().flat_map(|(_, view)| view.notes.clone()).collect();
    notes::tell(&told);
    let whole = refusal.map(|reason| format!("reconstruct stops: {reason}"));
    notes::warn(&whole.into_iter().chain(refusals(&views)).collect::<Vec<_>>());
    print(&scan_rows(&scan, &views));
    if failures.is_empty()
        && let Some(poses) = scan.judge(&Unwatched)?
    {
        notes::tell(&poses.notes());
        notes::warn(&poses.warnings());
    }
    if !views.is_empty() {
        say("");
        print_views(&views, scan.scan().unit);
    }
    // Every bad view is named, not only the first.
    if !failures.is_empty() {
        return Err(Failure::Failed(failures.join("\n").into()));
    }
    say(&format!("\nreconstruct it: {}", command(&scan, &views)?));
    Ok(())
}

/// The first view at which a run would stop, and the number of the others.
fn refusals(views: &[(usize, ViewSurvey)]) -> Option<String> {
    let refused = || views.iter().filter(|(_, view)| view.refusal.is_some());
    let (_, first) = refused().next()?;
    let others = match refused().count() - 1 {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let reason = first.refusal.as_deref().unwrap_or_default();
    Some(format!("reconstruct stops at view {}{others}: {reason}", first.name))
}

fn scan_rows(opened: &OpenScan, views: &[(usize, ViewSurvey)]) -> Vec<Row> {
    let (scan, unit) = (opened.scan(), opened.scan().unit);
    let mut rows = vec![
        Row::new("scan", scan.name.clone(), ""),
        Row::new("unit", unit.symbol(), ""),
        Row::plain("views", scan.views.len()),
    ];
    if let Some(planes) = &scan.planes {
        rows.push(Row::new("planes, normal", planes.normal.map(digits).join(", "), ""));
        rows.push(Row::length("planes, offset", planes.offset, unit));
        rows.push(Row::length("planes, interval", planes.interval, unit));
    }
    let corners = views.iter().map(|(_, view)| view.corners);
    let extent = corners.reduce(|a, b| (a.0.inf(&b.0), a.1.sup(&b.1)));
    rows.extend(extent.into_iter().flat_map(|corners| extent_rows(corners, unit)));
    rows
}

fn extent_rows((low, high): (Point3, Point3), unit: LengthUnit) -> [Row; 3] {
    let row = |axis: &str, low: f64, high: f64| {
        let lengths = Lengths::new(unit, low.abs().max(high.abs()));
        let range = format!("{} to {}", lengths.digits(low, 1), lengths.digits(high, 1));
        Row::new(format!("extent, {axis}"), range, lengths.unit.symbol())
    };
    [row("x", low.x, high.x), row("y", low.y, high.y), row("z", low.z, high.z)]
}

/// One line per view.
fn print_views(views: &[(usize, ViewSurvey)], unit: LengthUnit) {
    let farthest = views.iter().map(|(_, view)| view.range[2]).fold(0.0, f64::max);
    let origins = views.iter().map(|(_, v)| v.place.coords.amax());
    let (ranges, places) =
        (Lengths::new(unit, farthest), Lengths::new(unit, origins.fold(0.0, f64::max)));
    let heads = [
        "number",
        "view",
        "sensor",
        "rows × columns",
        "missing, %",
        &format!("nearest, median, farthest, {}", ranges.unit),
        "pixel spacing",
        "noise",
        "seen by others, %",
        &format!("sensor at, {}", places.unit),
        "looking along",
    ];
    let line = |(number, view): &(usize, ViewSurvey)| {
        let missing = 100.0 * (1.0 - view.valid as f64 / view.size.pixels() as f64);
        let spacing = view.spacing.map(|both| both.map(|one| length(one, unit)).join(" × "));
        let how = if view.sigma_given { "stated" } else { "estimated" };
        let sight = <[f64; 3]>::from(view.sight).map(|c| format!("{:.2}", c + 0.0));
        vec![
            number.to_string(),
            view.name.clone(),
            format!("{}, {}", view.frame, view.sensor.name()),
            format!("{} × {}", view.size.rows, view.size.cols),
            format!("{missing:.1}"),
            view.range.map(|range| ranges.digits(range, 1)).join(", "),
            spacing.unwrap_or_default(),
            format!("{} {how}", length(view.sigma, unit)),
            view.overlap.map_or(String::new(), |share| format!("{:.0}", 100.0 * share)),
            places.place(&view.place),
            sight.join(", "),
        ]
    };
    print_grid(&heads, &views.iter().map(line).collect::<Vec<_>>());
}

/// The command that reconstructs the scan as it was inspected, with suggested planes if the scan
/// states none. The reason for them is printed before.
fn command(scan: &OpenScan, views: &[(usize, ViewSurvey)]) -> Result<String, Failure> {
    let mut words: Vec<String> =
        std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(command) = words.iter_mut().find(|word| *word == "inspect") {
        *command = "reconstruct".to_owned();
    }
    let mut command =
        format!("transect {}", words.iter().map(|w| quoted(w)).collect::<Vec<_>>().join(" "));
    if scan.scan().planes.is_none() {
        let wanted = scan.surveyed_for_planes();
        let of_plane = views.iter().filter(|(number, _)| wanted.contains(number));
        let surveyed: Vec<ViewSurvey> = of_plane.map(|(_, view)| view.clone()).collect();
        let suggestion = scan.suggestion(&surveyed, &PlaneSettings::default())?;
        let reason = suggestion.reason.unwrap_or_default();
        say(&format!("\nsuggested planes: {}", suggestion.options()));
        say(&format!("the normal is {reason}"));
        if let Some(text) = &suggestion.far_away {
            notes::warn(std::slice::from_ref(text));
        }
        command = format!("{command} {}", suggestion.options());
    }
    Ok(command)
}

/// A word as a shell reads it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
