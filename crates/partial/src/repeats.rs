//! Crossings that repeat the one before: where a sample lies on the plane, up to four of its pairs
//! cross there.

use transect_geometry::Point2;

/// Distance at which two crossings are one, as a share of the distance of their samples: rounding.
const SAME: f64 = 1e-6;

/// A crossing on its way to a curve.
pub(crate) trait OnCurve {
    /// Where, in plane coordinates.
    fn position(&self) -> Point2;
    /// Distance of its samples, in the length unit.
    fn spacing(&self) -> f64;
    /// Whether pixels are missing between this crossing and the next one.
    fn bridged_after(&mut self) -> &mut bool;
}

/// Drops the crossings of a curve that repeat the one before, and of a closed one the last if it
/// repeats the first. What follows a dropped one then follows the one before it.
pub(crate) fn drop_repeats<C: OnCurve>(crossings: &mut Vec<C>, closed: bool) {
    let repeats =
        |a: &C, b: &C| (a.position() - b.position()).norm() <= SAME * a.spacing().max(b.spacing());
    crossings.dedup_by(|b, a| {
        let same = repeats(a, b);
        if same {
            *a.bridged_after() = *b.bridged_after();
        }
        same
    });
    if let (true, [first, .., last]) = (closed, crossings.as_slice())
        && repeats(first, last)
    {
        crossings.pop();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Clone, Copy, PartialEq)]
    struct At(f64, bool);

    impl OnCurve for At {
        fn position(&self) -> Point2 {
            Point2::new(self.0, 0.0)
        }
        fn spacing(&self) -> f64 {
            1.0
        }
        fn bridged_after(&mut self) -> &mut bool {
            &mut self.1
        }
    }

    #[test]
    fn units_of_no_length_go_with_what_bridged_them() {
        // The second and the third are one: the bridge between them is none. The last is the first.
        let curve = [At(0.0, false), At(1.0, true), At(1.0, false), At(2.0, true), At(0.0, true)];
        let mut open = curve.to_vec();
        drop_repeats(&mut open, false);
        assert_eq!(open, [At(0.0, false), At(1.0, false), At(2.0, true), At(0.0, true)]);
        let mut closed = curve.to_vec();
        drop_repeats(&mut closed, true);
        assert_eq!(closed, open[..3]);
        // The bridge behind a repeated one stays.
        let mut behind = vec![At(0.0, false), At(0.0, true), At(1.0, false)];
        drop_repeats(&mut behind, false);
        assert_eq!(behind, [At(0.0, true), At(1.0, false)]);
    }
}
