//! The places of simulated sensors: the scene's own stations, which any sensor can take.
//!
//! 1. View k has the place and the direction of the scene's station k mod M of M. Each further
//!    round is turned about the vertical by the golden angle, so that no two views look the same
//!    way. A station outside turns about the scene's middle, a station inside turns on the spot.
//! 2. A sensor with a bounded field (triangulation scanner) is scaled as a whole and moved along
//!    its direction. Outside, its field then holds the object. Inside a scene it moves a quarter of
//!    the way to the first surface ahead, since stations stand in corners. There it is as large as
//!    the free space allows, but does not reach beyond that surface.
//! 3. A sensor whose field is a cone gets the angle that holds the object, or a wide angle inside.

use nalgebra::{Rotation3, Translation3, UnitQuaternion};
use std::f64::consts::PI;
use transect_device::Ray;
use transect_geometry::{Isometry3, Point3, Vector3};
use transect_scene::{Description, Mesh, Scene, SensorParameters, Station};

/// Turn from one round of views to the next: π (3 − √5), the golden angle.
fn golden_angle() -> f64 {
    PI * (3.0 - 5_f64.sqrt())
}

/// Share of the way to the first surface ahead that a sensor with a bounded field moves inside a
/// scene. Chosen by hand: it leaves the corner. Doubled, sensors stand halfway to the surface and
/// see less of it.
const ADVANCE_SHARE: f64 = 0.25;

/// Share of the free space around it that a sensor fills inside a scene. Chosen by hand; above 1
/// the instrument would reach into a surface.
const FILL_SHARE: f64 = 0.8;

/// Size of the field of a sensor outside, as a multiple of the object's size. Chosen by hand; below
/// 1 parts of the object are outside the field, doubled the object has a quarter of the pixels.
const FIELD_MARGIN: f64 = 1.05;

/// The ball and the box around the surface of a scene.
#[derive(Debug, Clone, Copy)]
pub struct SceneBounds {
    middle: Point3,
    radius: f64,
    low: Point3,
    high: Point3,
}

impl SceneBounds {
    /// The bounds of a surface.
    pub fn of(surface: &Mesh) -> Self {
        let start = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
        let (low, high) =
            surface.vertices.iter().fold(start, |(low, high), v| (low.inf(v), high.sup(v)));
        let middle = nalgebra::center(&low, &high);
        let distances = surface.vertices.iter().map(|v| (v - middle).norm());
        Self { middle, radius: distances.fold(0.0, f64::max), low, high }
    }

    /// Longest side of the box around everything.
    pub fn size(&self) -> f64 {
        (self.high - self.low).max()
    }

    fn contains(&self, p: &Point3) -> bool {
        *p >= self.low && *p <= self.high
    }
}

/// The bounded field of a triangulation scanner, in its sensor frame, z forward.
#[derive(Debug, Clone, Copy)]
pub struct BoundedField {
    /// Its middle.
    pub middle: Point3,
    /// Radius of the ball around the middle that fits into it.
    pub radius: f64,
    /// Radius of the instrument around the sensor frame's origin.
    pub size: f64,
}

/// A place with the directions forward and up: unit vectors at right angles.
#[derive(Debug, Clone, Copy)]
pub struct Standpoint {
    position: Point3,
    forward: Vector3,
    up: Vector3,
    /// Middle and radius of the object seen from outside; `None` inside a scene.
    object: Option<(Point3, f64)>,
    /// Distance of the first surface ahead.
    reach: f64,
    /// Distance of the nearest surface at the sides of the advanced place ([`ADVANCE_SHARE`]).
    free: f64,
}

impl Standpoint {
    /// A scene's station after a rigid motion of it.
    pub fn of(station: &Station, turned: &Isometry3, scene: &Scene, bounds: &SceneBounds) -> Self {
        let world_from_sensor = turned * station.world_from_sensor;
        let (forward, up) = axes(station);
        let position = Point3::from(world_from_sensor.translation.vector);
        let (forward, up) = (world_from_sensor * forward, world_from_sensor * up);
        let outside = !bounds.contains(&position);
        let distance = |start: Point3, direction: Vector3| {
            let hit = scene.hit(&Ray { start, direction }).map(|h| h.distance);
            hit.filter(|d| *d > 0.0).unwrap_or(bounds.radius)
        };
        let reach = distance(position, forward);
        let there = position + forward * (ADVANCE_SHARE * reach);
        let side = forward.cross(&up);
        let sides = (0..8).map(|k| (PI / 4.0 * f64::from(k)).sin_cos());
        let free = sides.map(|(sin, cos)| distance(there, side * cos + up * sin));
        Self {
            position,
            forward,
            up,
            object: outside.then_some((bounds.middle, bounds.radius)),
            reach,
            free: free.fold(f64::INFINITY, f64::min),
        }
    }

    /// Half the angle, in radians, under which the object is seen; `None` inside a scene.
    pub fn half_angle(&self) -> Option<f64> {
        let (middle, radius) = self.object?;
        Some((FIELD_MARGIN * radius / (middle - self.position).norm()).min(0.9).asin())
    }

    /// The factor by which a sensor with this field is enlarged.
    pub fn scale(&self, field: &BoundedField) -> f64 {
        match self.object {
            Some((_, radius)) => FIELD_MARGIN * radius / field.radius,
            None => {
                let reaching = (1.0 - ADVANCE_SHARE) * self.reach / field.middle.coords.norm();
                reaching.min(FILL_SHARE * self.free / field.size)
            }
        }
    }

    /// The pose of a sensor of that scale. Its frame has z forward, y down and x right.
    pub fn place_field(&self, field: &BoundedField, scale: f64) -> Isometry3 {
        let rotation = self.rotation([self.forward.cross(&self.up), -self.up, self.forward]);
        let offset = rotation * (field.middle.coords * scale);
        let target = match self.object {
            Some((middle, _)) => middle,
            None => self.position + self.forward * (ADVANCE_SHARE * self.reach) + offset,
        };
        Isometry3::from_parts(Translation3::from(target - offset), rotation)
    }

    /// The pose of a camera: z forward, y down and x right.
    pub fn place_camera(&self) -> Isometry3 {
        let rotation = self.rotation([self.forward.cross(&self.up), -self.up, self.forward]);
        Isometry3::from_parts(Translation3::from(self.position), rotation)
    }

    /// The pose of a scanner: x forward, z up and y left.
    pub fn place_scanner(&self) -> Isometry3 {
        let rotation = self.rotation([self.forward, self.up.cross(&self.forward), self.up]);
        Isometry3::from_parts(Translation3::from(self.position), rotation)
    }

    fn rotation(&self, columns: [Vector3; 3]) -> UnitQuaternion<f64> {
        UnitQuaternion::from_rotation_matrix(&Rotation3::from_basis_unchecked(&columns))
    }
}

/// Direction through the middle of a station's image, and upwards in it, in the sensor's frame.
fn axes(station: &Station) -> (Vector3, Vector3) {
    let middle = |pixels: usize| 0.5 * (pixels as f64 - 1.0);
    match station.sensor {
        SensorParameters::Pinhole { .. }
        | SensorParameters::LightStripe(_)
        | SensorParameters::LookupTable(_) => (Vector3::z(), -Vector3::y()),
        SensorParameters::Spherical { theta0, dtheta, phi0, dphi } => {
            let (sin, cos) = (theta0 + dtheta * middle(station.size.cols)).sin_cos();
            let (sin_up, cos_up) = (phi0 + dphi * middle(station.size.rows)).sin_cos();
            (
                Vector3::new(cos_up * cos, cos_up * sin, sin_up),
                Vector3::new(-sin_up * cos, -sin_up * sin, cos_up),
            )
        }
    }
}

/// The number of the station that a view takes, and its rigid motion from there.
pub fn station_of_view(
    description: &Description,
    bounds: &SceneBounds,
    view: usize,
) -> (usize, Isometry3) {
    let stations = &description.stations;
    let own = view % stations.len().max(1);
    let turn = golden_angle() * (view / stations.len().max(1)) as f64;
    let Some(station) = stations.get(own).filter(|_| turn != 0.0) else {
        return (own, Isometry3::identity());
    };
    let position = Point3::from(station.world_from_sensor.translation.vector);
    let pivot = if bounds.contains(&position) { position } else { bounds.middle };
    let rotation = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), turn);
    let shift = pivot.coords - rotation * pivot.coords;
    (own, Isometry3::from_parts(Translation3::from(shift), rotation))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn room() -> (Description, Scene, SceneBounds) {
        let description = Description::parse(transect_scene::BUNDLED_ROOM).unwrap();
        let scene = description.scene();
        let bounds = SceneBounds::of(&scene.mesh(0.01).unwrap());
        (description, scene, bounds)
    }

    #[test]
    fn views_beyond_the_scenes_own_are_turned_on_the_spot_inside() {
        let (description, scene, bounds) = room();
        assert_eq!(station_of_view(&description, &bounds, 2), (2, Isometry3::identity()));
        let (own, turned) = station_of_view(&description, &bounds, 6);
        let station = &description.stations[own];
        let first = Standpoint::of(station, &Isometry3::identity(), &scene, &bounds);
        let again = Standpoint::of(station, &turned, &scene, &bounds);
        assert_eq!(own, 2);
        assert!((first.position - again.position).norm() < 1e-12);
        assert!((first.forward.angle(&again.forward) - golden_angle()).abs() < 0.2);
        assert!(first.half_angle().is_none(), "inside");
    }

    #[test]
    fn a_bounded_sensor_fits_into_a_corner() {
        let (description, scene, bounds) = room();
        let station = &description.stations[0];
        let stand = Standpoint::of(station, &Isometry3::identity(), &scene, &bounds);
        let field = BoundedField { middle: Point3::new(0.0, 0.0, 7.0), radius: 1.0, size: 3.0 };
        let scale = stand.scale(&field);
        let pose = stand.place_field(&field, scale);
        for side in [Vector3::x(), -Vector3::x(), Vector3::y(), -Vector3::y()] {
            let rim = pose * Point3::from(side * (field.size * scale));
            assert!(!scene.contains(&rim) && bounds.contains(&rim), "{rim}");
        }
    }

    #[test]
    fn a_bounded_field_is_put_around_the_object() {
        let description = Description::parse(transect_scene::BUNDLED_SCENES[2].1).unwrap();
        let scene = description.scene();
        let bounds = SceneBounds::of(&scene.mesh(0.1).unwrap());
        let (own, turned) = station_of_view(&description, &bounds, 0);
        let stand = Standpoint::of(&description.stations[own], &turned, &scene, &bounds);
        let field = BoundedField { middle: Point3::new(1.0, 2.0, 50.0), radius: 10.0, size: 5.0 };
        let scale = stand.scale(&field);
        assert!((scale * field.radius / bounds.radius - FIELD_MARGIN).abs() < 1e-12);
        let pose = stand.place_field(&field, scale);
        let middle = pose * Point3::from(field.middle.coords * scale);
        assert!((middle - bounds.middle).norm() < 1e-9);
        assert!(((pose * Vector3::z()) - stand.forward).norm() < 1e-12);
        assert!((pose * Vector3::y()).z < 0.0, "rows run down");
    }
}
