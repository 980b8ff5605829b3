//! The header of a store, and its records of views.

use super::error::StoreProblem;
use super::view_id::ViewId;
use crate::check::{check_planes, check_pose, check_sigma};
use crate::codec::values::{ViewValue, decode, encode};
use crate::{CodecError, InvariantError};
use serde::{Deserialize, Serialize};
use transect_geometry::{Curve, Isometry3, LengthUnit, PlaneFamily, PlaneIndex};

/// The header of a store, fixed when it is created. The order of fields is the file layout.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StoreHeader {
    /// The unit of every length in the store.
    pub unit: LengthUnit,
    /// Where the section planes are.
    pub planes: PlaneFamily,
    /// The settings with which views are modelled and fused, as text; the store does not read them.
    #[serde(deserialize_with = "crate::text::read")]
    pub options: String,
    /// The program and its version.
    #[serde(deserialize_with = "crate::text::read")]
    pub tool: String,
}

/// A view that goes into a store.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewDescription {
    /// Its id, which differs from those of other views.
    pub id: ViewId,
    /// Its name in reports.
    pub name: String,
    /// Its sensor, as the caller describes it; the store does not read it.
    pub sensor: String,
    /// Its origin, such as the file of its range image.
    pub source: String,
    /// A hash of that source, as the caller writes it; empty if unknown.
    pub source_hash: String,
    /// The pose; its translation is in the store's length unit.
    pub world_from_sensor: Isometry3,
    /// Standard deviation of its range values in the store's length unit; `None` if unknown.
    pub sigma: Option<f64>,
}

/// A view that is in a store.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StoredView {
    /// The entry of the view.
    pub entry: ViewDescription,
    /// The planes on which it has curves, in order.
    pub planes: Vec<PlaneIndex>,
    /// Number of its partial curves on all planes.
    pub curves: u64,
    /// Number of their nodes.
    pub nodes: u64,
}

impl StoreHeader {
    pub(crate) fn check(&self) -> Result<(), InvariantError> {
        check_planes(&self.planes)
    }

    pub(crate) fn encode(&self) -> Result<Vec<u8>, StoreProblem> {
        encode(self).map_err(StoreProblem::value("header"))
    }

    pub(crate) fn decode(bytes: &[u8]) -> Result<Self, StoreProblem> {
        let header: Self = decode(bytes).map_err(StoreProblem::value("header"))?;
        header.check()?;
        Ok(header)
    }
}

impl ViewDescription {
    pub(crate) fn check(&self) -> Result<(), InvariantError> {
        check_pose(&self.id.0, &self.world_from_sensor)?;
        check_sigma(&self.id.0, self.sigma)
    }
}

impl StoredView {
    /// A view that has no curves yet.
    pub(crate) fn new(entry: ViewDescription) -> Self {
        Self { entry, planes: Vec::new(), curves: 0, nodes: 0 }
    }

    /// Counts its curves on one plane.
    pub(crate) fn count(&mut self, plane: PlaneIndex, curves: &[Curve]) {
        self.planes.push(plane);
        self.curves += curves.len() as u64;
        self.nodes += node_count(curves);
    }

    pub(crate) fn encode(&self) -> Result<Vec<u8>, StoreProblem> {
        let ViewDescription { id, name, sensor, source, source_hash, world_from_sensor, sigma } =
            &self.entry;
        let value = ViewValue {
            name,
            sensor,
            source,
            source_hash,
            world_from_sensor: *world_from_sensor,
            sigma: *sigma,
            curves: self.curves,
            nodes: self.nodes,
            planes: self.planes.clone(),
        };
        encode(&value).map_err(StoreProblem::value(format_args!("view {id}")))
    }

    pub(crate) fn decode(id: &str, bytes: &[u8]) -> Result<Self, StoreProblem> {
        let decoded: Result<ViewValue<'_>, CodecError> = decode(bytes);
        let value = decoded.map_err(StoreProblem::value(format_args!("view {id}")))?;
        let entry = ViewDescription {
            id: id.into(),
            name: value.name.to_owned(),
            sensor: value.sensor.to_owned(),
            source: value.source.to_owned(),
            source_hash: value.source_hash.to_owned(),
            world_from_sensor: value.world_from_sensor,
            sigma: value.sigma,
        };
        entry.check()?;
        let ViewValue { planes, curves, nodes, .. } = value;
        if !planes.is_sorted_by(|a, b| a < b) {
            return Err(StoreProblem::Unsound(format!("view {id} lists its planes out of order")));
        }
        Ok(Self { entry, planes, curves, nodes })
    }
}

/// Number of nodes of some curves.
pub(crate) fn node_count(curves: &[Curve]) -> u64 {
    curves.iter().map(|curve| curve.nodes().len() as u64).sum()
}
