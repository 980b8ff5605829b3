//! Inside, outside or unknown, for many points of a store that need not fit into memory.

use super::error::StoreError;
use super::snapshot::Snapshot;
use crate::query::{locate_between, planes_around};
use crate::{ModelVolume, PlaneSelection, SectionIndex, SpaceAnswer, VolumeSum};
use std::collections::BTreeMap;
use transect_geometry::{PlaneIndex, Point3};

/// A snapshot that answers questions about points, and keeps the planes it was asked about lately.
///
/// The first question about a plane reads and sorts it; later ones cost what those to a
/// [`ModelIndex`](crate::ModelIndex) cost. Ask in order of station where that is possible.
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
    index: Option<SectionIndex<'static>>,
    nodes: usize,
    /// Number of the question that asked for it last.
    asked: u64,
}

impl SpaceQuery {
    /// Nodes that are kept in memory unless said otherwise; about 200 bytes each.
    pub const DEFAULT_CAPACITY: usize = 1_000_000;

    /// A query that has read nothing yet and keeps at most `capacity` nodes, or the two planes
    /// around a point if these have more.
    pub fn new(snapshot: Snapshot, capacity: usize) -> Self {
        Self { snapshot, capacity, planes: BTreeMap::new(), nodes: 0, questions: 0 }
    }

    /// Where a world point is; the same answer as [`Model::locate`](crate::Model::locate).
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
        let index = self.snapshot.plane(plane)?.map(SectionIndex::owning);
        // A plane without curves takes space too.
        let nodes = index.as_ref().map_or(1, |index| index.section().node_count());
        self.planes.insert(plane, Kept { index, nodes, asked: self.questions });
        self.nodes += nodes;
        Ok(())
    }

    /// Forgets planes, longest unasked first, until the rest is within the capacity.
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
    /// The volume of the solid, as [`Model::volume`](crate::Model::volume), one plane in memory at a time.
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
