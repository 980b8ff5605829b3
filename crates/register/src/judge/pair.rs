//! What one view says about the patches of another view.

use crate::coarse::{CoarseView, Sighting};
use transect_device::{Isometry3, Point3, Vector3};

/// Cosine of the largest angle between the normals of two patches of one surface. No unit. Chosen
/// by hand: 37 degrees, which bent surfaces turn within a patch. At half of it, patches on two
/// sides of a corner are compared.
const ALIKE: f64 = 0.8;

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
    /// Half the side of the patch.
    pub radius: f64,
    /// Whether the patch meets a surface with a like normal; otherwise the other view looks through
    /// it.
    pub met: bool,
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
        sigma: probe.sigma,
        radius: probe.radius,
        met: false,
    };
    let met = other.meeting(&at).and_then(|m| {
        let there_normal = there.world_from_sensor * m.normal;
        let alike = there_normal.dot(&normal) > ALIKE;
        let near = m.distance.abs() * there.scale < reach * probe.radius;
        (alike && near).then_some(Sample {
            normal: there_normal,
            distance: m.distance * there.scale,
            sigma: probe.sigma.hypot(m.sigma),
            met: true,
            ..found
        })
    });
    met.or_else(|| {
        let Sighting::InFront(depth) = other.sighting(&at) else { return None };
        // Rays need not start in the origin of the sensor frame.
        let ray = there.world_from_sensor * other.ray(other_cell)?.direction;
        Some(Sample { distance: depth * there.scale * ray.dot(&normal).abs(), ..found })
    })
}
