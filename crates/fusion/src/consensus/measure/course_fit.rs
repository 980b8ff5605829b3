//! The parabola of least squares through the beads of a window. A view counts by its error.

use super::super::tuning::settle::{LEAST_BENT, LEAST_VARIANCE};

/// The course y = offset + slope · x + bend · x², with x in half-lengths of the window.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Parabola {
    pub offset: f64,
    pub slope: f64,
    pub bend: f64,
    /// The straight course through the same samples.
    pub straight_offset: f64,
    pub straight_slope: f64,
    /// Mean square of x² after its best line in x is subtracted; 0 if too small to tell a bend.
    pub bent: f64,
}

impl Parabola {
    /// y of the course at x.
    pub fn at(&self, x: f64) -> f64 {
        self.offset + (self.slope + self.bend * x) * x
    }

    /// Its slope at x, in lengths across for a half-length along.
    pub fn slope_at(&self, x: f64) -> f64 {
        self.slope + 2.0 * self.bend * x
    }

    /// y of the straight course at x.
    pub fn straight_at(&self, x: f64) -> f64 {
        self.straight_offset + self.straight_slope * x
    }
}

/// Weighted sums for a parabola y(x) through beads, with x in half-lengths of the window. The
/// weights are lengths, in half-lengths too.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    pub length: f64,
    x: f64,
    xx: f64,
    xxx: f64,
    xxxx: f64,
    y: f64,
    xy: f64,
    xxy: f64,
    variance: f64,
}

impl Sums {
    pub fn add(&mut self, length: f64, x: f64, y: f64, variance: f64) {
        let xx = x * x;
        let (xxx, xxxx, xy, xxy) = (x * xx, xx * xx, x * y, xx * y);
        self.add_share(&Self { length: 1.0, x, xx, xxx, xxxx, y, xy, xxy, variance }, length);
    }

    fn add_share(&mut self, other: &Self, share: f64) {
        self.length += share * other.length;
        self.x += share * other.x;
        self.xx += share * other.xx;
        self.xxx += share * other.xxx;
        self.xxxx += share * other.xxxx;
        self.y += share * other.y;
        self.xy += share * other.xy;
        self.xxy += share * other.xxy;
        self.variance += share * other.variance;
    }

    /// Adds the sums of one view. How densely it measured the window does not count.
    pub fn add_view(&mut self, view: &Self) {
        if view.length > 0.0 {
            self.add_share(view, view.share() / view.length);
        }
    }

    /// The weight of a view: the part of the window that it measured, over its variance.
    pub fn share(&self) -> f64 {
        if self.length > 0.0 { self.length.min(1.0) / self.mean_variance() } else { 0.0 }
    }

    /// The view's part in the variance of a sum of all views by their weights. 0 where no bead of
    /// the view has a length in the window: such a view has no mean variance, and no weight.
    pub fn added_variance(&self) -> f64 {
        if self.length > 0.0 { self.share().powi(2) * self.mean_variance() } else { 0.0 }
    }

    /// Variance of the view's error, averaged over the window.
    pub fn mean_variance(&self) -> f64 {
        self.variance / self.length
    }

    /// Mean distance of the samples from a course.
    pub fn mean_off(&self, course: &Parabola) -> f64 {
        (self.y - course.slope * self.x - course.bend * self.xx) / self.length - course.offset
    }

    /// The parabola of least squares. Samples all in one place have neither slope nor bend.
    pub fn parabola(&self) -> Parabola {
        if self.length <= 0.0 {
            return Parabola::default();
        }
        let mean = |sum: f64| sum / self.length;
        let (x, y, xx) = (mean(self.x), mean(self.y), mean(self.xx));
        let variance = xx - x * x;
        if variance <= LEAST_VARIANCE {
            return Parabola { offset: y, straight_offset: y, ..Parabola::default() };
        }
        // x² after its best line in x is subtracted.
        let along = (mean(self.xxx) - x * xx) / variance;
        let bent = mean(self.xxxx) - xx * xx - along * along * variance;
        let straight_slope = (mean(self.xy) - x * y) / variance;
        let straight_offset = y - straight_slope * x;
        let bend = (mean(self.xxy) - xx * y - along * straight_slope * variance) / bent;
        let (bend, bent) = if bent > LEAST_BENT { (bend, bent) } else { (0.0, 0.0) };
        let slope = straight_slope - along * bend;
        Parabola {
            offset: y - slope * x - bend * xx,
            slope,
            bend,
            straight_offset,
            straight_slope,
            bent,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sums of one view whose samples are `y(x)`, evenly from `from` to 1.
    fn sums(from: f64, y: impl Fn(f64) -> f64) -> Sums {
        let mut sums = Sums::default();
        for k in 0..=200 {
            let x = from + (1.0 - from) * f64::from(k) / 200.0;
            sums.add(0.01, x, y(x), 1.0);
        }
        sums
    }

    #[test]
    fn samples_of_a_parabola_have_that_parabola() {
        for from in [-1.0, -0.3, 0.4] {
            let mut common = Sums::default();
            common.add_view(&sums(from, |x| 0.3 - 0.2 * x + 0.7 * x * x + 0.1));
            common.add_view(&sums(from, |x| 0.3 - 0.2 * x + 0.7 * x * x - 0.1));
            let found = common.parabola();
            for (found, expected) in [(found.offset, 0.3), (found.slope, -0.2), (found.bend, 0.7)] {
                assert!((found - expected).abs() < 1e-9, "{found} {expected} from {from}");
            }
        }
    }

    #[test]
    fn views_count_by_their_variance_and_not_by_their_density() {
        let view = |y: f64, variance: f64, density: f64| {
            let mut sums = Sums::default();
            for k in -100..=100 {
                sums.add(0.01 * density, f64::from(k) / 100.0, y, variance);
            }
            sums
        };
        for density in [1.0, 7.0] {
            let mut common = Sums::default();
            common.add_view(&view(1.0, 1.0, density));
            common.add_view(&view(0.0, 4.0, 1.0));
            let found = common.parabola();
            assert!((found.offset - 0.8).abs() < 1e-9 && found.bend.abs() < 1e-9, "{found:?}");
        }
    }

    #[test]
    fn the_straight_course_lies_inside_a_bend_and_has_no_bend() {
        let found = sums(-1.0, |x| x * x).parabola();
        // The mean of x² over an even window is a third.
        assert!((found.straight_offset - 1.0 / 3.0).abs() < 0.01 && found.offset.abs() < 1e-9);
        assert!(found.straight_slope.abs() < 1e-9);
    }

    #[test]
    fn samples_in_one_place_have_neither_slope_nor_bend() {
        let place = |x: f64| sums(0.99, move |_| x).parabola();
        let found = place(0.25);
        assert_eq!((found.slope, found.bend, found.bent), (0.0, 0.0, 0.0));
        assert!((found.offset - 0.25).abs() < 1e-12);
        assert_eq!(Sums::default().parabola().offset, 0.0);
        assert_eq!(Sums::default().added_variance(), 0.0);
    }
}
