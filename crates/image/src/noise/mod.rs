//! Range noise of a view: as stated, or estimated from the image itself.

mod differences;
mod growth;

use crate::tuning::MOSTLY_SHARED;
use differences::{Values, count, differences, smaller_spread};
use growth::Growth;
use transect_device::{DeviceFrame, Pixel, RangeImage, View, median};

/// Most rows, and rows of groups down the columns, in an estimate. No unit.
///
/// Measured with 64 instead of 128: the median and 95 % distances of six simulated scans by depth
/// cameras change by at most 1 %. At refined poses the medians of nine scans change by -4 to 16 %,
/// and with 480 those of six by -5 to 21 %, which is chance. Doubled, it takes twice the time.
const LINES: usize = 64;

/// The same where 10 % are enough: in a check of a stated noise, and to tell whether neighbours
/// share most of it. Chosen by hand. Doubled, both take twice the time.
const CHECKED_LINES: usize = 32;

/// Factor between a stated and an estimated noise, either way, from which they contradict each
/// other. No unit. Chosen by hand: texture and smoothing inside a sensor explain less, wrong units
/// more. Doubled, a sigma of five times the noise passes, and smoothing flattens small features.
const CONTRADICTION: f64 = 3.0;

/// Factor by which an estimate from every second pixel exceeds that from all where the surface's
/// bends dominate. No unit. Theory: noise gives 1, a smooth bend 8. Measured: noise that neighbours
/// share grows by up to 2.1 from 4 to 8 pixels in the red kitchen, the bunny's surface by 2.5 and
/// more. Doubled, bends pass for noise.
const BEND: f64 = 2.25;

/// Largest growth of the estimate from all pixels to every second one that is noise. No unit.
/// Theory: neighbours in one matching window or one step of disparity hardly differ, so the noise
/// that they share may grow by more there than [`BEND`]. Measured: the red kitchen has up to 2.5;
/// with 2, 14 of its 50 images would share no noise. Doubled, only the next doublings tell bends
/// from noise.
const FIRST_BEND: f64 = 3.0;

/// Distances, in pixels, at which the noise that neighbours share is looked for. Measured: in
/// images of structured light the differences grow up to 8 or 12 pixels. Doubled, furniture passes
/// for noise.
const APART: [usize; 3] = [2, 4, 8];

/// Distance, in pixels, at which the differences no longer grow by [`BEND`] with each doubling, if
/// noise alone makes them. Measured, from the distance before: structured light at 640 × 480
/// pixels has 1.1 to 1.6, the pipes of a plant room 2.9. Halved, pipes pass for noise.
const FAR_APART: usize = 16;

/// Least factor of the differences at 4 pixels over those of neighbours, where they no longer grow.
/// No unit. Measured: structured light has 1.3 and more, rooms and parts without shared noise have
/// up to 1.06, and round things up to 1.16. Doubled, hardly any camera shares noise.
const SHARED: f64 = 1.25;

/// The same where they grow on, as where furniture is small in the image. Measured: a simulated
/// kitchen at 320 × 240 pixels has 1.9 and more; the plant room, without shared noise, 1.42.
/// Doubled, no camera shares noise there.
const CLEARLY_SHARED: f64 = 1.65;

/// Most differences of neighbours for each one of farther pixels. Chosen by hand: small things have
/// none of the latter. Doubled, a ball of twelve pixels passes for noise.
const FEWEST: usize = 4;

/// Share of differences that are exactly 0 from which the steps of the values hide the noise.
/// Theory: noise of half a step gives 0.18. Doubled, steps pass for noise.
const ZEROS: f64 = 0.25;

/// Noise of an image that may be stated to have none, as a share of its median value. No unit.
/// Measured: simulated images without noise have up to 2e-5, where rays stop a little before a
/// surface or behind it. Scanners and depth cameras have 1e-4 and more. Doubled, a scanner with
/// 1.5 mm at 10 m may be stated to have none.
const EXACT: f64 = 1e-4;

/// Pixels along each side of the lattice on which lengths per value are found. Chosen by hand; the
/// median of 2 304 of them is known to about 3 %.
const LATTICE: usize = 48;

/// Step of a value in [`length_per_value`], as a share of the value. Chosen by hand: far above
/// rounding, and far below the change of the rate.
const VALUE_STEP: f64 = 1.0 / 1024.0;

/// How noisy the ranges of a view are.
///
/// A stated noise is a length along the ray, the same at every pixel. An estimated one is in the
/// unit of the image's values: a triangulation sensor errs by a distance on its detector, which
/// stands for more length far away than nearby. It is the same for all values, or grows with their
/// square, as that of a depth camera does; the image itself tells which.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RangeNoise {
    known: Known,
    length: f64,
    /// The noise that neighbours share, over the one that each pixel has of its own.
    shared: f64,
    /// The noise of both kinds, over the one that each pixel has of its own.
    both: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Known {
    Length(f64),
    Value(f64, Growth),
}

impl RangeNoise {
    /// The noise that a view states; estimated if it states none.
    pub fn of(view: &View) -> Self {
        Self::of_lines(view, LINES)
    }

    /// The same from half the rows, in half the time.
    pub fn of_fewer_rows(view: &View) -> Self {
        Self::of_lines(view, CHECKED_LINES)
    }

    fn of_lines(view: &View, lines: usize) -> Self {
        if let Some(sigma) = view.sigma() {
            return Self { known: Known::Length(sigma), length: sigma, shared: 0.0, both: 1.0 };
        }
        let growth = Growth::of(view.image());
        let image = growth.with_even_noise(view.image());
        let neighbours = differences(&image, lines, 1);
        let enough = count(&neighbours) / FEWEST;
        let value = smaller_spread(neighbours);
        let shared = shared_noise((&image, lines), value, enough).unwrap_or(0.0);
        let length = value * median_length(view, growth);
        Self { known: Known::Value(value, growth), length, shared, both: 1.0_f64.hypot(shared) }
    }

    /// The noise that each pixel has of its own, as stated or estimated; as estimated, too, where
    /// the image clearly has more noise than is stated. It takes less time than [`RangeNoise::of`].
    pub fn of_pixels(view: &View) -> Self {
        let (known, length) = match view.sigma() {
            Some(stated) => {
                let seen = seen_beside(view, stated).map_or(stated, |seen| seen.length);
                let sigma = stated.max(seen);
                (Known::Length(sigma), sigma)
            }
            None => estimated(view),
        };
        Self { known, length, shared: 0.0, both: 1.0 }
    }

    /// The estimate, as a length, where it contradicts the noise that a view states.
    ///
    /// `None` where the image cannot tell: its values have steps as large as the noise, or the
    /// bends of its surfaces exceed the stated noise. A stated 0 declares an image without noise;
    /// only clearly noisy images contradict it.
    pub fn contradicting(view: &View) -> Option<f64> {
        let stated = view.sigma()?;
        let seen = seen_beside(view, stated)?;
        (stated > 0.0 || seen.value > EXACT * median_size(view.image())).then_some(seen.length)
    }

    /// Standard deviation along the ray at the view's median pixel, in the model's length unit.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// Standard deviation of the noise that neighbouring pixels share, over that of the noise that
    /// each pixel has of its own; 0 for a stated noise.
    ///
    /// Matching windows and disparity steps of a depth camera move whole groups of pixels. The
    /// estimate compares pixels farther and farther apart; without shared noise it stays the same.
    pub fn shared(&self) -> f64 {
        self.shared
    }

    /// Whether neighbouring pixels share most of the noise, as those of depth cameras do.
    pub fn is_mostly_shared(&self) -> bool {
        self.shared >= MOSTLY_SHARED
    }

    /// The same noise as if neighbouring pixels shared none of it.
    pub(crate) fn own(self) -> Self {
        Self { shared: 0.0, both: 1.0, ..self }
    }

    /// Standard deviation of a value at a pixel with this [`length_per_value`]: of the pixel's own
    /// noise, and of the noise that it shares with its neighbours.
    pub fn value_sigma(&self, value: f64, length_per_value: f64) -> f64 {
        match self.known {
            Known::Length(sigma) => sigma / length_per_value,
            Known::Value(sigma, growth) => sigma * self.both * growth.factor(value),
        }
    }

    /// Standard deviation along the ray at a pixel of a view, in the model's length unit.
    pub fn length_at(&self, view: &View, pixel: Pixel) -> f64 {
        match self.known {
            Known::Length(sigma) => sigma,
            Known::Value(sigma, growth) => {
                let d3 = view.image().get(pixel).map(f64::from);
                let length =
                    d3.and_then(|d3| length_per_even_value(view.frame(), (pixel, d3), growth));
                length.map_or(self.length, |length| sigma * length)
            }
        }
    }
}

/// An estimate that contradicts a stated noise.
struct Seen {
    /// In the unit of the image's values.
    value: f64,
    length: f64,
}

/// The estimate where it contradicts the stated noise of a view.
fn seen_beside(view: &View, stated: f64) -> Option<Seen> {
    let values = Growth::Same.with_even_noise(view.image());
    let of = |stride| differences(&values, CHECKED_LINES, stride);
    let differences = of(1);
    let zeros = |d: &Vec<f32>| d.iter().filter(|d| **d == 0.0).count() as f64;
    if differences.iter().any(|d| zeros(d) > ZEROS * d.len() as f64) {
        return None;
    }
    let value = smaller_spread(differences);
    let length = value * median_length(view, Growth::Same);
    let too_small = stated > CONTRADICTION * length;
    let too_large =
        || length > CONTRADICTION * stated && smaller_spread(of(2)) < FIRST_BEND * value;
    (length > 0.0 && (too_small || too_large())).then_some(Seen { value, length })
}

/// Median size of an image's values; 0 without any.
fn median_size(image: &RangeImage) -> f64 {
    median(lattice(image, LATTICE).map(|(_, value)| value.abs())).unwrap_or(0.0)
}

/// Standard deviation of the ranges of a view along their rays, estimated from its image, at the
/// view's median pixel; see [`estimate_value_sigma`].
///
/// # Units
/// The model's length unit, whatever the image's values are.
pub fn estimate_sigma(view: &View) -> f64 {
    estimated(view).1
}

/// The noise that each pixel has of its own, and the same as a length at the view's median pixel.
fn estimated(view: &View) -> (Known, f64) {
    let growth = Growth::of(view.image());
    let value = smaller_spread(differences(&growth.with_even_noise(view.image()), LINES, 1));
    let length = if value == 0.0 { 0.0 } else { value * median_length(view, growth) };
    (Known::Value(value, growth), length)
}

/// Standard deviation of the values of an image, estimated from the image itself.
///
/// The third difference `d[k+3] − 3 d[k+2] + 3 d[k+1] − d[k]` of a smooth surface is noise alone,
/// with variance 20 σ²; the second one would still see its curvature. The smallest 70 % are taken,
/// since the others may be at jumps. Their mean square is compared with that of normal noise.
/// Unlike a quantile it sees coarsely quantised values, most of whose differences are 0. Rows and
/// columns are looked at separately and the smaller result is taken, so that texture or steps in
/// one direction do not count. 0 if no four neighbours are valid. Texture finer than four pixels in
/// both directions counts as noise. [`RangeNoise::shared`] has the noise that neighbours share.
///
/// # Units
/// That of the image's values.
pub fn estimate_value_sigma(image: &RangeImage) -> f64 {
    smaller_spread(differences(&Growth::Same.with_even_noise(image), LINES, 1))
}

/// The noise that neighbouring pixels share, over the noise that each has of its own; `None` where
/// the surface itself may explain what pixels farther apart differ by.
///
/// Third differences of farther and farther pixels are as large as those of neighbours if each
/// pixel errs by itself. Noise that neighbours share makes them larger, up to the distance at
/// which it is no longer shared. Bends make them larger, too, but first little and then by up to 8
/// with each doubling.
///
/// `own` is the estimate from neighbours, and `enough` the least number of differences.
fn shared_noise((image, lines): (&Values<'_>, usize), own: f64, enough: usize) -> Option<f64> {
    let of = |stride: usize| differences(image, lines, stride);
    let farther = |stride: usize, before: f64, most: f64| {
        let farther = of(stride);
        let are_enough = count(&farther) >= enough;
        let spread = smaller_spread(farther).max(before);
        (are_enough && spread < most * before).then_some(spread)
    };
    let [two, four, eight] = APART;
    let at_two = farther(two, own, FIRST_BEND)?;
    let at_four = farther(four, at_two, BEND)?;
    let all = farther(eight, at_four, BEND)?;
    let ends = smaller_spread(of(FAR_APART)) < BEND * all;
    let least = if ends { SHARED } else { CLEARLY_SHARED };
    (at_four >= least * own).then(|| ((all / own).powi(2) - 1.0).sqrt())
}

/// Length along a pixel's ray per unit of its value; `None` where the value means no point.
///
/// By a difference of [`DeviceFrame::point`], so it holds for every sensor.
pub fn length_per_value(frame: &dyn DeviceFrame, pixel: Pixel, d3: f64) -> Option<f64> {
    let step = VALUE_STEP * d3;
    let here = || frame.point(pixel, d3);
    let (below, above) = (frame.point(pixel, d3 - step), frame.point(pixel, d3 + step));
    let (from, to, width) = match (below, above) {
        (Some(below), Some(above)) => (below, above, 2.0 * step),
        (Some(below), None) => (below, here()?, step),
        (None, Some(above)) => (here()?, above, step),
        (None, None) => return None,
    };
    let rate = (to - from).norm() / width;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// Length along a pixel's ray per unit of its value with even noise.
fn length_per_even_value(
    frame: &dyn DeviceFrame,
    (pixel, d3): (Pixel, f64),
    growth: Growth,
) -> Option<f64> {
    Some(growth.factor(d3) * length_per_value(frame, pixel, d3)?)
}

/// The median over a lattice of the view's pixels; 1 if no pixel has such a length.
fn median_length(view: &View, growth: Growth) -> f64 {
    let of = |count: usize| {
        let pixels = lattice(view.image(), count);
        median(pixels.filter_map(|pixel| length_per_even_value(view.frame(), pixel, growth)))
    };
    // The lattice can miss all valid pixels if they are few.
    of(LATTICE).or_else(|| of(usize::MAX)).unwrap_or(1.0)
}

/// Valid pixels and their values, about `count` by `count` evenly over the image.
pub(crate) fn lattice(image: &RangeImage, count: usize) -> impl Iterator<Item = (Pixel, f64)> {
    let size = image.size();
    let steps = (size.rows.div_ceil(count).max(1), size.cols.div_ceil(count).max(1));
    let rows = (0..size.rows).step_by(steps.0);
    let pixels = rows
        .flat_map(move |row| (0..size.cols).step_by(steps.1).map(move |col| Pixel { row, col }));
    pixels.filter_map(|p| image.get(p).map(|d3| (p, f64::from(d3))))
}
