//! `cargo xtask inspect` of a model file or a model store.

use super::model_file::{ModelFile, open_store};
use crate::failure::Failure;
use crate::table::{Row, digits, print, say};
use std::path::Path;
use transect_geometry::Guide;
use transect_model::SCHEMA_VERSION;
use transect_model::store::{STORE_VERSION, Snapshot};

/// Runs the command.
pub fn run(path: &Path) -> Result<(), Failure> {
    // What is in a store is told as it is: nothing is fused before.
    if let Ok(model) = transect_model::Model::load(path) {
        let kind = format!("model file, version {SCHEMA_VERSION}");
        let mut rows = vec![Row::new("kind", kind, ""), Row::count("views", model.views().len())];
        let noise = |sigma: Option<f64>| sigma.map_or("unknown".to_owned(), digits);
        rows.extend(model.views().iter().map(|view| {
            let value = format!("{} nodes, noise {}", view.nodes, noise(view.sigma));
            Row::new(format!("view {}", view.name), value, model.unit().symbol())
        }));
        let asked = model.selected().map(std::collections::BTreeSet::len);
        let file = ModelFile::Plain(Box::new(model));
        rows.extend(plane_rows(&file));
        rows.extend(asked.map(|count| Row::count("planes asked for", count)));
        rows.extend(curve_rows(&file)?);
        print(&rows);
        return Ok(());
    }
    let store = open_store(path)?;
    let snapshot = store.read()?;
    let mut rows = store_rows(&snapshot)?;
    let waiting = snapshot.pending()?.len();
    let options = snapshot.header().options.clone();
    let file = ModelFile::Store(Box::new(snapshot), store);
    rows.extend(plane_rows(&file));
    if waiting > 0 {
        rows.push(Row::count("planes still to be fused", waiting));
    } else {
        rows.extend(curve_rows(&file)?);
    }
    print(&rows);
    // Too long for a table.
    say(&format!("\noptions: {options}"));
    Ok(())
}

fn store_rows(snapshot: &Snapshot) -> Result<Vec<Row>, Failure> {
    let views = snapshot.views()?;
    Ok(vec![
        Row::new("kind", format!("model store, version {STORE_VERSION}"), ""),
        Row::new("made by", snapshot.header().tool.clone(), ""),
        Row::count("views", views.len()),
        Row::new(
            "curves of all views",
            views.iter().map(|v| v.curves).sum::<u64>().to_string(),
            "",
        ),
        Row::new("nodes of all views", views.iter().map(|v| v.nodes).sum::<u64>().to_string(), ""),
    ])
}

fn plane_rows(file: &ModelFile) -> Vec<Row> {
    let (planes, unit) = (file.planes(), file.unit().symbol());
    let along = match planes.guide() {
        Guide::Straight(guide) => {
            let normal: [f64; 3] = guide.direction().into();
            Row::new("planes, normal", normal.map(digits).join(", "), "")
        }
        Guide::Curved(guide) => Row::new("guide, curved, length", digits(guide.length()), unit),
    };
    vec![
        along,
        Row::new("planes, offset", digits(planes.offset()), unit),
        Row::new("planes, interval", digits(planes.interval()), unit),
    ]
}

fn curve_rows(file: &ModelFile) -> Result<Vec<Row>, Failure> {
    let (mut planes, mut curves, mut closed, mut nodes, mut length) = (0, 0, 0, 0, 0.0);
    let mut range = None;
    file.for_each_section(|plane, section| {
        planes += 1;
        curves += section.curve_records().len();
        closed += section.curve_records().len() - section.open_curve_count();
        nodes += section.node_count();
        length += section.length();
        range = Some((range.map_or(plane, |(first, _)| first), plane));
    })?;
    let range = range.map_or("none".to_owned(), |(first, last)| format!("{first} to {last}"));
    Ok(vec![
        Row::count("planes with curves", planes),
        Row::new("plane numbers", range, ""),
        Row::count("curves", curves),
        Row::count("closed curves", closed),
        Row::count("nodes", nodes),
        Row::new("curve length", digits(length), file.unit().symbol()),
    ])
}
