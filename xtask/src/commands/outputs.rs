//! The files a reconstruction leaves.

use crate::failure::Failure;
use crate::table::{Row, digits};
use rayon::prelude::*;
use std::path::Path;
use transect_exchange::svg::{OverviewOptions, Sheets, write_overview};
use transect_exchange::{
    DxfFrame, ModelSplines, WriteError, write_contours, write_dxf, write_file,
};
use transect_geometry::PlaneIndex;
use transect_model::Model;

/// In which frame the drawing's curves are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum DrawingFrame {
    /// 3D polylines where the curves are in the world.
    World,
    /// 2D polylines in the coordinates of their planes, stacked by station.
    Plane,
}

/// Writes model, contours, drawing, overview and sheets into a folder.
pub fn write(
    folder: &Path,
    name: &str,
    model: &Model,
    drawing: DrawingFrame,
) -> Result<(), Failure> {
    let frame = match drawing {
        DrawingFrame::World => DxfFrame::World,
        DrawingFrame::Plane => DxfFrame::Plane,
    };
    let sheets = folder.join("planes");
    // Sheets of planes that this model no longer has would be taken for part of it.
    remove_sheets(&sheets)?;
    std::fs::create_dir_all(&sheets).map_err(|e| Failure::with_file(&sheets, e))?;
    model.save(folder.join("model.transect"))?;
    write_file(&folder.join("contours.json"), |out| write_contours(model, out))?;
    write_file(&folder.join("model.dxf"), |out| write_dxf(model, frame, out))?;
    let mut options = OverviewOptions::default();
    options.title = name.to_owned();
    write_file(&folder.join("overview.svg"), |out| write_overview(model, &options, out))?;
    write_sheets(&sheets, model)?;
    Ok(())
}

/// Writes the curves as splines within a tolerance; the table's rows on them.
pub fn write_splines(folder: &Path, model: &Model, tolerance: f64) -> Result<Vec<Row>, Failure> {
    let splines = ModelSplines::fit(model, tolerance).map_err(|e| Failure::Usage(e.to_string()))?;
    write_file(&folder.join("splines.json"), |out| splines.write_json(out))?;
    write_file(&folder.join("splines.dxf"), |out| splines.write_dxf(out))?;
    let deviation = digits(splines.deviation());
    Ok(vec![
        Row::count("control points of splines", splines.control_count()),
        Row::new("splines within", deviation, model.unit().symbol()),
    ])
}

fn write_sheets(folder: &Path, model: &Model) -> Result<(), WriteError> {
    let sheets = Sheets::new(model);
    let planes: Vec<PlaneIndex> = model.sections().map(|(plane, _)| plane).collect();
    planes.par_iter().try_for_each(|&plane| {
        let file = folder.join(format!("plane_{:+05}.svg", plane.0));
        write_file(&file, |out| sheets.write(plane, out))
    })
}

fn remove_sheets(folder: &Path) -> Result<(), Failure> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for entry in entries.flatten() {
        let path = entry.path();
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.starts_with("plane_") && name.ends_with(".svg") {
            std::fs::remove_file(&path).map_err(|e| Failure::with_file(&path, e))?;
        }
    }
    Ok(())
}
