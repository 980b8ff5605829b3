//! The pose of a scanner from scans of the machine table and of spheres (dissertation, 4.7.1).

use crate::WorkflowError;
use std::path::{Path, PathBuf};
use transect_exchange::read_text;
use transect_geometry::{Point3, Vector3};
use transect_sensors::lookup_table::alignment::{Alignment, PlaneScan, SphereScan, Turning, align};

/// Scans of the table and of spheres: files with a point in the sensor frame per line.
#[derive(Debug, Clone, PartialEq)]
pub struct AlignmentScans {
    /// File of the points on the table.
    pub table: PathBuf,
    /// The table's normal in the world, and a point of it.
    pub table_in_world: [Vector3; 2],
    /// The spheres.
    pub spheres: Vec<SphereFile>,
    /// A direction that is known in the sensor and in the world, such as the machine's linear axis.
    /// Without it at least two spheres are needed.
    pub axis: Option<[Vector3; 2]>,
}

/// A scan of a sphere.
#[derive(Debug, Clone, PartialEq)]
pub struct SphereFile {
    /// File of the points on the sphere.
    pub path: PathBuf,
    /// Its centre in the world.
    pub center: Point3,
    /// Its radius.
    pub radius: f64,
}

impl AlignmentScans {
    /// The pose that lays the scanned points onto the table and the spheres.
    ///
    /// # Errors
    /// [`WorkflowError`] if a file cannot be read, or the scans leave a motion free.
    pub fn align(&self) -> Result<Alignment, WorkflowError> {
        let table = points(&self.table)?;
        let [normal_in_world, point] = self.table_in_world;
        let table =
            PlaneScan { points_in_sensor: &table, normal_in_world, point_in_world: point.into() };
        let scanned = self.spheres.iter().map(|sphere| points(&sphere.path));
        let scanned: Vec<Vec<Point3>> = scanned.collect::<Result<_, _>>()?;
        let sphere = |(sphere, points): (&SphereFile, _)| SphereScan {
            points_in_sensor: points,
            center_in_world: sphere.center,
            radius: sphere.radius,
        };
        let with_points = self.spheres.iter().zip(scanned.iter().map(Vec::as_slice));
        let spheres: Vec<SphereScan<'_>> = with_points.map(sphere).collect();
        let turning = match self.axis {
            Some([in_sensor, in_world]) => Turning::AboutAxis { in_sensor, in_world },
            None => Turning::Free,
        };
        Ok(align(&table, &spheres, turning)?)
    }
}

/// Three numbers per line, apart by commas or blanks; `#` begins a comment.
fn points(path: &Path) -> Result<Vec<Point3>, WorkflowError> {
    let text = read_text(path)?;
    let mut points = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let content = content.split('#').next().unwrap_or_default();
        let words = content.split([',', ' ', '\t', ';']).filter(|word| !word.is_empty());
        let numbers: Vec<Option<f64>> = words.map(|word| word.parse().ok()).collect();
        match numbers.as_slice() {
            [] => (),
            [Some(x), Some(y), Some(z)] => points.push(Point3::new(*x, *y, *z)),
            _ => {
                let problem = format!(
                    "line {}: found {:?}; expected three numbers, the point in the sensor frame",
                    line + 1,
                    content.trim()
                );
                return Err(WorkflowError::file(path, problem));
            }
        }
    }
    Ok(points)
}
