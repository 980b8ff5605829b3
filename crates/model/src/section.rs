//! One section plane's branch of the tree: its curves, with envelopes (dissertation, section
//! 2.5.2).

use serde::{Deserialize, Serialize};
use transect_geometry::{Curve, Envelope};

/// Position of a curve among the curves of its plane, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CurveIndex(pub usize);

impl std::fmt::Display for CurveIndex {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

/// A curve with its envelope.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveRecord {
    envelope: Envelope,
    curve: Curve,
}

impl CurveRecord {
    pub(crate) fn new(curve: Curve) -> Self {
        Self { envelope: curve.envelope(), curve }
    }

    /// The curve, in plane coordinates.
    pub fn curve(&self) -> &Curve {
        &self.curve
    }

    /// The rectangle around the curve's nodes.
    pub fn envelope(&self) -> Envelope {
        self.envelope
    }

    pub(crate) fn into_curve(self) -> Curve {
        self.curve
    }
}

/// The curves on one section plane, at least one, with their common envelope.
///
/// Not checked: whether curves cross or overlap. Fusion is responsible for that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Section {
    envelope: Envelope,
    records: Vec<CurveRecord>,
}

impl Section {
    /// A section of some curves in the given order; `None` without curves.
    pub fn new(curves: Vec<Curve>) -> Option<Self> {
        let records: Vec<_> = curves.into_iter().map(CurveRecord::new).collect();
        let envelope = around(&records)?;
        Some(Self { envelope, records })
    }

    /// The rectangle around all curves of the plane.
    pub fn envelope(&self) -> Envelope {
        self.envelope
    }

    /// The curves in order.
    pub fn curves(&self) -> impl ExactSizeIterator<Item = &Curve> + DoubleEndedIterator {
        self.records.iter().map(CurveRecord::curve)
    }

    /// One curve; `None` past the last.
    pub fn curve(&self, index: CurveIndex) -> Option<&Curve> {
        self.records.get(index.0).map(CurveRecord::curve)
    }

    /// The curves in order, each with its envelope.
    pub fn curve_records(&self) -> &[CurveRecord] {
        &self.records
    }

    /// Number of nodes of all curves.
    pub fn node_count(&self) -> usize {
        self.curves().map(|c| c.nodes().len()).sum()
    }

    /// Length of all curves, in the model's length unit.
    pub fn length(&self) -> f64 {
        self.curves().map(Curve::length).sum()
    }

    /// Number of open curves.
    pub fn open_curve_count(&self) -> usize {
        self.curves().filter(|c| !c.is_closed()).count()
    }

    /// The curves in order, giving up the section.
    pub(crate) fn into_curves(self) -> Vec<Curve> {
        self.records.into_iter().map(CurveRecord::into_curve).collect()
    }
}

/// The envelope around recorded envelopes; `None` without records.
pub(crate) fn around(records: &[CurveRecord]) -> Option<Envelope> {
    records.iter().map(CurveRecord::envelope).reduce(|a, b| a.merged(&b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{rectangle, strip};

    #[test]
    fn nodes_and_lengths_of_all_curves_add_up() {
        let hole = rectangle(1.0, 1.0, 2.0, 2.0).reversed();
        let section = Section::new(vec![rectangle(0.0, 0.0, 4.0, 3.0), hole, strip()]).unwrap();
        assert_eq!(section.open_curve_count(), 1);
        assert_eq!(section.node_count(), 4 + 4 + strip().nodes().len());
        assert_eq!(section.length(), 14.0 + 4.0 + strip().length());
    }

    #[test]
    fn a_section_without_curves_does_not_exist() {
        assert!(Section::new(Vec::new()).is_none());
    }
}
