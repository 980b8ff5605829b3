//! Measures of one plane: areas as brackets, perimeter, centroid (dissertation, section 2.4.3).
//!
//! Problem: where a curve is open, the area of the solid is not known. One number would be wrong.
//!
//! Idea: every loop of the plane (`loops`) is the outer bound of one face, and its children are the
//! inner bounds. A face is solid if its loop runs counter-clockwise, else clear: a room, a tunnel,
//! a pipe, a hole. Its area lies in a bracket.
//!
//! 1. The estimate is the loop's area without its children's, with gaps closed by chords.
//! 2. The doubts of these loops widen the bracket to both sides. A child whose direction
//!    contradicts the loop's adds its area to the doubt.
//! 3. A face is at least 0, and at most as large as its loop.
//! 4. A loop that may be either way round may bound a face of either kind.
//! 5. Solid around such a loop, or around a clear one, has no known bound if no loop is around it.
//!    The plane's solid is then unbounded.
//!
//! 6. A loop that the usable distance of a curved guide cuts goes on beyond it. Neither kind then
//!    has a known largest area, and a face around such a loop is at least 0. The chord of the cut
//!    runs within the usable distance, so the least area of the loop's own face stays.
//!
//! What lies wholly beyond the usable distance is not in the brackets. A closed surface that no
//! view saw at all cannot be bounded, and is not in them, either.

use crate::Section;
use crate::loops::BoundaryLoop;
use std::ops::AddAssign;
use transect_geometry::{Curve, Point2, Vector2};

/// Bounds of an area or a volume, in the square or the cube of the length unit.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Bracket {
    /// Least value.
    pub least: f64,
    /// Largest value; `None` if it is not known.
    pub most: Option<f64>,
    /// The value with every gap closed by a straight chord.
    pub estimate: f64,
}

impl Bracket {
    pub(crate) const ZERO: Self = Self { least: 0.0, most: Some(0.0), estimate: 0.0 };

    pub(crate) fn times(self, factor: f64) -> Self {
        let Self { least, most, estimate } = self;
        let most = most.map(|most| most * factor);
        Self { least: least * factor, most, estimate: estimate * factor }
    }
}

impl AddAssign for Bracket {
    fn add_assign(&mut self, other: Self) {
        self.least += other.least;
        self.most = self.most.zip(other.most).map(|(a, b)| a + b);
        self.estimate += other.estimate;
    }
}

/// Measures of the curves of one plane, in the model's length unit and plane coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SectionMeasures {
    /// Area of the solid within curves that run around solid.
    pub solid: Bracket,
    /// Area of the free space that solid surrounds: rooms, tunnels, pipes, holes.
    pub clear: Bracket,
    /// Centre of mass of the estimated solid; `None` without any.
    pub solid_centroid: Option<Point2>,
    /// Centre of mass of the estimated clear area; `None` without any.
    pub clear_centroid: Option<Point2>,
    /// Whether curves end at the usable distance of a curved guide. Largest areas are unknown then,
    /// and the estimates are those of the part within that distance.
    pub is_cut: bool,
    /// Width of the widest gap between curves; 0 without gaps.
    pub widest_gap: f64,
    /// Length of the closed curves.
    pub perimeter: f64,
    /// Length of the open curves.
    pub open_length: f64,
    /// Number of closed curves around solid (counter-clockwise).
    pub outer_curves: usize,
    /// Number of closed curves around free space (clockwise).
    pub hole_curves: usize,
    /// Number of open curves.
    pub open_curves: usize,
    /// Number of closed curves that run the same way round as the curve around them. A direction is
    /// wrong there, a surface was not seen, or curves cross.
    pub contradictions: usize,
}

/// The faces of one kind.
struct Faces {
    area: Bracket,
    /// First moment of the estimate.
    moment: Vector2,
}

impl Faces {
    const NONE: Self = Self { area: Bracket::ZERO, moment: Vector2::new(0.0, 0.0) };

    fn centroid(&self, anchor: Point2) -> Option<Point2> {
        let area = self.area.estimate;
        (area > 0.0).then(|| anchor + self.moment / area)
    }
}

impl Section {
    /// Measures the curves of a plane across a straight guide.
    ///
    /// Exact for the polylines, up to rounding. The brackets hold what chords leave out where a
    /// curve bends.
    pub fn measures(&self) -> SectionMeasures {
        self.measures_within(f64::INFINITY)
    }

    /// As [`Self::measures`], for curves that were sought up to the distance `usable` from the
    /// guide: [`Guide::usable_distance`](transect_geometry::Guide::usable_distance).
    pub fn measures_within(&self, usable: f64) -> SectionMeasures {
        let loops = self.loops(usable);
        let (mut solid, mut clear) = (Faces::NONE, Faces::NONE);
        for (number, outer) in loops.iter().enumerate() {
            let within = loops.iter().filter(|inner| inner.parent == Some(number));
            add_face(outer, within, &mut solid, &mut clear);
        }
        let is_cut = loops.iter().any(|found| found.is_cut);
        if is_cut {
            (solid.area.most, clear.area.most) = (None, None);
        }
        let (closed, open): (Vec<_>, Vec<_>) = self.curves().partition(|curve| curve.is_closed());
        let length = |curves: &[&Curve]| curves.iter().fold(0.0, |sum, curve| sum + curve.length());
        let closed_loops = || loops.iter().filter(|found| found.is_closed);
        let outer_curves = closed_loops().filter(|found| found.area > 0.0).count();
        let anchor = self.envelope().min;
        SectionMeasures {
            solid: solid.area,
            clear: clear.area,
            solid_centroid: solid.centroid(anchor),
            clear_centroid: clear.centroid(anchor),
            is_cut,
            widest_gap: loops.iter().map(|found| found.widest_gap).fold(0.0, f64::max),
            perimeter: length(&closed),
            open_length: length(&open),
            outer_curves,
            hole_curves: closed.len() - outer_curves,
            open_curves: open.len(),
            contradictions: closed_loops().filter(|found| found.contradicts_parent).count(),
        }
    }
}

/// Adds the face within a loop, and outside of the loops directly in it.
fn add_face<'a>(
    outer: &BoundaryLoop,
    within: impl Iterator<Item = &'a BoundaryLoop>,
    solid: &mut Faces,
    clear: &mut Faces,
) {
    let (mut area, mut doubt, mut moment) = (outer.own_area(), outer.doubt, outer.own_moment());
    let whole = area + doubt;
    for inner in within {
        area -= inner.own_area();
        moment -= inner.own_moment();
        doubt += inner.doubt + if inner.contradicts_parent { inner.area.abs() } else { 0.0 };
        doubt += if inner.is_cut { f64::INFINITY } else { 0.0 };
    }
    if outer.parent.is_none() && (outer.is_either || !outer.is_solid) {
        solid.area.most = None;
    }
    let (own, other) = if outer.is_solid { (solid, clear) } else { (clear, solid) };
    let least = if outer.is_either { 0.0 } else { (area - doubt).max(0.0) };
    let most = Some((area + doubt).min(whole).max(0.0));
    own.area += Bracket { least, most, estimate: area };
    own.moment += moment;
    if outer.is_either {
        other.area += Bracket { most: Some(outer.doubt - outer.own_area()), ..Bracket::ZERO };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{circle, polyline, rectangle, rings, strip};
    use proptest::prelude::*;
    use std::f64::consts::{PI, TAU};

    fn section(curves: Vec<Curve>) -> Section {
        Section::new(curves).unwrap()
    }

    fn exactly(value: f64) -> Bracket {
        Bracket { least: value, most: Some(value), estimate: value }
    }

    #[test]
    fn a_plate_with_a_hole() {
        let hole = rectangle(1.0, 1.0, 2.0, 2.0).reversed();
        let plate = section(vec![rectangle(0.0, 0.0, 4.0, 3.0), hole]).measures();
        assert_eq!((plate.solid, plate.clear), (exactly(11.0), exactly(1.0)));
        assert_eq!((plate.perimeter, plate.open_length), (18.0, 0.0));
        let centroid = plate.solid_centroid.unwrap();
        // (12 · (2, 1.5) − 1 · (1.5, 1.5)) / 11
        assert!((centroid - Point2::new(22.5 / 11.0, 1.5)).norm() < 1e-12);
        assert!((plate.clear_centroid.unwrap() - Point2::new(1.5, 1.5)).norm() < 1e-12);
        assert_eq!((plate.outer_curves, plate.hole_curves, plate.open_curves), (1, 1, 0));
    }

    #[test]
    fn a_room_has_a_clear_area_and_solid_without_bound() {
        let post = rectangle(1.0, 1.0, 2.0, 2.0);
        let room = section(vec![rectangle(0.0, 0.0, 5.0, 4.0).reversed(), post]).measures();
        assert_eq!(room.clear, exactly(19.0));
        assert_eq!(room.solid, Bracket { most: None, ..exactly(1.0) });
    }

    /// A profile of 5 × 4 with a gap of 0.2 in one side, as a room and as a plate.
    #[test]
    fn a_gap_makes_the_area_a_bracket_around_it() {
        let corners = [(2.6, 0.0), (5.0, 0.0), (5.0, 4.0), (0.0, 4.0), (0.0, 0.0), (2.4, 0.0)];
        let plate = polyline(&corners, false);
        let doubt = 0.2 * 0.5 * 5.0_f64.hypot(4.0);
        for (clear, curve) in [(false, plate.clone()), (true, plate.reversed())] {
            let found = section(vec![curve]).measures();
            let (area, none) =
                if clear { (found.clear, found.solid) } else { (found.solid, found.clear) };
            assert_eq!((area.estimate, none.least, none.estimate), (20.0, 0.0, 0.0));
            assert!((area.least - (20.0 - doubt)).abs() < 1e-12, "{area:?}");
            assert!((area.most.unwrap() - (20.0 + doubt)).abs() < 1e-12, "{area:?}");
            assert_eq!(none.most, if clear { None } else { Some(0.0) });
            assert!((found.widest_gap - 0.2).abs() < 1e-12);
        }
    }

    #[test]
    fn an_open_bore_takes_at_most_its_plate() {
        let bore = circle(Point2::new(5.0, 5.0), 2.0, 100);
        let half = Curve::new(bore.nodes()[..51].to_vec(), false).unwrap().reversed();
        let found = section(vec![rectangle(0.0, 0.0, 10.0, 10.0), half]).measures();
        let exact = 100.0 - 4.0 * PI;
        assert!(found.solid.least < exact && exact < found.solid.most.unwrap(), "{found:?}");
        assert_eq!(found.solid.most, Some(100.0));
    }

    /// A post and a bore of radius 3 around (x, 0), seen up to 2.5 from the origin.
    #[test]
    fn a_section_cut_by_the_usable_distance_has_no_largest_area() {
        let (radius, usable) = (3.0, 2.5);
        let exact = PI * radius * radius;
        for x in [1.0, 1.5, 2.0, 3.0, 5.0] {
            // The circle begins at its farthest place from the origin, so one arc is left.
            let around = circle(Point2::new(x, 0.0), radius, 2000);
            let mut nodes = around.into_nodes();
            nodes.retain(|node| node.position.coords.norm() <= usable);
            let post = Curve::new(nodes, false).unwrap();
            for (is_clear, curve) in [(false, post.clone()), (true, post.reversed())] {
                let found = section(vec![curve]).measures_within(usable);
                let area = if is_clear { found.clear } else { found.solid };
                let least_and_most = (area.least <= exact, area.most.is_none_or(|m| m >= exact));
                assert_eq!(least_and_most, (true, true), "{x}: {found:?}");
                assert!(found.is_cut && found.clear.most.is_none(), "{x}: {found:?}");
            }
        }
        let near = section(vec![circle(Point2::origin(), 1.0, 100)]);
        assert_eq!(near.measures_within(usable), near.measures());
        // A cut pipe in a plate may take all of it.
        let plate = rectangle(-9.0, -9.0, 9.0, 9.0);
        let pipe = polyline(&[(2.4, 0.6), (1.0, 0.0), (2.4, -0.6)], false);
        let found = section(vec![plate, pipe]).measures_within(usable);
        assert_eq!((found.solid.least, found.solid.most), (0.0, None), "{found:?}");
    }

    #[test]
    fn a_curve_that_ends_where_it_begins_is_an_open_one() {
        let touching = polyline(&[(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 0.0)], false);
        let found = section(vec![touching]).measures();
        assert_eq!((found.solid, found.widest_gap), (exactly(1.0), 0.0));
        assert_eq!((found.outer_curves, found.hole_curves, found.open_curves), (0, 0, 1));
    }

    #[test]
    fn a_lone_open_curve_bounds_nothing() {
        let found = section(vec![strip()]).measures();
        assert_eq!((found.solid.least, found.solid.most), (0.0, None));
        assert_eq!((found.clear.least, found.clear.most.is_some()), (0.0, true));
    }

    #[test]
    fn a_piece_beside_a_plate_adds_what_its_gap_explains() {
        let (plate, piece) = (rectangle(0.0, 0.0, 30.0, 40.0), strip());
        let found = section(vec![plate, piece.reversed()]).measures();
        let doubt = 2.0 * 0.5 * 33.0_f64.hypot(41.0);
        assert_eq!((found.solid.least, found.clear), (1200.0, Bracket::ZERO));
        assert!((found.solid.most.unwrap() - 1200.0 - doubt).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn a_polygon_in_a_circle_has_its_exact_measures() {
        for n in [3, 4, 17, 1000] {
            let (radius, centre) = (2.5, Point2::new(5.0e5, 5.4e6));
            let measures = section(vec![circle(centre, radius, n)]).measures();
            let step = TAU / n as f64;
            let area = 0.5 * n as f64 * radius * radius * step.sin();
            assert!((measures.solid.estimate / area - 1.0).abs() < 1e-9, "{n}: {measures:?}");
            let perimeter = 2.0 * n as f64 * radius * (step / 2.0).sin();
            assert!((measures.perimeter / perimeter - 1.0).abs() < 1e-9);
            assert!((measures.solid_centroid.unwrap() - centre).norm() < 1e-8);
            // The stated lack of area, from the sagitta of a chord.
            let chord = radius * step;
            let lack = PI * radius * radius - area;
            assert!(n < 17 || lack < 1.01 * perimeter * chord * chord / (8.0 * radius));
        }
    }

    proptest! {
        #[test]
        fn moving_the_curves_moves_the_centroid_and_nothing_else(
            curves in rings(), x in -1e3..1e3, y in -1e3..1e3,
        ) {
            let moved = curves.iter().map(|curve| {
                let points: Vec<_> =
                    curve.nodes().iter().map(|n| (n.position.x + x, n.position.y + y)).collect();
                polyline(&points, curve.is_closed())
            });
            let moved = section(moved.collect()).measures();
            let still = section(curves).measures();
            prop_assert!((moved.solid.estimate - still.solid.estimate).abs() < 1e-9);
            prop_assert!((moved.clear.estimate - still.clear.estimate).abs() < 1e-9);
            prop_assert!((moved.perimeter - still.perimeter).abs() < 1e-9);
            let shift = moved.solid_centroid.unwrap() - still.solid_centroid.unwrap();
            prop_assert!((shift - Vector2::new(x, y)).norm() < 1e-8);
        }
    }
}
