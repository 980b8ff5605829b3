//! SPLINE entities, which drawings have from AutoCAD release 13 on: DXF of release 2000 (AC1015).
//!
//! Later releases refuse a drawing of entities alone. Each table must be there, every object needs
//! a handle and an owner, and model and paper space need their blocks and records (Autodesk, DXF
//! reference). `drawing.txt` holds all that does not depend on the model.

use super::{ModelSplines, PlaneSplines};
use crate::dxf_groups::{Groups, layer_colour, layer_name, unit_values};
use std::io::{self, Write};
use transect_geometry::CubicSpline;

const TEMPLATE: &str = include_str!("drawing.txt");

/// Handles in the template: the table of layers, and model space, which owns the splines.
const LAYER_TABLE: u64 = 0x3;
const MODEL_SPACE: u64 = 0x1F;
/// The first handle that the template does not use. Layers come first, then splines.
const FIRST_FREE: u64 = 0x100;

/// Flags of group 70.
const CLOSED: i64 = 1;
const PLANAR: i64 = 8;

impl ModelSplines {
    /// Writes a drawing of all splines in world coordinates, one layer per plane.
    ///
    /// # Errors
    /// An error of `out`.
    pub fn write_dxf(&self, out: &mut dyn Write) -> io::Result<()> {
        let splines: usize = self.curves().map(|c| c.pieces.len()).sum();
        let next_handle = FIRST_FREE + (self.planes.len() + splines) as u64;
        let mut values = unit_values(self.unit).to_vec();
        values.push(("next_handle", format!("{next_handle:X}")));
        values.push(("layer_count", format!("{}", 1 + self.planes.len())));
        let mut handles = FIRST_FREE..;
        Groups { out }.template(TEMPLATE, &values, |groups, mark| match mark {
            "layers" => self
                .planes
                .iter()
                .zip(&mut handles)
                .try_for_each(|(plane, handle)| write_layer(groups, plane, handle)),
            _ => self.write_splines(groups, &mut handles),
        })
    }

    fn write_splines(
        &self,
        groups: &mut Groups<'_>,
        handles: &mut impl Iterator<Item = u64>,
    ) -> io::Result<()> {
        for plane in &self.planes {
            for curve in &plane.curves {
                let ring = curve.closed && curve.pieces.len() == 1;
                for (piece, handle) in curve.pieces.iter().zip(&mut *handles) {
                    groups.text(0, "SPLINE")?;
                    groups.handle(5, handle)?;
                    write_spline(groups, plane, piece, ring)?;
                }
            }
        }
        Ok(())
    }
}

fn write_layer(groups: &mut Groups<'_>, plane: &PlaneSplines, handle: u64) -> io::Result<()> {
    groups.text(0, "LAYER")?;
    groups.handle(5, handle)?;
    groups.handle(330, LAYER_TABLE)?;
    groups.text(100, "AcDbSymbolTableRecord")?;
    groups.text(100, "AcDbLayerTableRecord")?;
    groups.text(2, &layer_name(plane.index))?;
    groups.integer(70, 0)?;
    groups.integer(62, layer_colour(plane.index))?;
    groups.text(6, "Continuous")
}

fn write_spline(
    groups: &mut Groups<'_>,
    plane: &PlaneSplines,
    piece: &CubicSpline,
    ring: bool,
) -> io::Result<()> {
    groups.handle(330, MODEL_SPACE)?;
    groups.text(100, "AcDbEntity")?;
    groups.text(8, &layer_name(plane.index))?;
    groups.text(100, "AcDbSpline")?;
    let normal = plane.frame.normal();
    groups.number(210, normal.x)?;
    groups.number(220, normal.y)?;
    groups.number(230, normal.z)?;
    groups.integer(70, PLANAR + if ring { CLOSED } else { 0 })?;
    groups.integer(71, 3)?;
    groups.integer(72, piece.knots().len() as i64)?;
    groups.integer(73, piece.controls().len() as i64)?;
    groups.integer(74, 0)?;
    piece.knots().iter().try_for_each(|knot| groups.number(40, *knot))?;
    let control = |control| groups.point(&plane.frame.world_from_plane(control));
    piece.controls().iter().try_for_each(control)
}
