//! Raw lidar points: `x y z intensity` as 32-bit floats (KITTI, `*.bin`), or with the laser as a
//! fifth float (nuScenes, `*.pcd.bin`). The files have no header.

use crate::Place;
use crate::error::Problem;
use crate::point_table::{Cloud, ring};
use crate::scalar::Scalar;
use std::path::Path;
use transect_geometry::Point3;

/// Reads all points. The name tells the two layouts apart.
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Cloud, Problem> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let has_ring = name.ends_with(".pcd.bin");
    let floats = if has_ring { 5 } else { 4 };
    let record = floats * Scalar::F32.size();
    if bytes.is_empty() || !bytes.len().is_multiple_of(record) {
        let length = bytes.len();
        return Err(Problem::damaged(format!(
            "the file has {length} bytes; expected a multiple of {record}: {floats} 32-bit floats \
             per point. Name files of 5 floats *.pcd.bin, others *.bin"
        )));
    }
    let mut cloud = Cloud::default();
    let mut rings = Vec::new();
    for (number, record) in bytes.chunks_exact(record).enumerate() {
        let float = |at: usize| {
            let bytes = record.get(at * Scalar::F32.size()..).unwrap_or_default();
            Scalar::F32.read(bytes, false).unwrap_or(f64::NAN)
        };
        cloud.points.push(Point3::new(float(0), float(1), float(2)));
        if has_ring {
            let at = Place::Element { kind: "point".to_owned(), number, line: None };
            rings.push(ring(float(4)).map_err(|problem| Problem::at(at, problem))?);
        }
    }
    cloud.rings = has_ring.then_some(rings);
    Ok(cloud)
}
