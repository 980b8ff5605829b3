//! Points of structured scans: a range grid, or vertices with rows and columns or with rings.

use super::{Element, Ply, range_grid};
use crate::point_table::{Cloud, is_ring_name, ring};
use crate::{Place, ReadError};
use std::path::Path;
use transect_device::ImageSize;
use transect_geometry::Point3;

/// Reads the points of a scan. `obj_info num_rows` and `num_cols` state the grid of its vertices.
pub(crate) fn cloud(path: &Path, bytes: &[u8]) -> Result<Cloud, ReadError> {
    let mut ply = Ply::open(path, bytes)?;
    let is_carried = ply.header.info("is_cyberware_data") == Some(1);
    if ply.header.element("range_grid").is_some() {
        let grid = range_grid::range_grid(path, bytes)?;
        let (size, points, notes) = (Some(grid.size), grid.points, grid.notes);
        return Ok(Cloud { points, rings: None, size, is_carried, notes });
    }
    let elements = ply.header.elements.clone();
    if elements.iter().any(|e| e.name == "face" && e.count > 0) {
        let problem = "a triangle mesh, which has no rows and columns; expected the scans that the \
                       mesh was made from. To compare a model with this mesh, give it to \
                       the evaluation as the setting `reference`";
        return Err(ReadError::unsupported(path, Place::Whole, problem));
    }
    let info = |name| ply.header.info(name);
    let size = info("num_rows").zip(info("num_cols"));
    let size = size.map(|(rows, cols)| ImageSize { rows, cols });
    let mut cloud = Cloud { size, is_carried, ..Cloud::default() };
    for element in &elements {
        if element.name == "vertex" {
            (cloud.points, cloud.rings) = vertices(&mut ply, element)?;
        } else {
            ply.skip(element)?;
        }
    }
    if cloud.points.is_empty() {
        let problem = "no points; expected an element vertex with x, y and z";
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    ply.note_leftovers();
    cloud.notes = ply.header.notes;
    if elements.iter().any(|e| e.name == "camera") {
        cloud.notes.push("element camera ignored; the setting `poses` states the pose".to_owned());
    }
    Ok(cloud)
}

/// The points of an element, and their rings if it has a property for them.
fn vertices(
    ply: &mut Ply<'_>,
    element: &Element,
) -> Result<(Vec<Point3>, Option<Vec<u16>>), ReadError> {
    let Some(property) = element.properties.iter().find(|p| is_ring_name(&p.name)) else {
        return Ok((ply.points(element)?, None));
    };
    let count = ply.room_for(element)?;
    let (mut points, mut rings) = (Vec::with_capacity(count), Vec::with_capacity(count));
    ply.numbers(element, ["x", "y", "z", &property.name], |[x, y, z, number]| {
        points.push(Point3::new(x, y, z));
        rings.push(ring(number)?);
        Ok(())
    })?;
    Ok((points, Some(rings)))
}
