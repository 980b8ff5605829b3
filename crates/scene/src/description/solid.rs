//! `[[solid]]` entries and their materials.

use super::check::{Place, Problem};
use crate::{LARGEST, Mesh, Shape, Solid, SolidError, fixtures};
use nalgebra::{Translation3, Unit, UnitQuaternion};
use serde::Deserialize;
use std::collections::BTreeMap;
use transect_geometry::{Isometry3, Point2, Vector3};

/// One table for all shapes, so that every wrong key can be named.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SolidEntry {
    name: Option<String>,
    shape: ShapeName,
    size: Option<[f64; 3]>,
    radius: Option<f64>,
    top_radius: Option<f64>,
    tube: Option<f64>,
    height: Option<f64>,
    bottom: Option<Vec<[f64; 2]>>,
    top: Option<Vec<[f64; 2]>>,
    /// A name in the map of meshes, or of one that the crate makes.
    pub mesh: Option<String>,
    material: Option<String>,
    at: [f64; 3],
    rotate: Option<Rotation>,
    /// Numbers of the only stations that see it, from 0.
    stations: Option<Vec<usize>>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Box,
    Pyramid,
    Cylinder,
    Cone,
    Frustum,
    Ball,
    Torus,
    Prism,
    Mesh,
}

impl ShapeName {
    /// Its name in messages, and its keys.
    fn keys(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Box => ("box", &["size"]),
            Self::Pyramid => ("pyramid", &["size"]),
            Self::Cylinder => ("cylinder", &["radius", "height"]),
            Self::Cone => ("cone", &["radius", "height"]),
            Self::Frustum => ("frustum", &["radius", "top_radius", "height"]),
            Self::Ball => ("ball", &["radius"]),
            Self::Torus => ("torus", &["radius", "tube"]),
            Self::Prism => ("prism", &["bottom", "top", "height"]),
            Self::Mesh => ("mesh", &["mesh"]),
        }
    }
}

/// One `[materials]` entry.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct MaterialEntry {
    pub reflectivity: f64,
}

impl MaterialEntry {
    pub fn check(&self, name: &str) -> Result<f64, Problem> {
        let share = |r: f64| r > 0.0 && r <= 1.0;
        let place = Place::new(&format!("materials, {name:?}"));
        place.value("reflectivity", self.reflectivity, share, "a share above 0, up to 1")
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rotation {
    axis: [f64; 3],
    degrees: f64,
}

/// Materials and meshes that entries may name.
pub(super) struct Library<'a> {
    pub meshes: &'a BTreeMap<String, Mesh>,
    pub materials: &'a BTreeMap<String, MaterialEntry>,
}

impl Library<'_> {
    fn mesh(&self, place: &Place, name: &str) -> Result<Shape, Problem> {
        let made = || fixtures::mesh(name).map(|mesh| Shape::mesh(&mesh));
        let shape = self.meshes.get(name).map(Shape::mesh).or_else(made);
        let missing = || place.problem("mesh", format_args!("no mesh is called {name:?}"));
        let shape = shape.ok_or_else(missing)?;
        shape.map_err(|error| place.problem("mesh", format_args!("{name:?}: {error}")))
    }
}

impl SolidEntry {
    /// The stations while which the solid is there, of so many; `None` for a solid that stays.
    pub fn visit(&self, index: usize, count: usize) -> Result<Option<Vec<usize>>, Problem> {
        let Some(stations) = &self.stations else { return Ok(None) };
        let place = Place::entry("solid", index, self.name.as_deref());
        match stations.iter().find(|station| **station >= count) {
            None => Ok(Some(stations.clone())),
            Some(station) => {
                let problem = format_args!("there is no station {station}; the first one is 0");
                Err(place.problem("stations", problem))
            }
        }
    }

    /// The solid that an entry describes.
    pub fn build(self, index: usize, library: &Library) -> Result<Solid, Problem> {
        let place = Place::entry("solid", index, self.name.as_deref());
        let shape = self.shape(&place, library)?;
        let position: Vector3 = place.triple("at", self.at)?;
        let rotation = match &self.rotate {
            Some(rotation) => rotation.build(&place)?,
            None => UnitQuaternion::identity(),
        };
        let world_from_solid = Isometry3::from_parts(Translation3::from(position), rotation);
        let mut solid = Solid::new(shape, world_from_solid).map_err(|e| place.problem("at", e))?;
        if let Some(name) = &self.material {
            let unknown =
                || place.problem("material", format_args!("no material is called {name:?}"));
            let reflectivity = library.materials.get(name).ok_or_else(unknown)?.reflectivity;
            // An impossible one has been refused with its material.
            solid = solid.clone().with_reflectivity(reflectivity).unwrap_or(solid);
        }
        Ok(match self.name {
            Some(name) => solid.named(name),
            None => solid,
        })
    }

    fn shape(&self, place: &Place, library: &Library) -> Result<Shape, Problem> {
        self.refuse_others(place)?;
        let (kind, _) = self.shape.keys();
        let size = || place.needed("size", self.size, kind).map(Vector3::from);
        let radius = || place.needed("radius", self.radius, kind);
        let height = || place.needed("height", self.height, kind);
        let shape = match self.shape {
            ShapeName::Box => Shape::cuboid(size()?),
            ShapeName::Pyramid => Shape::pyramid(size()?),
            ShapeName::Cylinder => Shape::cylinder(radius()?, height()?),
            ShapeName::Cone => Shape::cone(radius()?, height()?),
            ShapeName::Frustum => {
                let top = place.needed("top_radius", self.top_radius, kind)?;
                Shape::frustum(radius()?, top, height()?)
            }
            ShapeName::Ball => Shape::ball(radius()?),
            ShapeName::Torus => Shape::torus(radius()?, place.needed("tube", self.tube, kind)?),
            ShapeName::Prism => {
                let polygon = |p: &Vec<[f64; 2]>| p.iter().copied().map(Point2::from).collect();
                let bottom: Vec<_> = polygon(place.needed("bottom", self.bottom.as_ref(), kind)?);
                let top = self.top.as_ref().map_or_else(|| bottom.clone(), polygon);
                Shape::prism(&bottom, &top, height()?)
            }
            ShapeName::Mesh => {
                let name = place.needed("mesh", self.mesh.as_deref(), kind)?;
                return library.mesh(place, name);
            }
        };
        shape.map_err(|error| wrong_shape(place, error))
    }

    /// Refuses keys that the shape does not have.
    fn refuse_others(&self, place: &Place) -> Result<(), Problem> {
        let (kind, keys) = self.shape.keys();
        let given = [
            ("size", self.size.is_some()),
            ("radius", self.radius.is_some()),
            ("top_radius", self.top_radius.is_some()),
            ("tube", self.tube.is_some()),
            ("height", self.height.is_some()),
            ("bottom", self.bottom.is_some()),
            ("top", self.top.is_some()),
            ("mesh", self.mesh.is_some()),
        ];
        let mut others = given.into_iter().filter(|(key, _)| !keys.contains(key));
        others.try_for_each(|(key, given)| place.refuse(key, given, kind))
    }
}

fn wrong_shape(place: &Place, error: SolidError) -> Problem {
    match error {
        SolidError::BadSize { key, value } => {
            let wanted = format_args!("{value:?} is not a positive length of at most {LARGEST:e}");
            place.problem(key, wanted)
        }
        SolidError::TubeTooThick { tube, .. } => {
            place.problem("tube", format_args!("{tube} is not less than the radius"))
        }
        SolidError::BadPolygon { key, reason } => place.problem(key, reason),
        other => place.problem("shape", other),
    }
}

impl Rotation {
    fn build(&self, place: &Place) -> Result<UnitQuaternion<f64>, Problem> {
        let axis: Vector3 = place.triple("rotate.axis", self.axis)?;
        let degrees = place.value("rotate.degrees", self.degrees, |_| true, "a finite angle")?;
        let axis = Unit::try_new(axis, 0.0)
            .ok_or_else(|| place.problem("rotate.axis", "it has no direction"))?;
        Ok(UnitQuaternion::from_axis_angle(&axis, degrees.to_radians()))
    }
}
