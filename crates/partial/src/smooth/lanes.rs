//! Several pixels side by side, one number each: a form that compilers turn into vector code.

use std::array::from_fn;
use std::ops::{Add, Mul, Sub};

/// Pixels that are fitted together.
pub(super) const LANES: usize = 8;

/// One number per pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Lanes([f32; LANES]);

impl Lanes {
    pub const ZERO: Self = Self::all(0.0);

    pub const fn all(value: f32) -> Self {
        Self([value; LANES])
    }

    pub const fn new(values: [f32; LANES]) -> Self {
        Self(values)
    }

    pub fn get(self, lane: usize) -> f32 {
        self.0[lane]
    }

    pub fn set(&mut self, lane: usize, value: f32) {
        self.0[lane] = value;
    }

    /// Each number, or 0 where it is negative or NaN.
    #[inline(always)]
    pub fn positive(self) -> Self {
        Self(from_fn(|k| self.0[k].max(0.0)))
    }

    /// `1 / self` where the number exceeds a bound, else 0.
    #[inline(always)]
    pub fn inverse_above(self, bound: Self) -> Self {
        Self(from_fn(|k| if self.0[k] > bound.0[k] { 1.0 / self.0[k] } else { 0.0 }))
    }
}

impl Add for Lanes {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] + other.0[k]))
    }
}

impl Sub for Lanes {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] - other.0[k]))
    }
}

impl Mul for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(from_fn(|k| self.0[k] * other.0[k]))
    }
}

impl Mul<f32> for Lanes {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        Self(from_fn(|k| self.0[k] * factor))
    }
}
