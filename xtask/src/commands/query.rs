//! `cargo xtask query`: whether points are in the solid, as far as the model tells.

use super::experiments::table;
use super::model_file::ModelFile;
use crate::failure::Failure;
use crate::table::digits;
use std::path::PathBuf;
use transect_geometry::Point3;
use transect_model::store::SpaceQuery;
use transect_model::{Location, SpaceAnswer};

/// Options of `query`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Model store or model file.
    file: PathBuf,
    /// Points in the world, in the model's unit.
    #[arg(required = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    points: Vec<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    let points: Result<Vec<Point3>, Failure> = arguments.points.iter().map(|p| point(p)).collect();
    let points = points?;
    let file = ModelFile::open(&arguments.file)?;
    let unit = file.unit().symbol();
    let answers = answers(file, &points)?;
    let heads = ["point", "location", &format!("nearest curve, {unit}"), "by plane"];
    let lines = arguments.points.iter().zip(&answers).map(|(text, answer)| line(text, answer));
    table::print(&heads, &lines.collect::<Vec<_>>());
    Ok(())
}

fn answers(file: ModelFile, points: &[Point3]) -> Result<Vec<SpaceAnswer>, Failure> {
    match file {
        ModelFile::Plain(model) => Ok(points.iter().map(|p| model.locate(p)).collect()),
        ModelFile::Store(snapshot, _store) => {
            let mut query = SpaceQuery::new(*snapshot, SpaceQuery::DEFAULT_CAPACITY);
            points.iter().map(|p| Ok(query.locate(p)?)).collect()
        }
    }
}

fn line(point: &str, answer: &SpaceAnswer) -> Vec<String> {
    let distance = |d: Option<f64>| d.map_or("none".to_owned(), digits);
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
    let numbers: Vec<f64> = text.split(',').filter_map(|n| n.trim().parse().ok()).collect();
    match (numbers.as_slice(), text.split(',').count()) {
        (&[x, y, z], 3) if [x, y, z].iter().all(|c: &f64| c.is_finite()) => {
            Ok(Point3::new(x, y, z))
        }
        _ => {
            Err(Failure::Usage(format!("{text}: write a point as three numbers, such as 0,1.5,-2")))
        }
    }
}
