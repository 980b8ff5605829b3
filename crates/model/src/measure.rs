//! Measures of one plane: area, perimeter, centroid (dissertation, section 2.4.3).

use crate::Section;
use transect_geometry::{Curve, Point2, Vector2};

/// Measures of the curves of one plane, in the model's length unit and plane coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SectionMeasures {
    /// Area of the solid that the closed curves bound; holes count negative.
    ///
    /// Negative where the solid surrounds a hole, such as a room seen from within.
    /// # Units
    /// The square of the length unit.
    pub area: f64,
    /// Centre of mass of that area; `None` if the area is 0.
    ///
    /// On a plane with more hole than solid it is the centre of the hole.
    pub centroid: Option<Point2>,
    /// Length of the closed curves.
    pub perimeter: f64,
    /// Length of the open curves, which bound no known area.
    pub open_length: f64,
    /// Number of closed curves around solid (counter-clockwise).
    pub outer_curves: usize,
    /// Number of closed curves around free space (clockwise).
    pub hole_curves: usize,
    /// Number of open curves; if it is not 0, the area is incomplete.
    pub open_curves: usize,
}

impl Section {
    /// Measures the curves of the plane.
    ///
    /// Exact for the polylines, up to rounding; a surface bends away from a chord by about
    /// `h² / 8R` for nodes `h` apart on a radius `R`, and the area lacks that times the perimeter.
    /// Curves that cross themselves or each other count overlaps twice.
    pub fn measures(&self) -> SectionMeasures {
        let (closed, open): (Vec<_>, Vec<_>) = self.curves().partition(|curve| curve.is_closed());
        let length = |curves: &[&Curve]| curves.iter().fold(0.0, |sum, curve| sum + curve.length());
        let outer = closed.iter().filter(|c| c.signed_area().is_some_and(|a| a > 0.0)).count();
        let anchor = self.envelope().min;
        let moments = closed.iter().map(|curve| moments(curve, &anchor));
        let (area, first) =
            moments.fold((0.0, Vector2::zeros()), |(a, m), (da, dm)| (a + da, m + dm));
        SectionMeasures {
            area,
            centroid: (area != 0.0).then(|| anchor + first / area),
            perimeter: length(&closed),
            open_length: length(&open),
            outer_curves: outer,
            hole_curves: closed.len() - outer,
            open_curves: open.len(),
        }
    }
}

/// Signed area of a closed curve and its first moment about `anchor`, by triangles from there.
///
/// An anchor close to the curve keeps the precision of world-sized coordinates.
fn moments(curve: &Curve, anchor: &Point2) -> (f64, Vector2) {
    curve.units().fold((0.0, Vector2::zeros()), |(area, moment), unit| {
        let (a, b) = (unit.start - anchor, unit.end - anchor);
        let triangle = 0.5 * a.perp(&b);
        (area + triangle, moment + (a + b) * (triangle / 3.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::samples::{circle, polyline, rectangle, rings, strip};
    use proptest::prelude::*;
    use std::f64::consts::TAU;

    fn section(curves: Vec<Curve>) -> Section {
        Section::new(curves).unwrap()
    }

    #[test]
    fn a_plate_with_a_hole_and_a_loose_strip() {
        let hole = rectangle(1.0, 1.0, 2.0, 2.0).reversed();
        let plate = section(vec![rectangle(0.0, 0.0, 4.0, 3.0), hole, strip()]).measures();
        assert_eq!((plate.area, plate.perimeter, plate.open_length), (11.0, 18.0, 2.0));
        let centroid = plate.centroid.unwrap();
        // (12 · (2, 1.5) − 1 · (1.5, 1.5)) / 11
        assert!((centroid - Point2::new(22.5 / 11.0, 1.5)).norm() < 1e-12);
        assert_eq!((plate.outer_curves, plate.hole_curves, plate.open_curves), (1, 1, 1));
    }

    #[test]
    fn a_polygon_in_a_circle_has_its_exact_measures() {
        for n in [3, 4, 17, 1000] {
            let (radius, centre) = (2.5, Point2::new(5.0e5, 5.4e6));
            let measures = section(vec![circle(centre, radius, n)]).measures();
            let step = TAU / n as f64;
            let area = 0.5 * n as f64 * radius * radius * step.sin();
            assert!((measures.area / area - 1.0).abs() < 1e-9, "{n}: {}", measures.area);
            let perimeter = 2.0 * n as f64 * radius * (step / 2.0).sin();
            assert!((measures.perimeter / perimeter - 1.0).abs() < 1e-9);
            assert!((measures.centroid.unwrap() - centre).norm() < 1e-8);
            // The stated lack of area, from the sagitta of a chord.
            let chord = radius * step;
            let lack = std::f64::consts::PI * radius * radius - area;
            assert!(n < 17 || lack < 1.01 * perimeter * chord * chord / (8.0 * radius));
        }
    }

    #[test]
    fn open_curves_alone_have_no_area_and_no_centroid() {
        let open = section(vec![strip()]).measures();
        assert_eq!((open.area, open.centroid, open.perimeter), (0.0, None, 0.0));
        let room = section(vec![rectangle(0.0, 0.0, 2.0, 1.0).reversed()]).measures();
        assert_eq!((room.area, room.hole_curves), (-2.0, 1));
        assert_eq!(room.centroid, Some(Point2::new(1.0, 0.5)));
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
            prop_assert!((moved.area - still.area).abs() < 1e-9);
            prop_assert!((moved.perimeter - still.perimeter).abs() < 1e-9);
            let shift = moved.centroid.unwrap() - still.centroid.unwrap();
            prop_assert!((shift - Vector2::new(x, y)).norm() < 1e-8);
            prop_assert_eq!(still.area, still.area.abs());
        }
    }
}
