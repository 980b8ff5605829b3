//! The evidence of one view about the patches of another view.

use crate::coarse::CoarseView;
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

/// A view, and where it is taken to be.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed<'a> {
    pub view: &'a CoarseView,
    pub at: Placing,
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
    /// Negative without a meeting: the view of the patch looks through the other surface.
    pub distance: f64,
    /// Standard deviation of the distance from noise alone.
    pub sigma: f64,
    /// Half the side of the patch, in the world.
    pub radius: f64,
    /// Whether the patch meets a surface with a like normal; otherwise the other view looks through
    /// it, or its own view through what the other saw.
    pub met: bool,
    /// Whether both cells have a sample in nearly every pixel.
    pub whole: bool,
}

/// The patches about which two views say anything: they meet the other's surface within `reach`
/// times their radius, the other view looks through them, or their own view looks through the
/// other's surface.
pub(crate) fn samples(
    probes: &[Probe],
    own: Placed<'_>,
    other: Placed<'_>,
    reach: f64,
) -> Vec<Sample> {
    probes.iter().filter_map(|p| sample(p, own, other, reach)).collect()
}

fn sample(probe: &Probe, own: Placed<'_>, other: Placed<'_>, reach: f64) -> Option<Sample> {
    let point = own.at.to_world(&probe.point);
    let normal = own.at.world_from_sensor * probe.normal;
    let at = other.at.to_sensor(&point);
    let other_cell = other.view.cell_of(&at)?;
    let found = Sample {
        cell: probe.cell,
        other_cell,
        point,
        normal,
        distance: 0.0,
        sigma: probe.sigma * own.at.scale,
        radius: probe.radius * own.at.scale,
        met: false,
        whole: probe.whole && other.view.is_whole(other_cell),
    };
    let alike = other.view.meeting_in(other_cell, &at).and_then(|m| {
        let normal = other.at.world_from_sensor * m.normal;
        let sigma = found.sigma.hypot(m.sigma * other.at.scale);
        let distance = m.distance * other.at.scale;
        (normal.dot(&found.normal) > ALIKE).then_some(Sample { normal, distance, sigma, ..found })
    });
    match alike {
        Some(alike) if alike.distance.abs() < reach * found.radius => {
            Some(Sample { met: true, ..alike })
        }
        Some(alike) if alike.distance < 0.0 => {
            // The place on the other's surface that lies before the patch.
            let before = point - alike.normal * alike.distance;
            let there = other.view.meeting(&other.at.to_sensor(&before))?;
            let depth = free_before(own, &before, &normal)?;
            let is_there = there.distance.abs() * other.at.scale < found.radius;
            is_there.then_some(Sample { distance: -depth, ..found })
        }
        _ => Some(Sample { distance: free_before(other, &point, &normal)?, ..found }),
    }
}

/// How far a place on a surface with this normal is in front of what a view saw there, along the
/// normal; `None` if the view did not look through it.
fn free_before(through: Placed<'_>, place: &Point3, normal: &Vector3) -> Option<f64> {
    let in_sensor = through.at.to_sensor(place);
    let cell = through.view.cell_of(&in_sensor)?;
    let depth = through.view.free_in_front(cell, &in_sensor)?;
    // Rays need not start in the origin of the sensor frame.
    let ray = through.at.world_from_sensor * through.view.ray(cell)?.direction;
    // A surface that is seen at a grazing angle ends anywhere between two pixels, so a point beside
    // its last sample contradicts nothing. Such surfaces make no patches, either.
    let incidence = ray.dot(normal).abs();
    let seen = incidence >= MAX_INCIDENCE_DEGREES.to_radians().cos();
    seen.then_some(depth * through.at.scale * incidence)
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
        let there = Placed { view: &view, at: Placing::given(&view) };
        let found = sample(&probe, there, there, 1.0).unwrap();
        assert!(!found.met && (found.distance - 0.4).abs() < 1e-6, "{found:?}");
    }
}
