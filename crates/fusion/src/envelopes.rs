//! Maximum-enclosure envelopes of the curves of a plane, with a tolerance (dissertation 5.3.1).
//!
//! **Problem.** A curve that arrives must find the few curves of a plane it may overlap, however
//! many there are.
//!
//! **Idea.** Two curves that overlap have envelopes that meet: necessary, not sufficient, and
//! cheap. Each is exchanged when its curve grows.
//!
//! **Steps.**
//! 1. Each curve's envelope is grown by the tolerance, so that curves side by side are not missed.
//! 2. Each of a plane's envelopes is compared with that of a new curve. Where both meet, their
//!    common rectangle limits the search for overlaps (5.3.2).
//!
//! **Cost.** O(n) to find the curves that meet one, for n curves of the plane: comparing rectangles
//! is cheap beside merging curves.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::collections::BTreeMap;
use transect_geometry::{Curve, CurveUnit, Envelope, Point2};

/// Largest coordinate the tree sees: the square of an envelope's area would overflow beyond it.
/// What lies farther out meets more envelopes than it should, never fewer.
const LARGEST_COORDINATE: f64 = 1e75;

/// The envelopes of the curves of a plane, by the curves' numbers.
#[derive(Debug, Clone, Default)]
pub struct PlaneEnvelopes {
    tolerance: f64,
    by_curve: BTreeMap<usize, Envelope>,
}

/// A curve whose envelope meets another's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeMeeting {
    /// The number of the curve.
    pub curve: usize,
    /// The rectangle common to both grown envelopes: no overlap lies outside it.
    pub common: Envelope,
}

impl PlaneEnvelopes {
    /// No envelopes yet. Each will be grown by `tolerance`, in the curves' length unit.
    pub fn new(tolerance: f64) -> Self {
        Self { tolerance, by_curve: BTreeMap::new() }
    }

    /// Takes a curve in, or exchanges the envelope of one that has grown.
    pub fn insert(&mut self, number: usize, curve: &Curve) {
        self.by_curve.insert(number, curve.envelope().grown(self.tolerance));
    }

    /// Forgets a curve; its grown envelope, if it was there.
    pub fn remove(&mut self, number: usize) -> Option<Envelope> {
        self.by_curve.remove(&number)
    }

    /// The curves whose grown envelopes meet that of a curve, grown as well, in order of number.
    pub fn meeting(&self, curve: &Curve) -> Vec<EnvelopeMeeting> {
        let around = curve.envelope().grown(self.tolerance);
        let meeting = |(&curve, envelope): (&usize, &Envelope)| {
            Some(EnvelopeMeeting { curve, common: envelope.intersection(&around)? })
        };
        self.by_curve.iter().filter_map(meeting).collect()
    }
}

/// The numbered box of a unit in a tree.
type Entry = GeomWithData<Rectangle<[f64; 2]>, usize>;

fn aabb(envelope: &Envelope) -> AABB<[f64; 2]> {
    let corner = |p: &Point2| [p.x, p.y].map(|c| c.clamp(-LARGEST_COORDINATE, LARGEST_COORDINATE));
    AABB::from_corners(corner(&envelope.min), corner(&envelope.max))
}

/// Curve units, for finding those near a place.
#[derive(Debug)]
pub(crate) struct UnitIndex {
    units: Vec<CurveUnit>,
    tree: RTree<Entry>,
}

impl UnitIndex {
    /// The units of some curves, numbered on from one curve to the next.
    pub fn new<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> Self {
        Self::of(curves.into_iter().flat_map(Curve::units).collect(), |_| true)
    }

    /// The units of a curve whose envelopes meet a rectangle, by their place along the curve.
    pub fn within(curve: &Curve, rectangle: &Envelope) -> Self {
        Self::of(curve.units().collect(), |around| around.intersects(rectangle))
    }

    fn of(units: Vec<CurveUnit>, wanted: impl Fn(&Envelope) -> bool) -> Self {
        let all = units.iter().map(CurveUnit::envelope).enumerate().filter(|(_, e)| wanted(e));
        let tree = RTree::bulk_load(all.map(|(k, e)| Entry::new(aabb(&e).into(), k)).collect());
        Self { units, tree }
    }

    /// A unit by its number.
    pub fn unit(&self, number: usize) -> Option<&CurveUnit> {
        self.units.get(number)
    }

    /// Whether a unit is within a distance of a place. `numbers` is memory for the search.
    pub fn is_near(&self, place: &Point2, distance: f64, numbers: &mut Vec<usize>) -> bool {
        self.near(place, distance, numbers);
        numbers.iter().any(|k| self.units[*k].distance(place) <= distance)
    }

    /// Writes the numbers of all units that may be within a distance of a place into `numbers`, in
    /// their order along the curve.
    pub fn near(&self, place: &Point2, distance: f64, numbers: &mut Vec<usize>) {
        // Rounding must not lose a unit that is only just near enough.
        let reach = distance * (1.0 + 1e-9) + 4.0 * f64::EPSILON * place.coords.amax();
        let around = Envelope { min: *place, max: *place }.grown(reach);
        numbers.clear();
        let near = self.tree.locate_in_envelope_intersecting(aabb(&around));
        numbers.extend(near.map(|entry| entry.data));
        numbers.sort_unstable();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use transect_geometry::Node;

    fn line(from: (f64, f64), to: (f64, f64)) -> Curve {
        let nodes = [from, to].map(|(x, y)| Node::at(Point2::new(x, y)));
        Curve::new(nodes.to_vec(), false).unwrap()
    }

    fn lines() -> impl Strategy<Value = Curve> {
        let place = || (-9.0..9.0, -9.0..9.0);
        let size = || (-2.0..2.0, -2.0..2.0);
        (place(), size()).prop_map(|((x, y), (u, v))| line((x, y), (x + u, y + v)))
    }

    /// A change of a plane: a curve arrives, grows or goes.
    #[derive(Debug, Clone)]
    enum Step {
        Insert(usize, Curve),
        Remove(usize),
    }

    fn steps() -> impl Strategy<Value = Vec<Step>> {
        let insert = (0..12_usize, lines()).prop_map(|(k, c)| Step::Insert(k, c));
        let remove = (0..12_usize).prop_map(Step::Remove);
        prop::collection::vec(prop_oneof![3 => insert, 1 => remove], 0..40)
    }

    proptest! {
        #[test]
        fn envelopes_keep_up_with_their_curves(steps in steps(), asked in lines()) {
            let tolerance = 0.25;
            let mut envelopes = PlaneEnvelopes::new(tolerance);
            let mut curves = BTreeMap::new();
            for step in steps {
                match step {
                    Step::Insert(k, curve) => {
                        envelopes.insert(k, &curve);
                        curves.insert(k, curve);
                    }
                    Step::Remove(k) => {
                        let gone = curves.remove(&k).map(|c| c.envelope().grown(tolerance));
                        prop_assert_eq!(envelopes.remove(k), gone);
                    }
                }
            }
            let around = asked.envelope().grown(tolerance);
            let meeting = |(&curve, c): (&usize, &Curve)| {
                let common = c.envelope().grown(tolerance).intersection(&around)?;
                Some(EnvelopeMeeting { curve, common })
            };
            let expected: Vec<_> = curves.iter().filter_map(meeting).collect();
            prop_assert_eq!(envelopes.meeting(&asked), expected);
        }
    }

    #[test]
    fn coordinates_of_any_size_are_met() {
        let wide = line((-1e300, 2e300), (1e300, -1.5e308));
        let mut envelopes = PlaneEnvelopes::new(0.1);
        envelopes.insert(0, &wide);
        envelopes.insert(1, &line((0.0, 0.0), (1.0, 1.0)));
        for k in 2..40 {
            envelopes.insert(k, &wide);
        }
        assert_eq!(envelopes.meeting(&wide).len(), 40);
        assert_eq!(envelopes.remove(3), Some(wide.envelope().grown(0.1)));
        assert_eq!(envelopes.meeting(&line((2e300, 2e300), (3e300, 3e300))).len(), 0);
    }
}
