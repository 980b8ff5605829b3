//! Figures of the curves of one plane, without a truth.

use super::Ruler;
use super::index::{IndexedUnit, UnitIndex};
use super::sample::{GROUP, Sample, runs};
use transect_geometry::Curve;

/// Distance along a curve, in tolerances, from which two of its pieces count as different. Chosen
/// by hand. Halved, the inside of narrow bends counts as duplicated; doubled, short loops that run
/// twice around the same thing are missed.
const APART_TOLERANCES: f64 = 10.0;

/// Cosine of the largest angle, 60°, between pieces of the same direction. Chosen by hand: the
/// faces of a thin wall run in opposite directions, and curves that cross are not duplicates.
const SAME_DIRECTION: f64 = 0.5;

/// Counts and lengths of curves; lengths in the model's unit.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Own {
    pub pieces: usize,
    pub closed: usize,
    pub vertices: usize,
    pub length: f64,
    /// Length that runs beside another piece of the same direction.
    pub duplicated: f64,
}

impl Own {
    /// The sums of one plane, whose units are in the index.
    pub fn of(curves: &[Curve], index: &UnitIndex, ruler: &Ruler) -> Self {
        let mut own = Self::default();
        for (number, curve) in curves.iter().enumerate() {
            own.pieces += 1;
            own.closed += usize::from(curve.is_closed());
            own.vertices += curve.nodes().len();
            let placed = (number, curve.length());
            for run in runs(curve, ruler.step) {
                run.chunks(GROUP).for_each(|group| own.add(group, placed, index, ruler));
            }
        }
        own
    }

    /// Adds samples of a curve beside each other; the curve is given by its number and length.
    fn add(
        &mut self,
        group: &[Sample],
        (number, total): (usize, f64),
        index: &UnitIndex,
        ruler: &Ruler,
    ) {
        let counts = |u: &IndexedUnit| u.curve != number || can_be_apart(group, u, ruler);
        let nearby = index.within(group, ruler.tolerance, counts);
        for sample in group {
            let another = |u: &IndexedUnit| u.curve != number || is_apart(sample, u, total, ruler);
            let same_way =
                |u: &IndexedUnit| sample.direction.dot(&u.placed.direction) > SAME_DIRECTION;
            let mut near = nearby.within(&sample.position, ruler.tolerance);
            self.length += sample.length;
            if near.any(|u| same_way(u) && another(u)) {
                self.duplicated += sample.length;
            }
        }
    }

    /// The sum over planes.
    pub fn total(planes: Vec<Self>) -> Self {
        planes.into_iter().fold(Self::default(), |a, b| Self {
            pieces: a.pieces + b.pieces,
            closed: a.closed + b.closed,
            vertices: a.vertices + b.vertices,
            length: a.length + b.length,
            duplicated: a.duplicated + b.duplicated,
        })
    }
}

/// Whether a unit of the same curve is so long, or so far along it, that [`is_apart`] may hold for
/// a sample of a group.
fn can_be_apart(group: &[Sample], unit: &IndexedUnit, ruler: &Ruler) -> bool {
    let ends = group.first().zip(group.last());
    let farthest = ends.map(|(first, last)| {
        let after = unit.placed.before + unit.placed.length - first.along;
        after.max(last.along - unit.placed.before)
    });
    farthest.is_some_and(|length| length > APART_TOLERANCES * ruler.tolerance)
}

/// Whether the point of a unit nearest to a sample of the same curve is another piece of that
/// curve.
///
/// The curve's ends count as neighbours even if it is open: where it nearly closes, its ends may
/// overlap a little.
fn is_apart(sample: &Sample, unit: &IndexedUnit, total: f64, ruler: &Ruler) -> bool {
    let t = unit.placed.unit.parameter(&sample.position).clamp(0.0, 1.0);
    let direct = (unit.placed.before + t * unit.placed.length - sample.along).abs();
    direct.min(total - direct) > APART_TOLERANCES * ruler.tolerance
}
