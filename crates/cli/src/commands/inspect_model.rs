//! `transect inspect` of a model file or a model store.

use crate::failure::Failure;
use crate::table::{Row, digits, length, print, say};
use std::path::Path;
use transect_geometry::Guide;
use transect_model::store::{STORE_VERSION, Snapshot};
use transect_model::{Model, SCHEMA_VERSION};
use transect_workflow::ModelFile;

/// Runs the command. Nothing is fused: a store is shown as it is.
pub fn run(path: &Path) -> Result<(), Failure> {
    let file = ModelFile::open_unfinished(path)?;
    let mut rows = Vec::new();
    let mut options = None;
    match &file {
        ModelFile::Plain(model) => {
            rows.extend(model_rows(model));
            rows.extend(plane_rows(&file));
            rows.extend(model.selected().map(|asked| Row::plain("planes in use", asked.len())));
            rows.extend(curve_rows(&file)?);
        }
        ModelFile::Store(store) => {
            rows.extend(store_rows(&store.snapshot)?);
            rows.extend(plane_rows(&file));
            match store.snapshot.pending()?.len() {
                0 => rows.extend(curve_rows(&file)?),
                waiting => rows.push(Row::plain("planes still to be fused", waiting)),
            }
            options = Some(&store.snapshot.header().options);
        }
    }
    print(&rows);
    if let Some(options) = options {
        // Too long for a table.
        say(&format!("\noptions: {options}"));
    }
    Ok(())
}

fn model_rows(model: &Model) -> Vec<Row> {
    let kind = format!("model file, version {SCHEMA_VERSION}");
    let mut rows = vec![Row::new("kind", kind, ""), Row::plain("views", model.views().len())];
    rows.extend(model.views().iter().map(|view| {
        let noise = view.sigma.map_or("unknown".to_owned(), |sigma| length(sigma, model.unit()));
        Row::new(format!("view {}", view.name), format!("{} nodes, noise {noise}", view.nodes), "")
    }));
    rows
}

fn store_rows(snapshot: &Snapshot) -> Result<Vec<Row>, Failure> {
    let views = snapshot.views()?;
    Ok(vec![
        Row::new("kind", format!("model store, version {STORE_VERSION}"), ""),
        Row::new("made by", snapshot.header().tool.clone(), ""),
        Row::plain("views", views.len()),
        Row::plain("curves of all views", views.iter().map(|v| v.curves).sum::<u64>()),
        Row::plain("nodes of all views", views.iter().map(|v| v.nodes).sum::<u64>()),
    ])
}

fn plane_rows(file: &ModelFile) -> Vec<Row> {
    let (planes, unit) = (file.planes(), file.unit());
    let along = match planes.guide() {
        Guide::Straight(guide) => {
            let normal: [f64; 3] = guide.direction().into();
            Row::new("planes, normal", normal.map(digits).join(", "), "")
        }
        Guide::Curved(guide) => Row::length("guide, curved, length", guide.length(), unit),
    };
    vec![
        along,
        Row::length("planes, offset", planes.offset(), unit),
        Row::length("planes, interval", planes.interval(), unit),
    ]
}

fn curve_rows(file: &ModelFile) -> Result<Vec<Row>, Failure> {
    let (mut planes, mut curves, mut closed, mut nodes, mut total) = (0, 0, 0, 0, 0.0);
    let mut range = None;
    file.for_each_section(|plane, section| {
        planes += 1;
        curves += section.curve_records().len();
        closed += section.curve_records().len() - section.open_curve_count();
        nodes += section.node_count();
        total += section.length();
        range = Some((range.map_or(plane, |(first, _)| first), plane));
    })?;
    let range = range.map_or("none".to_owned(), |(first, last)| format!("{first} to {last}"));
    Ok(vec![
        Row::plain("planes with curves", planes),
        Row::new("plane numbers", range, ""),
        Row::plain("curves", curves),
        Row::plain("closed curves", closed),
        Row::plain("nodes", nodes),
        Row::length("curve length", total, file.unit()),
    ])
}
