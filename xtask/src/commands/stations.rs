//! Device frames of simulated stations.

use std::sync::Arc;
use transect_device::{DeviceFrame, Isometry3};
use transect_exchange::{SensorEntry, ViewEntry, row_major};
use transect_scene::{SensorParameters, Station};
use transect_sensors::{AngularScan, ImagingRadar, Intrinsics, Pinhole, SensorError};

/// The device frame of a station.
pub fn frame(station: &Station) -> Result<Arc<dyn DeviceFrame>, SensorError> {
    Ok(match station.sensor {
        SensorParameters::Spherical { theta0, dtheta, phi0, dphi } => {
            let (theta, phi) =
                (AngularScan::from_radians(theta0, dtheta), AngularScan::from_radians(phi0, dphi));
            Arc::new(ImagingRadar::new(station.size, theta, phi)?)
        }
        SensorParameters::Pinhole { fx, fy, cx, cy } => {
            Arc::new(Pinhole::new(station.size, Intrinsics { fx, fy, cx, cy })?)
        }
    })
}

/// The manifest entry of a station's image, with the pose that the scan states.
pub fn entry(station: &Station, world_from_sensor: &Isometry3, file: String) -> ViewEntry {
    let sensor = match station.sensor {
        SensorParameters::Spherical { theta0, dtheta, phi0, dphi } => {
            SensorEntry::Spherical { theta0, dtheta, phi0, dphi }
        }
        SensorParameters::Pinhole { fx, fy, cx, cy } => SensorEntry::Pinhole { fx, fy, cx, cy },
    };
    ViewEntry {
        file,
        sensor,
        rows: Some(station.size.rows),
        cols: Some(station.size.cols),
        depth_scale: None,
        pose: row_major(world_from_sensor),
    }
}
