//! Splitting and joining curves at nodes (the driver functions of dissertation 2.5.2).
//!
//! Both are exact: they never move a node and never bridge ground between two ends. Pieces of a
//! split curve can be joined again, because both keep the node at the cut.

use crate::{CurveIndex, Model, NodeIndex};
use transect_geometry::{Curve, CurveError, Node, PlaneIndex};

/// Why a curve could not be split, joined or changed; the model is then unchanged.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The plane has no such curve.
    #[error("plane {plane} has no curve {curve}")]
    NoSuchCurve {
        /// The plane that was asked for.
        plane: PlaneIndex,
        /// The curve that was asked for.
        curve: CurveIndex,
    },
    /// The curve has no such node, or no such place between nodes.
    #[error("the curve has no node {0}")]
    NoSuchNode(NodeIndex),
    /// The node does not exist, or is an end of an open curve.
    #[error("the curve cannot be split at node {0}")]
    NoSplit(NodeIndex),
    /// A closed curve has no ends to join.
    #[error("curve {0} is closed and has no ends")]
    Closed(CurveIndex),
    /// The end of one curve is not where the other one begins; lengths are in the model's unit.
    #[error("the ends are {distance} apart; only ends at the same place can be joined")]
    EndsApart {
        /// Distance between the two ends.
        distance: f64,
    },
    /// The result has too few nodes for a curve, such as a ring of two.
    #[error("the result has too few nodes for a curve")]
    NoCurve(#[from] CurveError),
}

impl Model {
    /// Cuts a curve at a node, which both pieces keep; returns the place of the second piece.
    ///
    /// An open curve gives two pieces: the first stays in its place, the second is appended to the
    /// plane. A closed curve gives one open piece that begins and ends at the node, and `None`.
    ///
    /// # Errors
    /// [`EditError::NoSuchCurve`], or [`EditError::NoSplit`] if the curve cannot be cut at the
    /// node.
    pub fn split_curve(
        &mut self,
        plane: PlaneIndex,
        index: CurveIndex,
        node: NodeIndex,
    ) -> Result<Option<CurveIndex>, EditError> {
        let (first, second) = split(self.curve(plane, index)?, node)?;
        let mut curves = self.take_curves(plane);
        curves[index.0] = first;
        let behind = second.map(|second| {
            curves.push(second);
            CurveIndex(curves.len() - 1)
        });
        self.set_curves(plane, curves);
        Ok(behind)
    }

    /// Joins the end of one open curve to the beginning of another at the same place, or of itself.
    ///
    /// The node at the joint is kept once, as the first curve has it. The result takes the place of
    /// `first`; `second` is removed, and later curves of the plane move up. A curve joined to
    /// itself becomes closed.
    ///
    /// # Errors
    /// [`EditError`] if a curve does not exist or is closed, or the two ends are not at one place.
    pub fn join_curves(
        &mut self,
        plane: PlaneIndex,
        first: CurveIndex,
        second: CurveIndex,
    ) -> Result<(), EditError> {
        let joined = self.joined(plane, first, second)?;
        let mut curves = self.take_curves(plane);
        curves[first.0] = joined;
        if second != first {
            curves.remove(second.0);
        }
        self.set_curves(plane, curves);
        Ok(())
    }

    fn joined(
        &self,
        plane: PlaneIndex,
        first: CurveIndex,
        second: CurveIndex,
    ) -> Result<Curve, EditError> {
        let head = open(self.curve(plane, first)?, first)?;
        let tail = open(self.curve(plane, second)?, second)?;
        if let (Some(end), Some(beginning)) = (head.last(), tail.first()) {
            let distance = (end.position - beginning.position).norm();
            if distance != 0.0 {
                return Err(EditError::EndsApart { distance });
            }
        }
        // The node of both ends is the second's: it knows the unit that follows.
        let head = &head[..head.len() - 1];
        if first == second {
            return Ok(Curve::new(head.to_vec(), true)?);
        }
        let end = |curve, at: usize| Ok::<_, EditError>(self.curve(plane, curve)?.ends()[at]);
        let ends = [end(first, 0)?, end(second, 1)?];
        Ok(Curve::new([head, tail].concat(), false)?.with_ends(ends))
    }

    pub(crate) fn curve(&self, plane: PlaneIndex, curve: CurveIndex) -> Result<&Curve, EditError> {
        let found = self.section(plane).and_then(|section| section.curve(curve));
        found.ok_or(EditError::NoSuchCurve { plane, curve })
    }
}

fn open(curve: &Curve, index: CurveIndex) -> Result<&[Node], EditError> {
    if curve.is_closed() { Err(EditError::Closed(index)) } else { Ok(curve.nodes()) }
}

fn split(curve: &Curve, node: NodeIndex) -> Result<(Curve, Option<Curve>), EditError> {
    let nodes = curve.nodes();
    let (at, last) = (node.0, nodes.len() - 1);
    if at > last || (!curve.is_closed() && (at == 0 || at == last)) {
        return Err(EditError::NoSplit(node));
    }
    if curve.is_closed() {
        let opened = [&nodes[at..], &nodes[..=at]].concat();
        return Ok((Curve::new(opened, false)?, None));
    }
    // Why a curve was cut is not known to it.
    let [begin, end] = curve.ends();
    let first = Curve::new(nodes[..=at].to_vec(), false)?.with_ends([begin, None]);
    Ok((first, Some(Curve::new(nodes[at..].to_vec(), false)?.with_ends([None, end]))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{empty, polyline, rectangle, small, strip, tangles};
    use proptest::prelude::*;

    const PLANE: PlaneIndex = PlaneIndex(7);

    proptest! {
        #[test]
        fn what_was_split_can_be_joined_again(curves in tangles(), place in 0..100usize) {
            let mut model = empty();
            model.set_curves(PLANE, curves.clone());
            let first = &curves[0];
            let node = if first.is_closed() { 0 } else { 1 + place % (first.nodes().len() - 2) };
            let (a, b) = (CurveIndex(0), model.split_curve(PLANE, CurveIndex(0), NodeIndex(node)));
            prop_assert_eq!(model.check(), Ok(()));
            model.join_curves(PLANE, a, b.unwrap().unwrap_or(a)).unwrap();
            let again: Vec<_> = model.section(PLANE).unwrap().curves().cloned().collect();
            prop_assert_eq!(again, curves);
        }
    }

    #[test]
    fn cutting_a_ring_changes_neither_its_length_nor_its_nodes() {
        let mut model = empty();
        model.insert_curve(PLANE, rectangle(0.0, 0.0, 2.0, 1.0));
        model.split_curve(PLANE, CurveIndex(0), NodeIndex(2)).unwrap();
        let cut = model.section(PLANE).unwrap().curve(CurveIndex(0)).unwrap();
        assert!(!cut.is_closed());
        assert_eq!((cut.length(), cut.nodes().len()), (6.0, 5));
        assert_eq!(cut.nodes()[0], cut.nodes()[4]);
    }

    #[test]
    fn ends_at_different_places_stay_apart() {
        let mut model = empty();
        model.set_curves(PLANE, vec![strip(), polyline(&[(0.0, -1.0), (1.0, -1.0)], false)]);
        let before = model.clone();
        let apart = model.join_curves(PLANE, CurveIndex(0), CurveIndex(1)).unwrap_err();
        assert_eq!(apart, EditError::EndsApart { distance: 1.0 });
        let ends = [NodeIndex(0), NodeIndex(2), NodeIndex(3)];
        for end in ends {
            let refused = model.split_curve(PLANE, CurveIndex(0), end);
            assert_eq!(refused, Err(EditError::NoSplit(end)));
        }
        assert_eq!(model, before);
    }

    #[test]
    fn closed_and_missing_curves_are_refused() {
        let mut model = small();
        let plane = PlaneIndex(4);
        let closed = model.join_curves(plane, CurveIndex(1), CurveIndex(0));
        assert_eq!(closed, Err(EditError::Closed(CurveIndex(0))));
        let missing = model.split_curve(plane, CurveIndex(9), NodeIndex(0)).unwrap_err();
        assert_eq!(missing.to_string(), "plane 4 has no curve 9");
    }

    #[test]
    fn two_nodes_do_not_close_into_a_ring() {
        let mut model = empty();
        model.insert_curve(PLANE, polyline(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)], false));
        let flat = model.join_curves(PLANE, CurveIndex(0), CurveIndex(0)).unwrap_err();
        assert!(matches!(flat, EditError::NoCurve(_)));
    }
}
