//! Weights of a fit of second order along one axis, for every radius.

use crate::smooth::{REACH, window};

/// Radii per pixel that have weights of their own. Neighbouring ones differ so little that their results
/// do by far less than noise.
const STEPS: f32 = 16.0;

/// Half the width of a square window, per radius of a round one of the same variance.
const SQUARE: f64 = 1.02;

/// Which radius; 0 for none.
pub(in crate::smooth) type Radius = u8;

/// Weights along one axis, symmetric about the centre.
#[derive(Debug, Clone)]
pub(super) struct Kernel {
    /// By distance from the centre.
    pub taps: [f32; REACH + 1],
    /// The last distance that counts.
    pub reach: usize,
    /// Sum of the squared weights.
    pub variance: f32,
}

/// Weights of the window and of the wider one, by radius.
#[derive(Debug)]
pub(super) struct Kernels(Vec<[Kernel; 2]>);

impl Kernels {
    pub fn new() -> Self {
        let radii = (0..=index_of(window::LARGEST)).map(radius);
        Self(
            radii
                .map(|r| [r, window::wider(r)].map(|r| Kernel::new(SQUARE * f64::from(r))))
                .collect(),
        )
    }

    /// Those of the window and of the wider one.
    #[inline(always)]
    pub fn of(&self, radius: Radius) -> &[Kernel; 2] {
        // Radii come from `index_of`, which gives none beyond the last.
        &self.0[usize::from(radius).min(self.0.len() - 1)]
    }
}

/// The place of a radius, in pixels, that is not beyond the largest.
#[inline(always)]
pub(in crate::smooth) fn index_of(radius: f32) -> Radius {
    // The nearest one; radii are not negative.
    (STEPS * radius.min(window::LARGEST) + 0.5) as i32 as Radius
}

/// The radius at a place, in pixels.
pub(super) fn radius(index: Radius) -> f32 {
    f32::from(index) / STEPS
}

impl Kernel {
    /// The weights `w(x) (a − b x²)` that give the centre's value of the parabola fitted with weights
    /// `w(x)`, which fall to 0 at half the width.
    fn new(half: f64) -> Self {
        let weight = |x: usize| {
            let square = (x as f64 / half).powi(2);
            if half > 0.0 { (1.0 - square * square).max(0.0).powi(2) } else { 0.0 }
        };
        let moment = |power: i32| {
            let beside = (1..=REACH).map(|x| 2.0 * weight(x) * (x as f64).powi(power));
            beside.sum::<f64>()
        };
        let (m0, m2, m4) = (1.0 + moment(0), moment(2), moment(4));
        let determinant = m0 * m4 - m2 * m2;
        let mut taps = [0.0; REACH + 1];
        // Up to three pixels hold a parabola exactly; the centre is then its own value.
        if weight(2) > 0.0 {
            for (x, tap) in taps.iter_mut().enumerate() {
                let square = (x * x) as f64;
                let weight = if x == 0 { 1.0 } else { weight(x) };
                *tap = (weight * (m4 - m2 * square) / determinant) as f32;
            }
        }
        // Their sum is 1 in single precision, too.
        taps[0] = 1.0 - 2.0 * taps[1..].iter().sum::<f32>();
        let reach = taps.iter().rposition(|tap| *tap != 0.0).unwrap_or(0);
        let variance = taps[0] * taps[0] + 2.0 * taps[1..].iter().map(|t| t * t).sum::<f32>();
        Self { taps, reach, variance }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sum(kernel: &Kernel, f: impl Fn(f64) -> f64) -> f64 {
        let beside =
            (1..=REACH).map(|x| f64::from(kernel.taps[x]) * (f(x as f64) + f(-(x as f64))));
        f64::from(kernel.taps[0]) * f(0.0) + beside.sum::<f64>()
    }

    #[test]
    fn parabolas_keep_their_value_and_noise_falls_with_the_radius() {
        let kernels = Kernels::new();
        let mut last = [1.0 + 1e-6; 2];
        for index in 0..=index_of(window::LARGEST) {
            for (k, kernel) in kernels.of(index).iter().enumerate() {
                let value = sum(kernel, |x| 3.0 - 0.5 * x + 0.25 * x * x);
                assert!((value - 3.0).abs() < 1e-5, "{}: {value}", radius(index));
                let squares =
                    sum(&Kernel { taps: kernel.taps.map(|t| t * t), ..kernel.clone() }, |_| 1.0);
                assert!((squares - f64::from(kernel.variance)).abs() < 1e-6);
                assert!(kernel.variance <= last[k] + 1e-3, "{}", radius(index));
                assert!(kernel.reach <= REACH && kernel.taps[kernel.reach] != 0.0);
                last[k] = kernel.variance;
            }
        }
        // Of the square window, the product of both axes': that of the round one.
        for (radius, variance) in [(4.0_f32, 0.1029_f32), (6.0, 0.0453), (7.5, 0.0289)] {
            let [narrow, _] = kernels.of(index_of(radius));
            let ratio = narrow.variance * narrow.variance / variance;
            assert!((0.93..1.07).contains(&ratio), "{radius}: {ratio}");
        }
    }
}
