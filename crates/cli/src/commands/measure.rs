//! `transect measure`: bounds of the areas of each plane, and of the volume.

use super::lengths::distance;
use super::open_model;
use crate::failure::Failure;
use crate::table::{Lengths, Quantity, Row, length, print, print_csv, print_grid, say};
use std::path::PathBuf;
use transect_geometry::{LengthUnit, PlaneFamily, PlaneIndex, Point3};
use transect_model::{Bracket, ModelVolume, Section, SectionMeasures, Volume};
use transect_workflow::ModelFile;

/// Options of `measure`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote.
    file: PathBuf,
    /// Print the sums only.
    #[arg(long)]
    sums: bool,
    /// Also estimate areas and volumes with gaps closed by straight chords, where no gap is wider
    /// than this length.
    #[arg(long, value_name = "LENGTH")]
    close_gaps: Option<String>,
    /// Print comma separated values for a spreadsheet: a line per plane, or the sums with --sums.
    #[arg(long)]
    csv: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = open_model(&arguments.file)?;
    let close_gaps = distance("close-gaps", arguments.close_gaps.as_ref(), file.unit())?;
    let mut planes = Vec::new();
    let usable = file.planes().guide().usable_distance();
    let measures = |section: &Section| section.measures_within(usable);
    file.for_each_section(|plane, section| planes.push((plane, measures(section))))?;
    if planes.is_empty() {
        let problem = "the model has no curves, so there is nothing to measure. Add views to it \
                       with transect reconstruct SCAN --store FILE";
        return Err(Failure::with_file(&arguments.file, problem));
    }
    note_if_cut(&file, &planes);
    match (arguments.csv, arguments.sums) {
        (true, true) => print_sums_csv(&file, &planes, close_gaps)?,
        (true, false) => print_planes_csv(&file, &planes, close_gaps),
        (false, sums) => {
            if !sums {
                print_planes(&file, &planes, close_gaps);
            }
            print(&rows(&file, &planes, close_gaps)?);
        }
    }
    Ok(())
}

/// Says on how many planes curves end at the usable distance of a curved guide.
fn note_if_cut(file: &ModelFile, planes: &[(PlaneIndex, SectionMeasures)]) {
    let cut = planes.iter().filter(|(_, measures)| measures.is_cut).count();
    if cut > 0 {
        let usable = length(file.planes().guide().usable_distance(), file.unit());
        eprintln!(
            "note: on {cut} of {} planes curves end at the usable distance of the guide, {usable}. \
             The surface goes on beyond it, so the largest areas and volumes are unknown, and these \
             gaps are not closed. A guide with wider bends covers more",
            planes.len()
        );
    }
}

/// Whether all gaps of a plane are to be closed, which are those up to a width.
fn is_closed(measures: &SectionMeasures, widest: f64) -> bool {
    measures.widest_gap <= widest && !measures.is_cut
}

/// Whether all gaps of all planes are to be closed.
fn all_closed(planes: &[(PlaneIndex, SectionMeasures)], widest: f64) -> bool {
    planes.iter().all(|(_, measures)| is_closed(measures, widest))
}

/// Prints a line per plane with numbers alone. What is unknown is empty.
fn print_planes_csv(
    file: &ModelFile,
    planes: &[(PlaneIndex, SectionMeasures)],
    close_gaps: Option<f64>,
) {
    let lengths = Lengths::for_programs(file.unit());
    let unit = lengths.unit;
    let mut heads = vec!["plane".to_owned(), format!("station, {unit}")];
    for kind in ["solid", "clear"] {
        heads.extend(["least", "most"].map(|bound| format!("{bound} {kind} area, {unit}²")));
    }
    heads.push(format!("perimeter, {unit}"));
    heads.extend(["x", "y", "z"].map(|axis| format!("centroid {axis}, {unit}")));
    heads.push(format!("open length, {unit}"));
    heads.extend(["outer", "holes", "open"].map(str::to_owned));
    heads.extend(closed_heads(unit, close_gaps));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let line = |(plane, measures): &(PlaneIndex, SectionMeasures)| {
        csv_line(file.planes(), *plane, measures, close_gaps, &lengths)
    };
    print_csv(&heads, &planes.iter().map(line).collect::<Vec<_>>());
}

fn csv_line(
    family: &PlaneFamily,
    plane: PlaneIndex,
    measures: &SectionMeasures,
    close_gaps: Option<f64>,
    lengths: &Lengths,
) -> Vec<String> {
    let length = |value| lengths.exact(value, 1);
    let area = |value: Option<f64>| value.map(|a| lengths.exact(a, 2)).unwrap_or_default();
    let SectionMeasures { solid, clear, .. } = measures;
    let mut line = vec![plane.to_string(), length(family.station(plane))];
    line.extend([Some(solid.least), solid.most, Some(clear.least), clear.most].map(area));
    line.push(length(measures.perimeter));
    let centroid = centroid(family, plane, measures);
    let axis = |k: usize| centroid.map(|c| length(c[k])).unwrap_or_default();
    line.extend([0, 1, 2].map(axis));
    line.push(length(measures.open_length));
    let counts = [measures.outer_curves, measures.hole_curves, measures.open_curves];
    line.extend(counts.map(|count| count.to_string()));
    if let Some(widest) = close_gaps {
        let closed = is_closed(measures, widest);
        line.extend([solid, clear].map(|bounds| area(closed.then_some(bounds.estimate))));
    }
    line
}

/// The heads of the areas with gaps closed, where these are asked for.
fn closed_heads(unit: LengthUnit, close_gaps: Option<f64>) -> Vec<String> {
    let kinds = close_gaps.map_or(&[][..], |_| &["solid", "clear"]);
    kinds.iter().map(|kind| format!("{kind}, gaps closed, {unit}²")).collect()
}

/// The centroid of the larger side of a plane's curves, in the world.
fn centroid(family: &PlaneFamily, plane: PlaneIndex, measures: &SectionMeasures) -> Option<Point3> {
    let of_solid = measures.solid.estimate >= measures.clear.estimate;
    let centroid = if of_solid { measures.solid_centroid } else { measures.clear_centroid };
    centroid.map(|c| family.frame(plane).world_from_plane(&c))
}

/// Prints a line per plane.
fn print_planes(
    file: &ModelFile,
    planes: &[(PlaneIndex, SectionMeasures)],
    close_gaps: Option<f64>,
) {
    let longest = planes.iter().map(|(_, m)| m.perimeter.max(m.open_length)).fold(0.0, f64::max);
    let lengths = Lengths::new(file.unit(), longest);
    let unit = lengths.unit;
    let mut heads = vec![
        "plane".to_owned(),
        format!("station, {unit}"),
        format!("solid area, {unit}²"),
        format!("clear area, {unit}²"),
        format!("perimeter, {unit}"),
        format!("centroid, {unit}"),
        format!("open length, {unit}"),
        "outer".to_owned(),
        "holes".to_owned(),
        "open".to_owned(),
    ];
    heads.extend(closed_heads(unit, close_gaps));
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let line = |(plane, measures): &(PlaneIndex, SectionMeasures)| {
        line(file.planes(), *plane, measures, close_gaps, &lengths)
    };
    print_grid(&heads, &planes.iter().map(line).collect::<Vec<_>>());
    say("");
}

fn line(
    family: &PlaneFamily,
    plane: PlaneIndex,
    measures: &SectionMeasures,
    close_gaps: Option<f64>,
    lengths: &Lengths,
) -> Vec<String> {
    let in_world = centroid(family, plane, measures);
    let mut line = vec![
        plane.to_string(),
        lengths.coordinate(family.station(plane)),
        bounds(&measures.solid, lengths, 2),
        bounds(&measures.clear, lengths, 2),
        lengths.digits(measures.perimeter, 1),
        in_world.map(|c| lengths.place(&c)).unwrap_or_default(),
        lengths.digits(measures.open_length, 1),
        measures.outer_curves.to_string(),
        measures.hole_curves.to_string(),
        measures.open_curves.to_string(),
    ];
    if let Some(widest) = close_gaps {
        let closed = is_closed(measures, widest);
        let areas = [measures.solid, measures.clear];
        line.extend(areas.map(|area| estimate(&area, closed, lengths, 2)));
    }
    line
}

/// The bounds as text: one number if they agree in all printed digits.
fn bounds(bracket: &Bracket, lengths: &Lengths, power: u8) -> String {
    let least = lengths.digits(bracket.least, power);
    match bracket.most.map(|most| lengths.digits(most, power)) {
        None if bracket.least == 0.0 => "unknown".to_owned(),
        None => format!("{least} or more"),
        Some(most) if most == least => least,
        Some(most) => format!("{least} to {most}"),
    }
}

fn estimate(bracket: &Bracket, closed: bool, lengths: &Lengths, power: u8) -> String {
    if closed { lengths.digits(bracket.estimate, power) } else { "wider gaps".to_owned() }
}

/// A sum over all planes: its name and its value.
#[derive(Clone, Copy)]
enum Sum {
    Count(&'static str, usize),
    Length(&'static str, f64),
}

/// The sums over all planes but for the volumes.
fn sums(planes: &[(PlaneIndex, SectionMeasures)], volume: &ModelVolume) -> [Sum; 7] {
    let measures = || planes.iter().map(|(_, measures)| measures);
    let with_open_curves = measures().filter(|m| m.open_curves > 0).count();
    let contradictions: usize = measures().map(|m| m.contradictions).sum();
    [
        Sum::Count("planes with curves", planes.len()),
        Sum::Count("planes with open curves", with_open_curves),
        Sum::Length("length of closed curves", measures().map(|m| m.perimeter).sum()),
        Sum::Length("length of open curves", measures().map(|m| m.open_length).sum()),
        Sum::Length("widest gap", volume.widest_gap),
        Sum::Count("directions that contradict nesting", contradictions),
        Sum::Count("runs of neighbouring planes", volume.runs.len()),
    ]
}

/// Prints the sums with one number in each line. What is unknown is empty.
fn print_sums_csv(
    file: &ModelFile,
    planes: &[(PlaneIndex, SectionMeasures)],
    close_gaps: Option<f64>,
) -> Result<(), Failure> {
    let (volume, lengths) = (file.volume()?, Lengths::for_programs(file.unit()));
    let unit = lengths.unit.symbol();
    let line = |sum: Sum| match sum {
        Sum::Count(name, count) => vec![name.to_owned(), count.to_string(), String::new()],
        Sum::Length(name, length) => {
            vec![name.to_owned(), lengths.exact(length, 1), unit.to_owned()]
        }
    };
    let mut lines: Vec<Vec<String>> = sums(planes, &volume).map(line).to_vec();
    let closed = close_gaps.map(|widest| all_closed(planes, widest));
    for (name, volume) in [("solid volume", &volume.solid), ("clear volume", &volume.clear)] {
        let exact = |value: Option<f64>| value.map(|v| lengths.exact(v, 3)).unwrap_or_default();
        let values = volume_sums(name, volume, closed);
        lines.extend(values.map(|(name, value)| vec![name, exact(value), format!("{unit}³")]));
    }
    print_csv(&["metric", "value", "unit"], &lines);
    Ok(())
}

/// The bounds of a volume, its error and its estimate with gaps closed, as single numbers.
fn volume_sums(
    name: &str,
    volume: &Volume,
    closed: Option<bool>,
) -> impl Iterator<Item = (String, Option<f64>)> {
    let (Volume { bracket, interval_error, .. }, known) = (volume, is_known(volume));
    let closed = closed.map(|closed| {
        (format!("{name}, gaps closed"), (closed && known).then_some(bracket.estimate))
    });
    let bounds = [
        (format!("least {name}"), known.then_some(bracket.least)),
        (format!("most {name}"), bracket.most.filter(|_| known)),
        (format!("largest interval error of {name}"), Some(*interval_error)),
    ];
    bounds.into_iter().chain(closed)
}

/// Whether a volume is known. A single plane has no neighbour that tells how far its area reaches.
fn is_known(volume: &Volume) -> bool {
    volume.bracket.estimate == 0.0 || volume.interval_error < volume.bracket.estimate
}

/// The sums over all planes, and the volumes.
fn rows(
    file: &ModelFile,
    planes: &[(PlaneIndex, SectionMeasures)],
    close_gaps: Option<f64>,
) -> Result<Vec<Row>, Failure> {
    let (volume, unit) = (file.volume()?, file.unit());
    let row = |sum: Sum| match sum {
        Sum::Count(name, count) => Row::plain(name, count),
        Sum::Length(name, length) => Row::length(name, length, unit),
    };
    let mut rows: Vec<Row> = sums(planes, &volume).map(row).to_vec();
    let closed = close_gaps.map(|widest| all_closed(planes, widest));
    let largest = volume.solid.bracket.estimate.max(volume.clear.bracket.estimate);
    let lengths = Lengths::of(&Quantity::new(largest, unit, 3));
    rows.extend(volume_rows("solid volume", &volume.solid, closed, &lengths));
    rows.extend(volume_rows("clear volume", &volume.clear, closed, &lengths));
    Ok(rows)
}

fn volume_rows(name: &str, volume: &Volume, closed: Option<bool>, lengths: &Lengths) -> Vec<Row> {
    let Volume { bracket, interval_error, .. } = volume;
    let row = |name: String, value: String| {
        let is_number = value.starts_with(|first: char| first.is_ascii_digit());
        let unit = if is_number { format!("{}³", lengths.unit) } else { String::new() };
        Row::new(name, value, unit)
    };
    let error = lengths.digits(*interval_error, 3);
    let known = is_known(volume);
    let or_unknown = |text: String| if known { text } else { "too few planes".to_owned() };
    let mut rows = vec![
        row(name.to_owned(), or_unknown(bounds(bracket, lengths, 3))),
        row(format!("largest interval error of {name}"), error),
    ];
    rows.extend(closed.map(|closed| {
        let value = or_unknown(estimate(bracket, closed, lengths, 3));
        row(format!("{name}, gaps closed"), value)
    }));
    rows
}
