//! Windowed sums along rows and columns, several pixels side by side.

use super::kernel::{Kernel, Kernels, Radius};
use crate::smooth::lanes::{LANES, Lanes, all};
use fearless_simd::Simd;
use fearless_simd::prelude::*;

/// Both sums, by the kernels of the window and of the wider one, around [`LANES`] places of the samples
/// of each that begin at `at`; `step` is from a sample of the window to the next.
///
/// Every place has the kernels of its own radius. Neighbours mostly share theirs, so it is seldom more
/// than one result that is found.
#[inline(always)]
pub(super) fn around<S: Simd>(
    simd: S,
    kernels: &Kernels,
    radii: &[Radius; LANES],
    samples: [&[f32]; 2],
    at: (usize, usize),
) -> [Lanes<S>; 2] {
    let [mut narrow, mut wide] = both(simd, kernels.of(radii[0]), samples, at);
    if *radii == [radii[0]; LANES] {
        return [narrow, wide];
    }
    let lanes = Lanes::load_array(simd, radii.map(f32::from));
    for (k, radius) in radii.iter().enumerate() {
        if !radii[..k].contains(radius) {
            let others = both(simd, kernels.of(*radius), samples, at);
            let same = lanes.simd_eq(all(simd, f32::from(*radius)));
            (narrow, wide) = (same.select(others[0], narrow), same.select(others[1], wide));
        }
    }
    [narrow, wide]
}

#[inline(always)]
fn both<S: Simd>(
    simd: S,
    kernels: &[Kernel; 2],
    samples: [&[f32]; 2],
    at: (usize, usize),
) -> [Lanes<S>; 2] {
    [one(simd, &kernels[0], samples[0], at), one(simd, &kernels[1], samples[1], at)]
}

#[inline(always)]
fn one<S: Simd>(simd: S, kernel: &Kernel, samples: &[f32], (at, step): (usize, usize)) -> Lanes<S> {
    // The weights' sum is 1, and differences lose nothing to rounding.
    let centre = load(simd, samples, at);
    let mut sum = all(simd, 0.0);
    for k in 1..=kernel.reach {
        let (before, after) = (at - k * step, at + k * step);
        let beside = (load(simd, samples, before) - centre) + (load(simd, samples, after) - centre);
        sum += beside * kernel.taps[k];
    }
    centre + sum
}

#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, samples: &[f32], at: usize) -> Lanes<S> {
    Lanes::from_slice(simd, &samples[at..at + LANES])
}
