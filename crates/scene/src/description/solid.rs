//! `[[solid]]` entries.

use super::check::{Place, Problem};
use crate::{Shape, Solid, SolidError};
use nalgebra::{Translation3, Unit, UnitQuaternion};
use serde::Deserialize;
use transect_geometry::{Isometry3, Vector3};

/// One table for all shapes, since only then every wrong key can be named.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SolidEntry {
    name: Option<String>,
    shape: ShapeName,
    size: Option<[f64; 3]>,
    radius: Option<f64>,
    height: Option<f64>,
    at: [f64; 3],
    rotate: Option<Rotation>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Box,
    Cylinder,
    Ball,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Rotation {
    axis: [f64; 3],
    degrees: f64,
}

impl SolidEntry {
    /// The solid that an entry describes.
    pub fn build(self, index: usize) -> Result<Solid, Problem> {
        let place = Place::entry("solid", index, self.name.as_deref());
        let shape = self.shape(&place)?;
        let position: Vector3 = place.triple("at", self.at)?;
        let rotation = match &self.rotate {
            Some(rotation) => rotation.build(&place)?,
            None => UnitQuaternion::identity(),
        };
        let world_from_solid = Isometry3::from_parts(Translation3::from(position), rotation);
        let solid = Solid::new(shape, world_from_solid).map_err(|e| place.problem("at", e))?;
        Ok(match self.name {
            Some(name) => solid.named(name),
            None => solid,
        })
    }

    fn shape(&self, place: &Place) -> Result<Shape, Problem> {
        let shape = match self.shape {
            ShapeName::Box => {
                place.refuse("radius", self.radius.is_some(), "box")?;
                place.refuse("height", self.height.is_some(), "box")?;
                Shape::cuboid(place.needed("size", self.size, "box")?.into())
            }
            ShapeName::Cylinder => {
                place.refuse("size", self.size.is_some(), "cylinder")?;
                let radius = place.needed("radius", self.radius, "cylinder")?;
                Shape::cylinder(radius, place.needed("height", self.height, "cylinder")?)
            }
            ShapeName::Ball => {
                place.refuse("size", self.size.is_some(), "ball")?;
                place.refuse("height", self.height.is_some(), "ball")?;
                Shape::ball(place.needed("radius", self.radius, "ball")?)
            }
        };
        shape.map_err(|error| match error {
            SolidError::BadSize { key, value } => {
                place.problem(key, format_args!("{value} is not a positive length"))
            }
            other => place.problem("shape", other),
        })
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
