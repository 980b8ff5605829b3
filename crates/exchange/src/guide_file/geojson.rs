//! The points of a GeoJSON `LineString` (RFC 7946).

use super::Placed;
use crate::Place;
use crate::error::Problem;
use serde_json::Value;
use transect_geometry::Point3;

pub(super) fn points(text: &str) -> Result<Vec<Placed>, Problem> {
    let value: Value = serde_json::from_str(text)
        .map_err(|e| Problem::at(Place::Line(e.line()), format!("not valid JSON: {e}")))?;
    let mut lines = Vec::new();
    collect(&value, 0, &mut lines);
    let &[line] = lines.as_slice() else {
        let problem = format!("{} objects of type LineString; a guide is one", lines.len());
        return Err(Problem::damaged(problem));
    };
    let positions = line.get("coordinates").and_then(Value::as_array);
    let none = || Problem::damaged("the LineString has no list of coordinates");
    positions.ok_or_else(none)?.iter().enumerate().map(|(k, v)| position(k, v)).collect()
}

/// All line strings of an object, of its geometry and of its features.
fn collect<'a>(value: &'a Value, depth: usize, lines: &mut Vec<&'a Value>) {
    // A collection holds features, and a feature holds a geometry: no valid file is deeper.
    const MAX_DEPTH: usize = 4;
    if depth > MAX_DEPTH {
        return;
    }
    if value.get("type").and_then(Value::as_str) == Some("LineString") {
        lines.push(value);
    }
    let list = |key: &str| value.get(key).and_then(Value::as_array).into_iter().flatten();
    let inner = value.get("geometry").into_iter().chain(list("features")).chain(list("geometries"));
    inner.for_each(|v| collect(v, depth + 1, lines));
}

/// A position is named by its number, because parsed JSON has no lines.
fn position(number: usize, value: &Value) -> Result<Placed, Problem> {
    let numbers: Option<Vec<f64>> =
        value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    let at = Place::Element { kind: "position".to_owned(), number, line: None };
    match numbers.as_deref() {
        Some(&[x, y, z]) => Ok(Placed { point: Point3::new(x, y, z), at }),
        _ => Err(Problem::at(at, format!("{value} is not three numbers x, y and z"))),
    }
}
