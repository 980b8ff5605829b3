//! The lowest level of the tree: inserting, deleting and changing nodes, and walking along curves
//! (the driver functions of dissertation 2.5.2).
//!
//! Departure from the dissertation: there nodes are linked both ways by pointers. Here a curve is
//! an array, so neighbours are one place before and after. A change costs time in proportion to the
//! plane's curves, and keeps all envelopes exact.

use crate::{CurveIndex, EditError, Model, NodeIndex, Section};
use transect_geometry::{Curve, Envelope, Node, PlaneIndex};

impl Model {
    /// Inserts a node before another of a curve, or after the last one for the index past it.
    ///
    /// # Errors
    /// [`EditError`] if there is no such curve or place, or the node has invalid numbers.
    pub fn insert_node(
        &mut self,
        plane: PlaneIndex,
        curve: CurveIndex,
        before: NodeIndex,
        node: Node,
    ) -> Result<(), EditError> {
        self.change_nodes(plane, curve, |nodes| {
            let place_exists = before.0 <= nodes.len();
            place_exists.then(|| nodes.insert(before.0, node)).ok_or(EditError::NoSuchNode(before))
        })
    }

    /// Removes a node from a curve; its neighbours become each other's neighbours.
    ///
    /// # Errors
    /// [`EditError`] if there is no such curve or node, or too few nodes would remain.
    pub fn remove_node(
        &mut self,
        plane: PlaneIndex,
        curve: CurveIndex,
        node: NodeIndex,
    ) -> Result<Node, EditError> {
        self.change_nodes(plane, curve, |nodes| {
            let exists = node.0 < nodes.len();
            exists.then(|| nodes.remove(node.0)).ok_or(EditError::NoSuchNode(node))
        })
    }

    /// Replaces a node and returns the old one.
    ///
    /// # Errors
    /// [`EditError`] if there is no such curve or node, or the new node has invalid numbers.
    pub fn replace_node(
        &mut self,
        plane: PlaneIndex,
        curve: CurveIndex,
        at: NodeIndex,
        node: Node,
    ) -> Result<Node, EditError> {
        self.change_nodes(plane, curve, |nodes| {
            let place = nodes.get_mut(at.0).ok_or(EditError::NoSuchNode(at))?;
            Ok(std::mem::replace(place, node))
        })
    }

    fn change_nodes<T>(
        &mut self,
        plane: PlaneIndex,
        index: CurveIndex,
        change: impl FnOnce(&mut Vec<Node>) -> Result<T, EditError>,
    ) -> Result<T, EditError> {
        let curve = self.curve(plane, index)?;
        let (mut nodes, closed, ends) = (curve.nodes().to_vec(), curve.is_closed(), curve.ends());
        let result = change(&mut nodes)?;
        let changed = Curve::new(nodes, closed)?.with_ends(ends);
        let mut curves = self.take_curves(plane);
        curves[index.0] = changed;
        self.set_curves(plane, curves);
        Ok(result)
    }
}

impl Section {
    /// The curves whose envelopes share a point with a rectangle. Other curves have no point in it.
    pub fn curves_near(
        &self,
        rectangle: Envelope,
    ) -> impl DoubleEndedIterator<Item = (CurveIndex, &Curve)> {
        let records = self.curve_records().iter().enumerate();
        let near = records.filter(move |(_, record)| record.envelope().intersects(&rectangle));
        near.map(|(index, record)| (CurveIndex(index), record.curve()))
    }

    /// The next node along a curve; `None` at the end of an open curve, and if there is no such
    /// curve or node.
    pub fn node_after(&self, curve: CurveIndex, node: NodeIndex) -> Option<(NodeIndex, &Node)> {
        let curve = self.curve(curve)?;
        let nodes = curve.nodes();
        nodes.get(node.0)?;
        let next = node.0 + 1;
        let next = if next == nodes.len() && curve.is_closed() { 0 } else { next };
        Some((NodeIndex(next), nodes.get(next)?))
    }

    /// The previous node along a curve; `None` at the beginning of an open curve, and if there is
    /// no such curve or node.
    pub fn node_before(&self, curve: CurveIndex, node: NodeIndex) -> Option<(NodeIndex, &Node)> {
        let curve = self.curve(curve)?;
        let nodes = curve.nodes();
        nodes.get(node.0)?;
        let before = match node.0.checked_sub(1) {
            None if curve.is_closed() => nodes.len() - 1,
            before => before?,
        };
        Some((NodeIndex(before), nodes.get(before)?))
    }
}

#[cfg(test)]
mod tests;
