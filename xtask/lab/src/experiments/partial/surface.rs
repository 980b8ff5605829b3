//! The surfaces of the accuracy table, all of size 1, and where the truth about them is.

use crate::failure::Failure;
use std::collections::BTreeMap;
use std::sync::Arc;
use transect_device::{ImageSize, View};
use transect_geometry::{
    Curve, Isometry3, PlaneFamily, PlaneFrame, PlaneIndex, Point2, Point3, Vector3,
};
use transect_scene::fixtures::{face_mask, face_mask_height};
use transect_scene::{Mesh, Noise, Scene, Shape, Solid};
use transect_sensors::{Intrinsics, Pinhole};

/// A solid around the origin of which one surface is asked about.
pub struct Surface {
    pub name: &'static str,
    solid: Solid,
    truth: Truth,
}

enum Truth {
    /// Signed distance, positive outside, and its gradient.
    Distance(fn(&Point3) -> (f64, Vector3)),
    /// The exact sections of the solid, a mesh of the face mask.
    Face,
}

/// The truth at the place of the section that is nearest to a node.
#[derive(Debug, Clone, Copy)]
pub struct Nearest {
    /// Distance of the node in its plane, positive outside.
    pub signed: f64,
    /// Sine of the angle between surface normal and plane.
    pub sine: f64,
}

/// The truth on one plane.
pub struct TrueSection<'a> {
    surface: &'a Surface,
    frame: PlaneFrame,
    curves: Vec<Curve>,
}

const RING: f64 = 0.33;
const TUBE: f64 = 0.16;

/// Height of the face mask in its own unit, which is 1 here.
const FACE_SIZE: f64 = 190.0;

/// Farther from the face's own formula, the mask's truth is another part of it: its rim or back.
const OTHER_PART: f64 = 1e-3;

/// All surfaces.
pub fn surfaces() -> Result<Vec<Surface>, Failure> {
    let of = |name, shape: Shape, distance| -> Result<Surface, Failure> {
        let solid = Solid::new(shape, Isometry3::identity())?;
        Ok(Surface { name, solid, truth: Truth::Distance(distance) })
    };
    Ok(vec![
        of("plane", Shape::cuboid(Vector3::new(8.0, 8.0, 0.1))?, |p| (p.z - 0.05, Vector3::z()))?,
        of("cylinder", Shape::cylinder(0.5, 12.0)?, |p| {
            let out = Vector3::new(p.x, p.y, 0.0);
            (out.norm() - 0.5, out.normalize())
        })?,
        of("ball", Shape::ball(0.5)?, |p| (p.coords.norm() - 0.5, p.coords.normalize()))?,
        of("torus", Shape::torus(RING, TUBE)?, |p| {
            let ring = Vector3::new(p.x, p.y, 0.0).normalize() * RING;
            let out = p.coords - ring;
            (out.norm() - TUBE, out.normalize())
        })?,
        face()?,
    ])
}

fn face() -> Result<Surface, Failure> {
    let Mesh { vertices, faces } = face_mask();
    let vertices = vertices.into_iter().map(|v| v / FACE_SIZE).collect();
    let shape = Shape::mesh(&Mesh { vertices, faces })?;
    Ok(Surface {
        name: "face",
        solid: Solid::new(shape, Isometry3::identity())?,
        truth: Truth::Face,
    })
}

impl Surface {
    /// The view of a camera of 30° that looks at the solid from 3 sizes away, off its axes.
    pub fn view(&self, sigma: f64, size: usize) -> Result<View, Failure> {
        let centre = 0.5 * (size as f64 - 1.0);
        let focal = 0.5 * size as f64 / 15_f64.to_radians().tan();
        let intrinsics = Intrinsics { fx: focal, fy: focal, cx: centre, cy: centre };
        let camera = Pinhole::new(ImageSize { rows: size, cols: size }, intrinsics)?;
        let eye = Point3::new(0.7, -1.5, 2.5);
        // `face_towards` turns z towards the target and y upwards; the image's rows run down.
        let pose = Isometry3::face_towards(&eye, &Point3::origin(), &-Vector3::z());
        let noise = Noise { sigma, seed: 7, ..Noise::NONE };
        let scene = Scene::new(vec![self.solid.clone()]);
        Ok(scene.view(self.name, Arc::new(camera), pose, &noise, 0)?)
    }

    /// The exact sections by the planes of a family, where they are needed.
    pub fn sections(
        &self,
        planes: &PlaneFamily,
    ) -> Result<BTreeMap<PlaneIndex, Vec<Curve>>, Failure> {
        match self.truth {
            Truth::Distance(_) => Ok(BTreeMap::new()),
            Truth::Face => Ok(Scene::new(vec![self.solid.clone()]).sections(planes, 1e-3)?),
        }
    }

    /// The truth on a plane.
    pub fn on(&self, frame: PlaneFrame, curves: Vec<Curve>) -> TrueSection<'_> {
        TrueSection { surface: self, frame, curves }
    }
}

impl TrueSection<'_> {
    /// `None` where another part of the solid is nearer than the one asked about.
    pub fn nearest(&self, node: &Point2) -> Option<Nearest> {
        let found = match self.surface.truth {
            Truth::Distance(distance) => self.by_distance(node, distance),
            Truth::Face => self.by_curves(node)?,
        };
        let ours = found.signed.abs() < 0.1 && found.sine < 0.9987;
        ours.then_some(found)
    }

    /// To first order, the distance in the plane is that in space over the share of the gradient
    /// that lies in the plane.
    fn by_distance(&self, node: &Point2, distance: fn(&Point3) -> (f64, Vector3)) -> Nearest {
        let (distance, gradient) = distance(&self.frame.world_from_plane(node));
        let sine = gradient.dot(&self.frame.normal()).abs().min(1.0);
        Nearest { signed: distance / (1.0 - sine * sine).sqrt(), sine }
    }

    fn by_curves(&self, node: &Point2) -> Option<Nearest> {
        let units = self.curves.iter().flat_map(Curve::units);
        let feet = units.map(|unit| {
            let along = unit.vector();
            let share = (node - unit.start).dot(&along) / along.norm_squared();
            let foot = unit.start + along * share.clamp(0.0, 1.0);
            let off = node - foot;
            // Solid on the left: what is on the right is outside.
            (off.norm(), foot, -along.perp(&off).signum())
        });
        let (distance, foot, side) = feet.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let normal = face_normal(&self.frame.world_from_plane(&foot))?;
        let sine = normal.dot(&self.frame.normal()).abs().min(1.0);
        Some(Nearest { signed: side * distance, sine })
    }
}

/// Normal of the face at one of its points; `None` on another part of the mask.
fn face_normal(at: &Point3) -> Option<Vector3> {
    const STEP: f64 = 1e-4;
    let height =
        |x: f64, y: f64| face_mask_height(x * FACE_SIZE, y * FACE_SIZE).map(|h| h / FACE_SIZE);
    let slope = |dx: f64, dy: f64| {
        Some((height(at.x + dx, at.y + dy)? - height(at.x - dx, at.y - dy)?) / (2.0 * STEP))
    };
    if (height(at.x, at.y)? - at.z).abs() > OTHER_PART {
        return None;
    }
    Some(Vector3::new(-slope(STEP, 0.0)?, -slope(0.0, STEP)?, 1.0).normalize())
}
