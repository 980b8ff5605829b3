//! `transect measure`: bounds of the areas of each plane, and of the volume.

use super::open_model;
use crate::failure::Failure;
use crate::table::{Row, digits, print, print_grid, say};
use std::path::PathBuf;
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_model::{Bracket, Section, Volume};
use transect_workflow::{ModelFile, parse_length};

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
}

/// Sums over planes.
#[derive(Default)]
struct Sums {
    planes: usize,
    planes_with_open_curves: usize,
    perimeter: f64,
    open_length: f64,
    contradictions: usize,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let file = open_model(&arguments.file)?;
    let parse = |text: &String| parse_length(file.unit(), "close-gaps", text);
    let close_gaps = arguments.close_gaps.as_ref().map(parse).transpose()?;
    let (mut sums, mut lines, family) = (Sums::default(), Vec::new(), file.planes());
    file.for_each_section(|plane, section| {
        let line = line(family, plane, section, close_gaps, &mut sums);
        if !arguments.sums {
            lines.push(line);
        }
    })?;
    if !arguments.sums {
        print_grid(&HEADS[..if close_gaps.is_some() { 12 } else { 10 }], &lines);
        say("");
    }
    print(&rows(&file, close_gaps, &sums)?);
    Ok(())
}

const HEADS: [&str; 12] = [
    "plane",
    "station",
    "solid area",
    "clear area",
    "perimeter",
    "centroid",
    "open length",
    "outer",
    "holes",
    "open",
    "solid, gaps closed",
    "clear, gaps closed",
];

fn line(
    family: &PlaneFamily,
    plane: PlaneIndex,
    section: &Section,
    close_gaps: Option<f64>,
    sums: &mut Sums,
) -> Vec<String> {
    let measures = section.measures();
    sums.planes += 1;
    sums.planes_with_open_curves += usize::from(measures.open_curves > 0);
    sums.perimeter += measures.perimeter;
    sums.open_length += measures.open_length;
    sums.contradictions += measures.contradictions;
    let of_solid = measures.solid.estimate >= measures.clear.estimate;
    let centroid = if of_solid { measures.solid_centroid } else { measures.clear_centroid };
    let in_world = centroid.map(|c| family.frame(plane).world_from_plane(&c));
    let centroid = in_world.map(|c| <[f64; 3]>::from(c.coords).map(digits).join(", "));
    let mut line = vec![
        plane.to_string(),
        digits(family.station(plane)),
        bounds(&measures.solid),
        bounds(&measures.clear),
        digits(measures.perimeter),
        centroid.unwrap_or_default(),
        digits(measures.open_length),
        measures.outer_curves.to_string(),
        measures.hole_curves.to_string(),
        measures.open_curves.to_string(),
    ];
    if let Some(widest) = close_gaps {
        let closed = measures.widest_gap <= widest;
        line.extend([measures.solid, measures.clear].map(|area| estimate(&area, closed)));
    }
    line
}

/// The bounds as text: one number if they agree in all printed digits.
fn bounds(bracket: &Bracket) -> String {
    let least = digits(bracket.least);
    match bracket.most.map(digits) {
        None if bracket.least == 0.0 => "unknown".to_owned(),
        None => format!("{least} or more"),
        Some(most) if most == least => least,
        Some(most) => format!("{least} to {most}"),
    }
}

fn estimate(bracket: &Bracket, closed: bool) -> String {
    if closed { digits(bracket.estimate) } else { "wider gaps".to_owned() }
}

fn rows(file: &ModelFile, close_gaps: Option<f64>, sums: &Sums) -> Result<Vec<Row>, Failure> {
    let (volume, unit) = (file.volume()?, file.unit().symbol());
    let mut rows = vec![
        Row::plain("planes with curves", sums.planes),
        Row::plain("planes with open curves", sums.planes_with_open_curves),
        Row::new("length of closed curves", digits(sums.perimeter), unit),
        Row::new("length of open curves", digits(sums.open_length), unit),
        Row::new("widest gap", digits(volume.widest_gap), unit),
        Row::plain("directions that contradict nesting", sums.contradictions),
        Row::plain("runs of neighbouring planes", volume.runs.len()),
    ];
    let closed = close_gaps.map(|widest| volume.widest_gap <= widest);
    for (name, Volume { bracket, interval_error, .. }) in
        [("solid volume", volume.solid), ("clear volume", volume.clear)]
    {
        let mut add = |name: String, value: String| {
            let is_number = value.starts_with(|first: char| first.is_ascii_digit());
            let unit = if is_number { format!("{unit}³") } else { String::new() };
            rows.push(Row::new(name, value, unit));
        };
        add(name.to_owned(), bounds(&bracket));
        add(format!("largest interval error of {name}"), digits(interval_error));
        if let Some(closed) = closed {
            add(format!("{name}, gaps closed"), estimate(&bracket, closed));
        }
    }
    Ok(rows)
}
