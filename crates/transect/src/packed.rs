//! Curves as they wait for their fusion: most of the memory of a run.

use transect_geometry::{Curve, EndReason, Node, Point2};

/// The curves of one view on one plane, in 44 bytes per node in place of 64.
///
/// Every number is kept, but for weights and view counts: a node of one view has 1 of each.
#[derive(Debug, Default)]
pub(crate) struct PackedCurves {
    curves: Box<[Shape]>,
    /// Places of the nodes of all curves, one curve after the other.
    places: Box<[Point2]>,
    measures: Box<[Measures]>,
    /// Numbers of the nodes where bridged units begin; sorted.
    bridged: Box<[u32]>,
}

/// The properties of a curve besides its nodes.
#[derive(Debug)]
struct Shape {
    nodes: u32,
    closed: bool,
    ends: [Option<EndReason>; 2],
}

/// The properties of a node besides its place.
#[derive(Debug)]
struct Measures {
    sigma: f32,
    footprint: f32,
    correlation: f32,
    /// 0 if it is not known, as in files.
    tan_incidence: f32,
    /// 0 if it is not known, as in files.
    normal: [f32; 3],
}

impl PackedCurves {
    /// Packs curves of one view.
    pub fn new(curves: &[Curve]) -> Self {
        let nodes = || curves.iter().flat_map(Curve::nodes);
        let shape = |curve: &Curve| Shape {
            nodes: curve.nodes().len() as u32,
            closed: curve.is_closed(),
            ends: curve.ends(),
        };
        let mut measures = Vec::with_capacity(nodes().count());
        measures.extend(nodes().map(Measures::of));
        let mut places = Vec::with_capacity(measures.len());
        places.extend(nodes().map(|node| node.position));
        let bridged = nodes().zip(0_u32..).filter(|(node, _)| node.bridged);
        Self {
            curves: curves.iter().map(shape).collect(),
            places: places.into(),
            measures: measures.into(),
            bridged: bridged.map(|(_, k)| k).collect(),
        }
    }

    /// The curves, unpacked.
    pub fn curves(&self) -> Vec<Curve> {
        let (mut places, mut measures) = (&*self.places, &*self.measures);
        let mut first = 0_u32;
        let curve = |shape: &Shape| {
            let count = shape.nodes as usize;
            let nodes = places.iter().zip(measures).take(count);
            let mut nodes: Vec<Node> = nodes.map(|(place, m)| m.node(*place)).collect();
            let from = self.bridged.partition_point(|k| *k < first);
            for k in self.bridged[from..].iter().take_while(|k| **k < first + shape.nodes) {
                nodes[(k - first) as usize].bridged = true;
            }
            (places, measures) = (&places[count..], &measures[count..]);
            first += shape.nodes;
            Some(Curve::new(nodes, shape.closed).ok()?.with_ends(shape.ends))
        };
        self.curves.iter().filter_map(curve).collect()
    }
}

impl Measures {
    fn of(node: &Node) -> Self {
        Self {
            sigma: node.sigma,
            footprint: node.footprint,
            correlation: node.correlation,
            tan_incidence: node.tan_incidence.unwrap_or_default(),
            normal: node.normal.unwrap_or_default().into(),
        }
    }

    fn node(&self, place: Point2) -> Node {
        Node::at(place)
            .with_sigma(self.sigma)
            .with_footprint(self.footprint)
            .with_correlation(self.correlation)
            .with_tan_incidence(Some(self.tan_incidence).filter(|tan| *tan != 0.0))
            .with_normal(Some(self.normal.into()).filter(|_| self.normal != [0.0; 3]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn packed_curves_come_back_as_they_were() {
        let node = |k: usize| {
            let at = Node::at(Point2::new(0.1 * k as f64, (k as f64).sin()));
            let at = at.with_sigma(1e-3).with_footprint(0.1 / (k + 1) as f32);
            let normal = (!k.is_multiple_of(3)).then(|| Vector3::new(0.6, 0.0, -0.8));
            at.with_correlation(k as f32)
                .with_tan_incidence((!k.is_multiple_of(2)).then_some(0.75))
                .with_normal(normal)
                .with_bridged(k % 4 == 1)
        };
        let curve = |nodes: std::ops::Range<usize>, closed| {
            Curve::new(nodes.map(node).collect(), closed).unwrap()
        };
        let ends = [Some(EndReason::ImageBorder), None];
        let curves = [curve(0..7, false).with_ends(ends), curve(3..9, true), curve(1..3, false)];
        assert_eq!(PackedCurves::new(&curves).curves(), curves);
        assert_eq!(PackedCurves::default().curves(), []);
    }
}
