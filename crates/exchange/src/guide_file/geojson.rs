//! The points of a GeoJSON `LineString` (RFC 7946).

use super::{Placed, Problem};
use crate::Place;
use serde_json::Value;
use transect_geometry::Point3;

pub(super) fn points(text: &str) -> Result<Vec<Placed>, Problem> {
    let value: Value = serde_json::from_str(text)
        .map_err(|e| (Place::Line(e.line()), format!("not valid JSON: {e}")))?;
    let mut lines = Vec::new();
    collect(&value, 0, &mut lines);
    let &[line] = lines.as_slice() else {
        let problem = format!("{} objects of type LineString; a guide is one", lines.len());
        return Err((Place::Whole, problem));
    };
    let positions = line.get("coordinates").and_then(Value::as_array);
    let none = || (Place::Whole, "the LineString has no list of coordinates".to_owned());
    positions.ok_or_else(none)?.iter().enumerate().map(|(k, v)| position(k, v)).collect()
}

/// All line strings of an object, of its geometry and of its features.
fn collect<'a>(value: &'a Value, depth: usize, lines: &mut Vec<&'a Value>) {
    // A collection holds features, and a feature a geometry: nothing legitimate is nested deeper.
    const DEEPEST: usize = 4;
    if depth > DEEPEST {
        return;
    }
    if value.get("type").and_then(Value::as_str) == Some("LineString") {
        lines.push(value);
    }
    let list = |key: &str| value.get(key).and_then(Value::as_array).into_iter().flatten();
    let inner = value.get("geometry").into_iter().chain(list("features")).chain(list("geometries"));
    inner.for_each(|v| collect(v, depth + 1, lines));
}

/// Positions have no lines any more; their number stands for it.
fn position(number: usize, value: &Value) -> Result<Placed, Problem> {
    let numbers: Option<Vec<f64>> =
        value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    let at = Place::Element { kind: "position".to_owned(), number, line: None };
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok((Point3::new(x, y, z), at)),
        _ => Err((at, format!("{value} is not three numbers x, y and z"))),
    }
}
