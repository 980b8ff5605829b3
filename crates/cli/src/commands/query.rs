//! `transect query`: whether points are inside the solid, outside, or unknown.

use super::lengths::distance;
use super::open_model;
use super::planes::parse_numbers;
use crate::failure::Failure;
use crate::table::{Lengths, print_csv, print_grid};
use std::path::PathBuf;
use transect::{Setup, correct_by_free_space};
use transect_geometry::Point3;
use transect_model::store::SpaceQuery;
use transect_model::{Location, SpaceAnswer};
use transect_workflow::{ModelFile, OpenStore};

/// Options of `query`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store, model file, or folder that `reconstruct` wrote.
    file: PathBuf,
    /// Points in the world, in the model's unit.
    #[arg(required = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    points: Vec<String>,
    /// Largest distance of the nearest curve that decides; farther points are unknown. The ground
    /// between a point and a far curve may hide a surface that no view saw [default: any distance].
    #[arg(long, value_name = "LENGTH")]
    within: Option<String>,
    /// Print comma separated values for a spreadsheet, without the answers of single planes.
    #[arg(long)]
    csv: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let points: Result<Vec<Point3>, Failure> = arguments.points.iter().map(|p| point(p)).collect();
    let points = points?;
    let file = open_model(&arguments.file)?;
    let unit = file.unit();
    let within = distance("within", arguments.within.as_ref(), unit)?;
    let mut answers = answers(file, &points)?;
    answers.iter_mut().for_each(|answer| limit(answer, within.unwrap_or(f64::INFINITY)));
    if arguments.csv {
        print_answers_csv(&points, &answers, &Lengths::for_programs(unit));
        return Ok(());
    }
    let distances = answers.iter().filter_map(|a| a.distance_to_nearest_curve);
    let lengths = Lengths::new(unit, distances.fold(0.0, f64::max));
    let heads = ["point", "location", &format!("nearest curve, {}", lengths.unit), "by plane"];
    let lines = arguments.points.iter().zip(&answers).map(|(p, answer)| line(p, answer, &lengths));
    print_grid(&heads, &lines.collect::<Vec<_>>());
    Ok(())
}

fn answers(file: ModelFile, points: &[Point3]) -> Result<Vec<SpaceAnswer>, Failure> {
    match file {
        ModelFile::Plain(model) => Ok(points.iter().map(|p| model.locate(p)).collect()),
        ModelFile::Store(store) => answers_of_store(store, points),
    }
}

/// The answers by the nearest curves, corrected by what the store's views looked through.
fn answers_of_store(file: OpenStore, points: &[Point3]) -> Result<Vec<SpaceAnswer>, Failure> {
    let OpenStore { snapshot, store, .. } = file;
    let free_space = Setup::of_store(snapshot.header()).is_ok_and(|setup| setup.free_space);
    let mut query = SpaceQuery::new(*snapshot, SpaceQuery::DEFAULT_CAPACITY);
    let answers: Result<Vec<SpaceAnswer>, Failure> =
        points.iter().map(|p| Ok(query.locate(p)?)).collect();
    let mut answers = answers?;
    let corrected = match free_space {
        true => correct_by_free_space(&store.read()?, points, &mut answers)?,
        false => 0,
    };
    if corrected > 0 {
        eprintln!(
            "note: {corrected} of {} points are inside by their nearest curve, but views looked \
             through them. They are unknown if one view did, and outside if several did",
            points.len()
        );
    }
    Ok(answers)
}

/// Prints a line per point with a distance in all its digits; it is empty where no curve is near.
fn print_answers_csv(points: &[Point3], answers: &[SpaceAnswer], lengths: &Lengths) {
    let unit = lengths.unit;
    let mut heads: Vec<String> = ["x", "y", "z"].map(|axis| format!("{axis}, {unit}")).to_vec();
    heads.extend(["location".to_owned(), format!("nearest curve, {unit}")]);
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let exact = |value| lengths.exact(value, 1);
    let line = |(point, answer): (&Point3, &SpaceAnswer)| {
        let mut line: Vec<String> = point.iter().map(|c| exact(*c)).collect();
        line.push(word(answer.location).to_owned());
        line.push(answer.distance_to_nearest_curve.map(exact).unwrap_or_default());
        line
    };
    print_csv(&heads, &points.iter().zip(answers).map(line).collect::<Vec<_>>());
}

/// Makes an answer unknown if its curve is farther away than wanted.
fn limit(answer: &mut SpaceAnswer, within: f64) {
    if answer.distance_to_nearest_curve.is_some_and(|distance| distance > within) {
        answer.location = Location::Unknown;
    }
}

fn line(point: &str, answer: &SpaceAnswer, lengths: &Lengths) -> Vec<String> {
    let distance = |d: Option<f64>| d.map_or("none".to_owned(), |d| lengths.digits(d, 1));
    let planes = answer.planes.iter().map(|(plane, said)| {
        format!("{plane}: {} at {}", word(said.location), distance(said.distance_to_nearest_curve))
    });
    vec![
        point.to_owned(),
        word(answer.location).to_owned(),
        distance(answer.distance_to_nearest_curve),
        planes.collect::<Vec<_>>().join("; "),
    ]
}

fn word(location: Location) -> &'static str {
    match location {
        Location::Inside => "inside",
        Location::Outside => "outside",
        Location::Unknown => "unknown",
    }
}

fn point(text: &str) -> Result<Point3, Failure> {
    let numbers = parse_numbers(text).filter(|p: &[f64; 3]| p.iter().all(|c| c.is_finite()));
    let wrong = match text.starts_with("--") {
        true => "an option stands before the points",
        false => "write a point as three numbers, such as 0,1.5,-2",
    };
    numbers.map(Point3::from).ok_or_else(|| Failure::Usage(format!("{text}: {wrong}")))
}
