//! Views of analytic solids through every kind of sensor that has an inverse mapping.

use proptest::prelude::*;
use std::sync::{Arc, OnceLock};
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, Pixel, Point3, RangeImage, Vector3, View,
};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_sensors::lookup_table::LinearSteps;
use transect_sensors::{
    AngularScan, ImagingRadar, Intrinsics, LaserAngles, LightStripe, LightStripeParameters,
    LookupTable, Pinhole, PinholeScale, RayTable,
};

pub const SIZE: ImageSize = ImageSize { rows: 48, cols: 64 };

/// How far the middle of the scene is from the sensor, in the units of a scene.
pub const DISTANCE: f64 = 5.0;

/// A solid in the world, known by its signed distance: negative inside.
#[derive(Debug, Clone, Copy)]
pub enum Solid {
    Ball {
        centre: Point3,
        radius: f64,
    },
    /// Without ends.
    Cylinder {
        on_axis: Point3,
        axis: Vector3,
        radius: f64,
    },
    /// Everything outside a cylinder: a room seen from inside.
    Room {
        on_axis: Point3,
        axis: Vector3,
        radius: f64,
    },
    Torus {
        centre: Point3,
        axis: Vector3,
        radius: f64,
        tube: f64,
    },
    /// Everything below a plane.
    Ground {
        on_plane: Point3,
        normal: Vector3,
    },
}

impl Solid {
    pub fn distance(&self, p: &Point3) -> f64 {
        let off_axis = |from: &Point3, axis: &Vector3| {
            let d = p - from;
            (d - axis * d.dot(axis)).norm()
        };
        match self {
            Self::Ball { centre, radius } => (p - centre).norm() - radius,
            Self::Cylinder { on_axis, axis, radius } => off_axis(on_axis, axis) - radius,
            Self::Room { on_axis, axis, radius } => radius - off_axis(on_axis, axis),
            Self::Torus { centre, axis, radius, tube } => {
                let height = (p - centre).dot(axis);
                (off_axis(centre, axis) - radius).hypot(height) - tube
            }
            Self::Ground { on_plane, normal } => (p - on_plane).dot(normal),
        }
    }
}

/// Signed distance from the union of solids.
pub fn distance(solids: &[Solid], p: &Point3) -> f64 {
    solids.iter().map(|s| s.distance(p)).fold(f64::INFINITY, f64::min)
}

/// Outward normal of the union at a point, by finite differences.
pub fn normal(solids: &[Solid], p: &Point3) -> Vector3 {
    let step = 1e-6;
    let slope =
        |axis: Vector3| distance(solids, &(p + axis * step)) - distance(solids, &(p - axis * step));
    Vector3::new(slope(Vector3::x()), slope(Vector3::y()), slope(Vector3::z())).normalize()
}

/// Range along a ray to the first solid, by steps of the distance: no step passes a surface.
fn hit(solids: &[Solid], from: &Point3, direction: &Vector3) -> Option<f64> {
    let mut range = 0.0;
    for _ in 0..2000 {
        let free = distance(solids, &(from + direction * range));
        range += free;
        if free < 1e-12 {
            return Some(range);
        }
        if range > 1e4 {
            break;
        }
    }
    None
}

/// What a sensor sees; pixels for which `dropped` is true are missing.
pub fn look(
    frame: Arc<dyn DeviceFrame>,
    world_from_sensor: Isometry3,
    solids: &[Solid],
    dropped: impl Fn(Pixel) -> bool,
) -> Option<View> {
    look_with_noise(frame, world_from_sensor, solids, dropped, |_| 0.0)
}

/// The same with an error added to each range.
pub fn look_with_noise(
    frame: Arc<dyn DeviceFrame>,
    world_from_sensor: Isometry3,
    solids: &[Solid],
    dropped: impl Fn(Pixel) -> bool,
    noise: impl Fn(Pixel) -> f64,
) -> Option<View> {
    let value = |pixel: Pixel| {
        let ray = frame.ray(pixel).filter(|_| !dropped(pixel))?;
        let from = world_from_sensor * ray.start;
        let range = hit(solids, &from, &(world_from_sensor * ray.direction))? + noise(pixel);
        Some(frame.device_point(&(ray.start + ray.direction * range))?.d3 as f32)
    };
    let size = frame.size();
    let pixels = size.all_pixels();
    let values = pixels.map(|p| value(p).unwrap_or(f32::NAN)).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    View::new("solids", image, frame, world_from_sensor, Some(0.0)).ok()
}

/// A sensor and how many of its length units are one unit of a scene.
#[derive(Debug, Clone)]
pub struct Rig {
    pub frame: Arc<dyn DeviceFrame>,
    pub scale: f64,
}

impl Rig {
    fn new(frame: impl DeviceFrame + 'static, scale: f64) -> Self {
        Self { frame: Arc::new(frame), scale }
    }

    fn middle(&self) -> Pixel {
        let size = self.frame.size();
        Pixel::new(size.rows / 2, size.cols / 2)
    }

    /// The middle of the scene in the sensor frame.
    fn aim(&self) -> Point3 {
        let ray = self.frame.ray(self.middle()).unwrap();
        ray.start + ray.direction * (DISTANCE * self.scale)
    }

    /// A pose that puts the middle of the scene at the world's origin, turned by a rotation vector.
    pub fn pose(&self, turn: Vector3) -> Isometry3 {
        let rotation = nalgebra::UnitQuaternion::from_scaled_axis(turn);
        let offset = rotation * self.aim().coords;
        Isometry3::from_parts((-offset).into(), rotation)
    }

    /// The direction in which the sensor looks, in the world.
    pub fn line_of_sight(&self, pose: &Isometry3) -> Vector3 {
        pose * self.frame.ray(self.middle()).unwrap().direction
    }

    /// Larger of the distances between neighbouring samples in the middle of the scene.
    pub fn pixel(&self) -> f64 {
        let at = |rows: usize, cols: usize| {
            let p = self.middle();
            let ray = self.frame.ray(Pixel::new(p.row + rows, p.col + cols)).unwrap();
            ray.start + ray.direction * (DISTANCE * self.scale)
        };
        (at(1, 0) - at(0, 0)).norm().max((at(0, 1) - at(0, 0)).norm())
    }
}

pub fn radars() -> impl Strategy<Value = Rig> {
    (0.8..1.2_f64, any::<bool>(), any::<bool>()).prop_map(|(field, flip_t, flip_p)| {
        let scan = |count: usize, flip: bool| {
            let step = field / SIZE.cols as f64 * if flip { -1.0 } else { 1.0 };
            AngularScan::from_radians(-0.5 * step * (count - 1) as f64, step)
        };
        let radar = ImagingRadar::new(SIZE, scan(SIZE.cols, flip_t), scan(SIZE.rows, flip_p));
        Rig::new(radar.unwrap(), 1.0)
    })
}

pub fn cameras() -> impl Strategy<Value = Rig> {
    (45.0..70.0_f64, any::<bool>()).prop_map(|(f, lengths)| {
        let k = Intrinsics { fx: f, fy: f, cx: 31.5, cy: 23.5 };
        let scale = if lengths { PinholeScale::RayLength } else { PinholeScale::Depth };
        Rig::new(Pinhole::new(SIZE, k).unwrap().with_scale(scale), 1.0)
    })
}

/// Lenses that bend rays outwards, seen from either side.
pub fn lenses() -> impl Strategy<Value = Rig> {
    (0.0..0.3_f64, any::<bool>()).prop_map(|(bend, mirrored)| {
        let ray = |k: usize| {
            let (row, col) = ((k / SIZE.cols) as f64 - 23.5, (k % SIZE.cols) as f64 - 31.5);
            let (x, y) = (if mirrored { -col } else { col } / 55.0, row / 55.0);
            let out = 1.0 + bend * (x * x + y * y);
            Vector3::new(x * out, y * out, 1.0)
        };
        let rays = (0..SIZE.pixels()).map(ray).collect();
        Rig::new(RayTable::new(SIZE, rays, PinholeScale::Depth).unwrap(), 1.0)
    })
}

/// The range finder of section 4.6, with fewer rows and columns and in units of 140 mm.
pub fn stripes() -> impl Strategy<Value = Rig> {
    any::<bool>().prop_map(|falling| {
        let mm = 1.0 / 140.0;
        let (first, step) = if falling { (75.9, -0.28) } else { (58.0, 0.28) };
        let theta_laser = LaserAngles::equal_steps_degrees(first, step, SIZE.cols);
        let parameters = LightStripeParameters {
            camera_rows: SIZE.rows,
            focal_length: 16.0 * mm,
            cell_width: 0.0084 * mm,
            cell_height: 0.1 * mm,
            x_center: 384.0,
            y_center: 23.5,
            baseline: 300.0 * mm,
            mirror_axis: 16.0 * mm,
            mirror_face: 20.0 * mm,
            farthest: 2000.0 * mm,
            theta_laser,
            ..LightStripeParameters::smart_eye()
        };
        Rig::new(LightStripe::new(parameters).unwrap(), 1.0)
    })
}

/// The scanner of section 4.7 in millimetres, of which 12 are one unit of a scene.
pub fn tables() -> impl Strategy<Value = Rig> {
    static TABLES: OnceLock<[Arc<LookupTable>; 2]> = OnceLock::new();
    any::<bool>().prop_map(|falling| {
        let table = |step: f64| {
            let start = -0.5 * step * (SIZE.rows - 1) as f64;
            Arc::new(LookupTable::hyscan(LinearSteps::new(start, step, SIZE.rows)).unwrap())
        };
        let tables = TABLES.get_or_init(|| [table(0.9), table(-0.9)]);
        let frame = tables[usize::from(falling)].clone();
        Rig { frame, scale: 31.0 }
    })
}

/// All kinds of sensors that have an inverse mapping.
pub fn rigs() -> impl Strategy<Value = Rig> {
    prop_oneof![radars(), cameras(), lenses(), stripes(), tables()]
}

pub fn directions() -> impl Strategy<Value = Vector3> {
    (-1.0..1.0, -1.0..1.0, -1.0..1.0)
        .prop_map(|(x, y, z)| Vector3::new(x, y, z))
        .prop_filter_map("has a direction", |v| (v.norm() > 0.1).then(|| v.normalize()))
}

/// What stands before a sensor, in units of a scene around the origin; `sight` is where it looks.
#[derive(Debug, Clone)]
pub enum Setting {
    /// Balls, far enough from each other for range jumps between them.
    Balls(Vec<(Vector3, f64)>),
    /// A cylinder of a radius across the line of sight, and ground far behind it.
    Cylinder(Vector3, f64),
    /// A wall, tilted by up to 45°.
    Wall(Vector3),
}

impl Setting {
    pub fn solids(&self, sight: &Vector3, scale: f64) -> Vec<Solid> {
        match self {
            Self::Balls(balls) => {
                let ball = |(centre, radius): &(Vector3, f64)| Solid::Ball {
                    centre: Point3::from(centre * scale),
                    radius: radius * scale,
                };
                balls.iter().map(ball).collect()
            }
            Self::Cylinder(along, radius) => {
                let axis = along
                    .cross(sight)
                    .try_normalize(1e-3)
                    .unwrap_or_else(|| Vector3::x().cross(sight).normalize());
                let cylinder =
                    Solid::Cylinder { on_axis: Point3::origin(), axis, radius: radius * scale };
                let on_plane = Point3::from(sight * (3.0 * scale));
                vec![cylinder, Solid::Ground { on_plane, normal: -sight }]
            }
            Self::Wall(tilt) => {
                let normal = (tilt - sight * 1.5).normalize();
                vec![Solid::Ground { on_plane: Point3::origin(), normal }]
            }
        }
    }
}

pub fn settings() -> impl Strategy<Value = Setting> {
    let ball = (-1.4..1.4, -1.4..1.4, -1.4..1.4, 0.3..0.8_f64)
        .prop_map(|(x, y, z, radius)| (Vector3::new(x, y, z), radius));
    let apart = |a: &(Vector3, f64), b: &(Vector3, f64)| (a.0 - b.0).norm() > a.1 + b.1 + 0.8;
    let balls = prop::collection::vec(ball, 1..4).prop_map(move |balls| {
        let mut kept: Vec<(Vector3, f64)> = Vec::new();
        for b in balls {
            if kept.iter().all(|k| apart(k, &b)) {
                kept.push(b);
            }
        }
        Setting::Balls(kept)
    });
    prop_oneof![
        balls,
        (directions(), 0.4..1.0_f64).prop_map(|(d, r)| Setting::Cylinder(d, r)),
        directions().prop_map(Setting::Wall),
    ]
}

/// A view with what it is of.
#[derive(Clone)]
pub struct Seen {
    pub rig: Rig,
    pub view: View,
    pub solids: Vec<Solid>,
}

/// Short, since a view prints all its pixels.
impl std::fmt::Debug for Seen {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let handedness = self.rig.frame.handedness();
        write!(f, "{} pixels, {handedness:?}, {:?}", self.rig.frame.size(), self.solids)
    }
}

/// A random view; a share of the pixels is missing.
pub fn seen(missing: f64) -> impl Strategy<Value = Seen> {
    let dropped = prop::collection::vec(prop::bool::weighted(missing), 256 * 64);
    (rigs(), settings(), directions(), 0.0..3.1_f64, dropped).prop_filter_map(
        "sees something",
        |(rig, setting, axis, angle, dropped)| {
            let pose = rig.pose(axis * angle);
            let solids = setting.solids(&rig.line_of_sight(&pose), rig.scale);
            let cols = rig.frame.size().cols;
            let is_dropped = |p: Pixel| dropped.get(p.row * cols + p.col) == Some(&true);
            let view = look(rig.frame.clone(), pose, &solids, is_dropped)?;
            Some(Seen { rig, view, solids })
        },
    )
}

/// Planes of a normal, an interval of a scene's units apart, one of them through a world point.
pub fn planes_through(p: &Point3, normal: Vector3, interval: f64) -> PlaneFamily {
    let guide = StraightGuide::along(normal).unwrap();
    PlaneFamily::new(guide, guide.station(p), interval).unwrap()
}

/// A random family of planes for a view; one in three has a plane through a ray's start.
pub fn family(seen: &Seen, normal: Vector3, interval: f64, kind: u8) -> PlaneFamily {
    let interval = interval * seen.rig.scale;
    let pose = seen.view.world_from_sensor();
    let start = pose * seen.rig.frame.ray(seen.rig.middle()).unwrap().start;
    let through = if kind == 0 { start } else { Point3::new(0.013, 0.02, -0.01) };
    planes_through(&through, normal, interval)
}
