//! Inside, outside or unknown, for many points and a store that may be larger than memory.

use super::error::StoreError;
use super::snapshot::Snapshot;
use crate::query::{locate_between, planes_around};
use crate::{ModelVolume, PlaneSelection, SectionIndex, SpaceAnswer, VolumeSum};
use std::collections::BTreeMap;
use transect_geometry::{PlaneIndex, Point3};

/// Locates points in a snapshot, and keeps the planes that were used last in memory.
///
/// The first point near a plane reads and indexes it; later points cost as much as in a
/// [`ModelIndex`](crate::ModelIndex). Locate points in order of station where possible.
#[derive(Debug)]
pub struct SpaceQuery {
    snapshot: Snapshot,
    capacity: usize,
    planes: BTreeMap<PlaneIndex, Kept>,
    /// Number of nodes in `planes`.
    nodes: usize,
    questions: u64,
}

#[derive(Debug)]
struct Kept {
    /// `None` for a plane without curves.
    index: Option<SectionIndex>,
    nodes: usize,
    /// Number of the question that used it last.
    asked: u64,
}

impl SpaceQuery {
    /// Default number of nodes in memory, about 200 bytes each. Chosen by hand; doubled, planes are
    /// read again less often.
    pub const DEFAULT_CAPACITY: usize = 1_000_000;

    /// A query without planes in memory. It keeps at most `capacity` nodes, or the two planes
    /// around a point if these have more.
    pub fn new(snapshot: Snapshot, capacity: usize) -> Self {
        Self { snapshot, capacity, planes: BTreeMap::new(), nodes: 0, questions: 0 }
    }

    /// Locates a world point, with the same answer as [`Model::locate`](crate::Model::locate).
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn locate(&mut self, in_world: &Point3) -> Result<SpaceAnswer, StoreError> {
        let family = self.snapshot.header().planes.clone();
        self.questions += 1;
        let around = planes_around(&family, &PlaneSelection::ALL, in_world);
        for &plane in &around {
            self.keep(plane)?;
        }
        self.forget();
        Ok(locate_between(&family, &around, in_world, |plane, p| {
            Some(self.planes.get(&plane)?.index.as_ref()?.locate(p))
        }))
    }

    fn keep(&mut self, plane: PlaneIndex) -> Result<(), StoreError> {
        if let Some(kept) = self.planes.get_mut(&plane) {
            kept.asked = self.questions;
            return Ok(());
        }
        let index = self.snapshot.plane(plane)?.map(SectionIndex::new);
        // A plane without curves also takes memory.
        let nodes = index.as_ref().map_or(1, |index| index.section().node_count());
        self.planes.insert(plane, Kept { index, nodes, asked: self.questions });
        self.nodes += nodes;
        Ok(())
    }

    /// Drops planes, least recently used first, until the rest is within the capacity.
    fn forget(&mut self) {
        while self.nodes > self.capacity {
            let oldest = self.planes.iter().min_by_key(|(_, kept)| kept.asked);
            let Some((&plane, _)) = oldest.filter(|(_, kept)| kept.asked < self.questions) else {
                break;
            };
            self.nodes -= self.planes.remove(&plane).map_or(0, |kept| kept.nodes);
        }
    }
}

impl Snapshot {
    /// The volume of the solid, as [`Model::volume`](crate::Model::volume), one plane in memory at
    /// a time.
    ///
    /// # Errors
    /// If the store is damaged.
    pub fn volume(&self) -> Result<ModelVolume, StoreError> {
        let mut sum = VolumeSum::new(&self.header().planes, &PlaneSelection::ALL);
        for entry in self.planes()? {
            let (plane, section) = entry?;
            sum.add(plane, &section);
        }
        Ok(sum.finish())
    }
}
