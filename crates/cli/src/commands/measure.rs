//! `transect measure`: area, perimeter, centroid and open length of each plane, and the volume.

use super::open_model;
use crate::failure::Failure;
use crate::table::{Row, digits, print, print_grid, say};
use std::path::PathBuf;
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_model::Section;
use transect_workflow::ModelFile;

/// Options of `measure`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote.
    file: PathBuf,
    /// Print the sums only.
    #[arg(long)]
    sums: bool,
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
    let (mut sums, mut lines, family) = (Sums::default(), Vec::new(), file.planes());
    file.for_each_section(|plane, section| {
        let line = line(family, plane, section, &mut sums);
        if !arguments.sums {
            lines.push(line);
        }
    })?;
    if !arguments.sums {
        print_grid(&HEADS, &lines);
        say("");
    }
    print(&rows(&file, &sums)?);
    Ok(())
}

const HEADS: [&str; 10] = [
    "plane",
    "station",
    "area",
    "perimeter",
    "centroid",
    "open length",
    "outer",
    "holes",
    "open",
    "contradictions",
];

fn line(
    family: &PlaneFamily,
    plane: PlaneIndex,
    section: &Section,
    sums: &mut Sums,
) -> Vec<String> {
    let measures = section.measures();
    let contradictions = section.nesting().iter().filter(|curve| curve.contradicts_parent).count();
    sums.planes += 1;
    sums.planes_with_open_curves += usize::from(measures.open_curves > 0);
    sums.perimeter += measures.perimeter;
    sums.open_length += measures.open_length;
    sums.contradictions += contradictions;
    let in_world = measures.centroid.map(|c| family.frame(plane).world_from_plane(&c));
    let centroid = in_world.map(|c| <[f64; 3]>::from(c.coords).map(digits).join(", "));
    vec![
        plane.to_string(),
        digits(family.station(plane)),
        digits(measures.area),
        digits(measures.perimeter),
        centroid.unwrap_or_default(),
        digits(measures.open_length),
        measures.outer_curves.to_string(),
        measures.hole_curves.to_string(),
        measures.open_curves.to_string(),
        contradictions.to_string(),
    ]
}

fn rows(file: &ModelFile, sums: &Sums) -> Result<Vec<Row>, Failure> {
    let (volume, unit) = (file.volume()?, file.unit().symbol());
    let bound = match volume.error_bound() {
        Some(bound) => Row::new("volume is off by at most", digits(bound), format!("{unit}³")),
        None => Row::new("volume is off by at most", "unknown: open curves", ""),
    };
    Ok(vec![
        Row::plain("planes with curves", sums.planes),
        Row::plain("planes with open curves", sums.planes_with_open_curves),
        Row::new("length of closed curves", digits(sums.perimeter), unit),
        Row::new("length of open curves", digits(sums.open_length), unit),
        Row::plain("directions that contradict nesting", sums.contradictions),
        Row::plain("runs of neighbouring planes", volume.runs.len()),
        Row::new("volume", digits(volume.volume()), format!("{unit}³")),
        bound,
    ])
}
