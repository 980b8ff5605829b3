//! `contours.json`: the model's curves for other programs.
//!
//! ```json
//! { "unit": "m", "planes": [ { "index": 3, "station": 0.2,
//!     "origin": [0, 0, 0.2], "normal": [0, 0, 1], "x_axis": [1, 0, 0],
//!     "polylines": [ { "closed": true, "points": [[0, 0, 0.2], [1, 0, 0.2], [0, 1, 0.2]],
//!                      "sigma": [0.001, 0.001, 0.001], "views": [4, 4, 3] } ] } ] }
//! ```
//!
//! Points and all lengths are in the world, in the model's length unit. A closed polyline does not
//! repeat its first point. The solid is on the left, seen against the normal.
//!
//! A plane has its number `index` and its distance `station` along the guide. Its frame has the
//! point `origin`, the unit vector `normal` along the guide, and the unit vector `x_axis`. The y
//! axis is normal × x_axis.
//!
//! `sigma` is a node's standard deviation across the curve (0: unknown). `views` is the number of
//! views that observed it (0: bridged). Two keys are optional. `bridged` lists the segments that no
//! view saw (k: from point k to the next). `ends` gives the reasons why an open polyline begins and
//! ends: `missing_pixel`, `range_jump`, `image_border`, or null for an unknown reason.
//!
//! Numbers have the fewest digits that read back as the same number. So the same model gives the
//! same bytes, and no precision is lost far from the origin.

use serde::Serialize;
use std::io::{self, Write};
use transect_geometry::{Curve, EndReason, Node, PlaneFrame, PlaneIndex};
use transect_model::{Model, Section};

/// A plane in the file.
#[derive(Serialize)]
struct PlaneText {
    index: i64,
    station: f64,
    origin: [f64; 3],
    normal: [f64; 3],
    x_axis: [f64; 3],
    polylines: Vec<PolylineText>,
}

#[derive(Serialize)]
struct PolylineText {
    closed: bool,
    points: Vec<[f64; 3]>,
    sigma: Vec<f32>,
    views: Vec<u32>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    bridged: Vec<usize>,
    #[serde(skip_serializing_if = "unknown")]
    ends: [Option<EndReason>; 2],
}

fn unknown(ends: &[Option<EndReason>; 2]) -> bool {
    *ends == [None; 2]
}

/// Writes a model's curves, one plane per line.
///
/// # Errors
/// An error of `out`.
pub fn write_contours(model: &Model, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "{{\"unit\":\"{}\",\"planes\":[", model.unit())?;
    for (number, (index, section)) in model.sections().enumerate() {
        let separator = if number > 0 { "," } else { "" };
        let frame = model.planes().frame(index);
        let station = model.planes().station(index);
        // One plane at a time, so that only one plane is in memory as text.
        let line = serde_json::to_string(&plane_text(index, station, &frame, section))?;
        write!(out, "{separator}\n{line}")?;
    }
    writeln!(out, "\n]}}")
}

fn plane_text(index: PlaneIndex, station: f64, frame: &PlaneFrame, section: &Section) -> PlaneText {
    let polyline = |curve: &Curve| {
        let nodes = curve.nodes();
        let point = |n: &Node| frame.world_from_plane(&n.position).coords.into();
        PolylineText {
            closed: curve.is_closed(),
            points: nodes.iter().map(point).collect(),
            sigma: nodes.iter().map(|n| n.sigma).collect(),
            views: nodes.iter().map(Node::view_count).collect(),
            bridged: nodes.iter().enumerate().filter(|(_, n)| n.bridged).map(|(k, _)| k).collect(),
            ends: curve.ends(),
        }
    };
    PlaneText {
        index: index.0,
        station,
        origin: frame.origin().coords.into(),
        normal: frame.normal().into(),
        x_axis: frame.x_axis().into(),
        polylines: section.curves().map(polyline).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::model;
    use proptest::prelude::*;
    use serde::Deserialize;
    use transect_geometry::{Point2, Point3};

    proptest! {
        #[test]
        fn every_number_of_the_curves_is_in_the_file(
            points in prop::collection::vec((-9.0..9.0, -9.0..9.0, 0.0f32..1.0), 3..20),
            normal in prop::array::uniform3(0.1..1.0),
            closed: bool,
        ) {
            let node = |&(x, y, sigma): &(f64, f64, f32)| {
                let at = Node::at(Point2::new(x + 5e5, y + 5.4e6)).with_sigma(sigma);
                at.with_views(3).with_weight(3.0).with_bridged(sigma > 0.5)
            };
            let curve = Curve::new(points.iter().map(node).collect(), closed).unwrap();
            let curve = curve.with_ends([Some(EndReason::RangeJump), None]);
            let model = model(normal, &[(-2, vec![curve.clone()])]);
            let mut text = Vec::new();
            write_contours(&model, &mut text).unwrap();
            let text: serde_json::Value = serde_json::from_slice(&text).unwrap();
            let plane = &text["planes"][0];
            prop_assert_eq!(&plane["index"], -2);
            let frame = model.planes().frame(PlaneIndex(-2));
            let vector = |v: &serde_json::Value| <[f64; 3]>::deserialize(v).unwrap();
            prop_assert_eq!(vector(&plane["origin"]), <[f64; 3]>::from(frame.origin().coords));
            prop_assert_eq!(vector(&plane["x_axis"]), <[f64; 3]>::from(frame.x_axis()));
            let read = &plane["polylines"][0];
            let ends = <[Option<EndReason>; 2]>::deserialize(&read["ends"]).unwrap_or_default();
            prop_assert_eq!((read["closed"].as_bool(), ends), (Some(closed), curve.ends()));
            let bridged = Vec::<usize>::deserialize(&read["bridged"]).unwrap_or_default();
            prop_assert_eq!(read["points"].as_array().unwrap().len(), curve.nodes().len());
            for (k, node) in curve.nodes().iter().enumerate() {
                // Micrometres survive five thousand kilometres from the origin.
                let point = frame.plane_from_world(&Point3::from(vector(&read["points"][k])));
                prop_assert!((point - node.position).norm() < 1e-8);
                let sigma = f32::deserialize(&read["sigma"][k]).unwrap();
                prop_assert_eq!((sigma, &read["views"][k]), (node.sigma, &3.into()));
                prop_assert_eq!(bridged.contains(&k), node.bridged);
            }
        }
    }

    #[test]
    fn the_file_is_the_documented_one() {
        let nodes = [(0.0, 0.0), (1.0, 0.0), (0.0, 0.1)].map(|(x, y)| Node::at(Point2::new(x, y)));
        let triangle = Curve::new(nodes.to_vec(), true).unwrap();
        let mut text = Vec::new();
        write_contours(&model([0.0, 0.0, 1.0], &[(2, vec![triangle])]), &mut text).unwrap();
        let wanted = concat!(
            "{\"unit\":\"mm\",\"planes\":[\n",
            "{\"index\":2,\"station\":0.5,\"origin\":[0.0,0.0,0.5],\"normal\":[0.0,0.0,1.0],",
            "\"x_axis\":[1.0,0.0,0.0],\"polylines\":[{\"closed\":true,\"points\":",
            "[[0.0,0.0,0.5],[1.0,0.0,0.5],[0.0,0.1,0.5]],\"sigma\":[0.0,0.0,0.0],",
            "\"views\":[1,1,1]}]}\n]}\n"
        );
        assert_eq!(String::from_utf8(text).unwrap(), wanted);
    }
}
