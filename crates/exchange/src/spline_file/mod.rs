//! A model's curves as B-splines: `splines.json` and, in `dxf.rs`, a drawing.
//!
//! ```json
//! { "unit": "m", "tolerance": 0.001, "planes": [ { "index": 3, "station": 0.2,
//!     "origin": [0, 0, 0.2], "x_axis": [1, 0, 0], "y_axis": [0, 1, 0],
//!     "curves": [ { "closed": true, "deviation": 0.0004, "pieces": [
//!         { "degree": 3, "knots": [0, 0, 0, 0, 1, 1, 1, 1], "controls": [[0, 0], [1, 0], [2, 1], [2, 2]] } ] } ] } ] }
//! ```
//!
//! Control points are in plane coordinates: `origin + x · x_axis + y · y_axis` in the world. A
//! curve's pieces follow each other; they meet at its corners. `deviation` is their largest
//! distance from the curve of nodes, which remains the model: see
//! [`transect_geometry::fit_splines`].

mod dxf;

use serde::Serialize;
use std::io::{self, Write};
use transect_geometry::{
    CubicSpline, CurveSplines, LengthUnit, PlaneFrame, PlaneIndex, SplineError, fit_splines,
};
use transect_model::Model;

/// The splines of a model's curves.
#[derive(Debug, Clone)]
pub struct ModelSplines {
    unit: LengthUnit,
    tolerance: f64,
    planes: Vec<PlaneSplines>,
}

#[derive(Debug, Clone)]
struct PlaneSplines {
    index: PlaneIndex,
    station: f64,
    frame: PlaneFrame,
    curves: Vec<CurveSplines>,
}

#[derive(Serialize)]
struct PlaneText<'a> {
    index: i64,
    station: f64,
    origin: [f64; 3],
    x_axis: [f64; 3],
    y_axis: [f64; 3],
    curves: Vec<CurveText<'a>>,
}

#[derive(Serialize)]
struct CurveText<'a> {
    closed: bool,
    deviation: f64,
    pieces: Vec<PieceText<'a>>,
}

#[derive(Serialize)]
struct PieceText<'a> {
    degree: u32,
    knots: &'a [f64],
    controls: Vec<[f64; 2]>,
}

impl ModelSplines {
    /// Describes every curve of a model by splines within a tolerance, in the model's length unit.
    ///
    /// # Errors
    /// [`SplineError`] if the tolerance is no positive length.
    pub fn fit(model: &Model, tolerance: f64) -> Result<Self, SplineError> {
        let plane = |(index, section): (PlaneIndex, &transect_model::Section)| {
            let curves = section.curves().map(|curve| fit_splines(curve, tolerance));
            Ok(PlaneSplines {
                index,
                station: model.planes().station(index),
                frame: model.planes().frame(index),
                curves: curves.collect::<Result<_, _>>()?,
            })
        };
        let planes = model.sections().map(plane).collect::<Result<_, _>>()?;
        Ok(Self { unit: model.unit(), tolerance, planes })
    }

    /// Number of control points of all splines.
    pub fn control_count(&self) -> usize {
        self.curves().flat_map(|c| &c.pieces).map(|piece| piece.controls().len()).sum()
    }

    /// Largest distance between a spline and its curve, in the model's length unit.
    pub fn deviation(&self) -> f64 {
        self.curves().map(|curve| curve.deviation).fold(0.0, f64::max)
    }

    fn curves(&self) -> impl Iterator<Item = &CurveSplines> {
        self.planes.iter().flat_map(|plane| &plane.curves)
    }

    /// Writes `splines.json`, one plane per line.
    ///
    /// # Errors
    /// An error of `out`.
    pub fn write_json(&self, out: &mut dyn Write) -> io::Result<()> {
        let tolerance = serde_json::to_string(&self.tolerance)?;
        write!(out, "{{\"unit\":\"{}\",\"tolerance\":{tolerance},\"planes\":[", self.unit)?;
        for (number, plane) in self.planes.iter().enumerate() {
            let separator = if number > 0 { "," } else { "" };
            write!(out, "{separator}\n{}", serde_json::to_string(&plane.text())?)?;
        }
        writeln!(out, "\n]}}")
    }
}

impl PlaneSplines {
    fn text(&self) -> PlaneText<'_> {
        PlaneText {
            index: self.index.0,
            station: self.station,
            origin: self.frame.origin().coords.into(),
            x_axis: self.frame.x_axis().into(),
            // A negative zero becomes a plain one.
            y_axis: self.frame.y_axis().map(|c| c + 0.0).into(),
            curves: self.curves.iter().map(curve_text).collect(),
        }
    }
}

fn curve_text(curve: &CurveSplines) -> CurveText<'_> {
    let piece = |piece: &'_ CubicSpline| -> Vec<[f64; 2]> {
        piece.controls().iter().map(|c| [c.x, c.y]).collect()
    };
    let text = |p| PieceText { degree: 3, knots: CubicSpline::knots(p), controls: piece(p) };
    let pieces = curve.pieces.iter().map(text).collect();
    CurveText { closed: curve.closed, deviation: curve.deviation, pieces }
}

#[cfg(test)]
mod tests;
