//! `contours.json`: the model's curves for other programs.
//!
//! ```json
//! { "unit": "m", "planes": [ { "index": 3, "station": 0.2,
//!     "origin": [0, 0, 0.2], "normal": [0, 0, 1], "x_axis": [1, 0, 0],
//!     "polylines": [ { "closed": true, "points": [[0, 0, 0.2], [1, 0, 0.2], [0, 1, 0.2]],
//!                      "sigma": [0.001, 0.001, 0.001], "views": [4, 4, 3] } ] } ] }
//! ```
//!
//! Points are in the world, in the model's length unit. A closed polyline does not repeat its first
//! point. The solid is on the left, seen against the normal.
//!
//! `sigma` is a node's standard deviation across the curve (0: unknown). `views` is the number of
//! views that observed it (0: bridged). Two keys are optional. `bridged` lists the segments that no
//! view saw (k: from point k to the next). `ends` gives the reasons why an open polyline begins and
//! ends: `missing_pixel`, `range_jump`, `image_border`, or null for an unknown reason.
//!
//! Numbers have the fewest digits that read back as the same number. So the same model gives the
//! same bytes, and no precision is lost far from the origin.

use crate::input::read_text;
use crate::{Place, ReadError};
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::Path;
use transect_geometry::{
    Curve, EndReason, LengthUnit, Node, PlaneFrame, PlaneIndex, Point2, Point3, Vector3,
};
use transect_model::{Model, Section};

/// The curves of a contour file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Contours {
    /// The unit of all lengths.
    pub unit: LengthUnit,
    /// The planes in the file's order.
    pub planes: Vec<ContourPlane>,
}

/// One plane of a contour file.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ContourPlane {
    /// Its number.
    pub index: PlaneIndex,
    /// Its place along the guide, in the file's length unit.
    pub station: f64,
    /// Its local frame: the file's origin and normal with this workspace's in-plane axes.
    pub frame: PlaneFrame,
    /// Its curves, in coordinates of `frame`; footprints are not in the file and read as 0, a
    /// node's weight as its number of views.
    pub curves: Vec<Curve>,
}

/// A plane in the file. Keys that other programs may leave out have a default.
#[derive(Serialize, Deserialize)]
struct PlaneText {
    index: i64,
    #[serde(default)]
    station: f64,
    origin: [f64; 3],
    normal: [f64; 3],
    #[serde(default)]
    x_axis: [f64; 3],
    polylines: Vec<PolylineText>,
}

#[derive(Serialize, Deserialize)]
struct PolylineText {
    closed: bool,
    points: Vec<[f64; 3]>,
    #[serde(default)]
    sigma: Vec<f32>,
    #[serde(default)]
    views: Vec<u32>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    bridged: Vec<usize>,
    #[serde(default, skip_serializing_if = "unknown")]
    ends: [Option<EndReason>; 2],
}

fn unknown(ends: &[Option<EndReason>; 2]) -> bool {
    *ends == [None; 2]
}

#[derive(Deserialize)]
struct ContoursText {
    unit: LengthUnit,
    planes: Vec<PlaneText>,
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

/// Reads a contour file by this or another program; `sigma`, `views`, `bridged`, `ends`,
/// `station` and `x_axis` may be missing.
///
/// # Errors
/// [`ReadError`] if the file is not JSON of this form or a plane has no normal. Also if a polyline
/// has too few points, points that are not finite, or lists of different lengths.
pub fn read_contours(path: &Path) -> Result<Contours, ReadError> {
    let parsed = serde_json::from_str(&read_text(path)?);
    let text: ContoursText =
        parsed.map_err(|source| ReadError::Json { path: path.to_owned(), source })?;
    let planes = text.planes.into_iter().map(|p| plane(path, p)).collect::<Result<_, _>>()?;
    Ok(Contours { unit: text.unit, planes })
}

fn plane(path: &Path, text: PlaneText) -> Result<ContourPlane, ReadError> {
    let frame = PlaneFrame::new(Point3::from(text.origin), Vector3::from(text.normal));
    let Some(frame) = frame else {
        return Err(ReadError::damaged(
            path,
            Place::Plane(text.index),
            "the normal has no direction",
        ));
    };
    let curve = |(number, polyline): (usize, &PolylineText)| {
        let at = Place::Polyline { plane: text.index, number };
        curve(&frame, polyline).map_err(|problem| ReadError::damaged(path, at, problem))
    };
    let curves = text.polylines.iter().enumerate().map(curve).collect::<Result<_, _>>()?;
    Ok(ContourPlane { index: PlaneIndex(text.index), station: text.station, frame, curves })
}

fn curve(frame: &PlaneFrame, polyline: &PolylineText) -> Result<Curve, String> {
    let PolylineText { closed, points, sigma, views, bridged, ends } = polyline;
    for (key, length) in [("sigma", sigma.len()), ("views", views.len())] {
        if length != 0 && length != points.len() {
            return Err(format!("{length} values of {key} for {} points", points.len()));
        }
    }
    let node = |(i, point): (usize, &[f64; 3])| {
        let position: Point2 = frame.plane_from_world(&Point3::from(*point));
        let views = views.get(i).copied().unwrap_or(1);
        let sigma = sigma.get(i).copied().unwrap_or(0.0);
        Node::at(position).with_sigma(sigma).with_weight(views as f32).with_views(views)
    };
    let mut nodes: Vec<Node> = points.iter().enumerate().map(node).collect();
    for &k in bridged {
        let count = points.len();
        let node = nodes.get_mut(k);
        node.ok_or_else(|| format!("segment {k} is bridged, of {count} points"))?.bridged = true;
    }
    let curve = Curve::new(nodes, *closed).map_err(|e| e.to_string())?;
    Ok(curve.with_ends(*ends))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::{model, write_to_folder};
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Contours, ReadError> {
        let (_folder, path) = write_to_folder("contours.json", text.as_bytes());
        read_contours(&path)
    }

    proptest! {
        #[test]
        fn writing_and_reading_returns_the_curves(
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
            let back = read(std::str::from_utf8(&text).unwrap()).unwrap();
            prop_assert_eq!(back.planes[0].index, PlaneIndex(-2));
            let (frame, written) = (back.planes[0].frame, model.planes().frame(PlaneIndex(-2)));
            prop_assert_eq!(frame.origin(), written.origin());
            prop_assert!((frame.x_axis() - written.x_axis()).norm() < 1e-15);
            let read = &back.planes[0].curves[0];
            prop_assert_eq!((read.is_closed(), read.ends()), (closed, curve.ends()));
            for (a, b) in read.nodes().iter().zip(curve.nodes()) {
                // Micrometres survive five thousand kilometres from the origin.
                prop_assert!((a.position - b.position).norm() < 1e-8);
                let known = |n: &Node| (n.sigma, n.views, n.bridged);
                prop_assert_eq!(known(a), known(b));
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

    #[test]
    fn bad_polylines_are_named() {
        let with = |polyline: &str| {
            let head = r#"{"unit":"m","planes":[{"index":7,"origin":[0,0,0],"normal":[0,0,1],"#;
            let text = format!("{head}\"polylines\":[{polyline}]}}]}}");
            read(&text).unwrap_err().to_string()
        };
        let short = with(r#"{"closed":true,"points":[[0,0,0],[1,0,0]]}"#);
        assert!(
            short.ends_with("plane 7, polyline 0: 2 nodes cannot make a closed curve"),
            "{short}"
        );
        let uneven = with(r#"{"closed":false,"points":[[0,0,0],[1,0,0]],"sigma":[1]}"#);
        assert!(uneven.ends_with("1 values of sigma for 2 points"), "{uneven}");
        let not_json = read("{\"unit\": \"m\"").unwrap_err();
        assert!(std::error::Error::source(&not_json).unwrap().to_string().contains("line 1"));
    }
}
