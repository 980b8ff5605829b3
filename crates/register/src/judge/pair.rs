//! The evidence of one view about the patches of another view.

use crate::coarse::{CoarseView, Sighting};
use crate::tuning::MAX_INCIDENCE_DEGREES;
use transect_device::{Isometry3, Point3, Vector3};

/// Cosine of the largest angle between the normals of two patches of one surface. No unit. Chosen
/// by hand: 37 degrees, which bent surfaces turn within a patch. At half of it, patches on two
/// sides of a corner are compared.
pub(super) const ALIKE: f64 = 0.8;

/// Where a view is taken to be: its pose, and a factor on its lengths.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placing {
    pub world_from_sensor: Isometry3,
    /// 1, unless a wrong scale of the ranges is looked for.
    pub scale: f64,
}

impl Placing {
    pub fn given(view: &CoarseView) -> Self {
        Self { world_from_sensor: *view.world_from_sensor(), scale: 1.0 }
    }

    pub fn to_world(self, p: &Point3) -> Point3 {
        self.world_from_sensor * (p * self.scale)
    }

    fn to_sensor(self, p: &Point3) -> Point3 {
        self.world_from_sensor.inverse_transform_point(p) / self.scale
    }
}

/// A patch of a view, in its sensor frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Probe {
    /// The number of its cell.
    pub cell: usize,
    pub point: Point3,
    pub normal: Vector3,
    pub sigma: f64,
    pub radius: f64,
    /// Whether nearly every pixel of its cell has a sample.
    pub whole: bool,
}

/// Patches of a view, at most `count`, evenly over its image.
pub(crate) fn probes(view: &CoarseView, count: usize) -> Vec<Probe> {
    let all: Vec<Probe> = view
        .patches()
        .map(|(cell, patch)| Probe {
            cell,
            point: patch.point(),
            normal: patch.normal(),
            sigma: patch.sigma(),
            radius: patch.radius(),
            whole: view.is_whole(cell),
        })
        .collect();
    let count = count.min(all.len());
    (0..count).filter_map(|k| all.get(k * all.len() / count).copied()).collect()
}

/// A patch of one view, compared with what another view measured there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample {
    /// The cell of the patch, in its own view.
    pub cell: usize,
    /// The cell of the other view that it falls into.
    pub other_cell: usize,
    /// The patch's point in the world.
    pub point: Point3,
    /// Normal in the world: of the other surface if the patch meets one, else of the patch.
    pub normal: Vector3,
    /// Distance from the other surface along the normal, positive on the side of the other sensor.
    pub distance: f64,
    /// Standard deviation of the distance from noise alone.
    pub sigma: f64,
    /// Half the side of the patch, in the world.
    pub radius: f64,
    /// Whether the patch meets a surface with a like normal; otherwise the other view looks through
    /// it.
    pub met: bool,
    /// Whether both cells have a sample in nearly every pixel.
    pub whole: bool,
}

/// The patches about which a view says anything: they meet its surface within `reach` times their
/// radius, or the view looks through them.
pub(crate) fn samples(
    probes: &[Probe],
    own: Placing,
    other: &CoarseView,
    there: Placing,
    reach: f64,
) -> Vec<Sample> {
    probes.iter().filter_map(|p| sample(p, own, other, there, reach)).collect()
}

fn sample(
    probe: &Probe,
    own: Placing,
    other: &CoarseView,
    there: Placing,
    reach: f64,
) -> Option<Sample> {
    let point = own.to_world(&probe.point);
    let normal = own.world_from_sensor * probe.normal;
    let at = there.to_sensor(&point);
    let other_cell = other.cell_of(&at)?;
    let found = Sample {
        cell: probe.cell,
        other_cell,
        point,
        normal,
        distance: 0.0,
        sigma: probe.sigma * own.scale,
        radius: probe.radius * own.scale,
        met: false,
        whole: probe.whole && other.is_whole(other_cell),
    };
    let met = other.meeting_in(other_cell, &at).and_then(|m| {
        let there_normal = there.world_from_sensor * m.normal;
        let alike = there_normal.dot(&normal) > ALIKE;
        let near = m.distance.abs() * there.scale < reach * found.radius;
        (alike && near).then_some(Sample {
            normal: there_normal,
            distance: m.distance * there.scale,
            sigma: found.sigma.hypot(m.sigma * there.scale),
            met: true,
            ..found
        })
    });
    met.or_else(|| {
        let Sighting::InFront(depth) = other.sighting_in(other_cell, &at) else { return None };
        // Rays need not start in the origin of the sensor frame.
        let ray = there.world_from_sensor * other.ray(other_cell)?.direction;
        // A surface that is seen at a grazing angle ends anywhere between two pixels, so a point
        // beside its last sample contradicts nothing. Such surfaces make no patches, either.
        let incidence = ray.dot(&normal).abs();
        let seen = incidence >= MAX_INCIDENCE_DEGREES.to_radians().cos();
        seen.then_some(Sample { distance: depth * there.scale * incidence, ..found })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{
        DeviceFrame, DevicePoint, Handedness, ImageSize, Pixel, RangeImage, Ray, SensorPlane, View,
    };

    const SIZE: ImageSize = ImageSize { rows: 64, cols: 64 };

    /// Parallel rays along z, one for each centimetre, as of a light sheet that a slide carries.
    #[derive(Debug)]
    struct Parallel;

    impl DeviceFrame for Parallel {
        fn size(&self) -> ImageSize {
            SIZE
        }

        fn kind(&self) -> &'static str {
            "Parallel"
        }

        fn handedness(&self) -> Handedness {
            Handedness::ColumnsRight
        }

        fn ray(&self, pixel: Pixel) -> Option<Ray> {
            let start = Point3::new(0.01 * pixel.col as f64, 0.01 * pixel.row as f64, 0.0);
            Some(Ray { start, direction: Vector3::z() })
        }

        fn point(&self, pixel: Pixel, d3: f64) -> Option<Point3> {
            self.ray(pixel).map(|ray| ray.start + ray.direction * d3)
        }

        fn device_point(&self, p: &Point3) -> Option<DevicePoint> {
            Some(DevicePoint { row: 100.0 * p.y, col: 100.0 * p.x, d3: p.z })
        }

        fn plane_value(&self, _pixel: Pixel, _plane: &SensorPlane) -> Option<f64> {
            None
        }

        fn extent(&self, _direction: &Vector3, nearest: f64, farthest: f64) -> (f64, f64) {
            (nearest, farthest)
        }
    }

    #[test]
    fn free_space_is_measured_along_the_rays_of_the_device() {
        let image = RangeImage::from_values(SIZE, vec![1.0; SIZE.pixels()]).unwrap();
        let pose = Isometry3::identity();
        let view = View::new("plate", image, Arc::new(Parallel), pose, Some(1e-4)).unwrap();
        let view = CoarseView::new(&view);
        // A patch 0.4 m before the plate, whose point lies obliquely from the frame's origin.
        let probe = Probe {
            cell: 0,
            point: Point3::new(0.5, 0.5, 0.6),
            normal: -Vector3::z(),
            sigma: 1e-4,
            radius: 0.02,
            whole: true,
        };
        let there = Placing::given(&view);
        let found = sample(&probe, there, &view, there, 1.0).unwrap();
        assert!(!found.met && (found.distance - 0.4).abs() < 1e-6, "{found:?}");
    }
}
