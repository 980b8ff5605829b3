//! Weighted least squares for a polynomial of second order, several pixels at once.

use super::lanes::{Native, all, inverse_above};
use crate::tuning::{HALF_WINDOW, SMALLEST_PIVOT};
use fearless_simd::Simd;

/// Coefficients of `1, x, y, x², xy, y²`.
pub(super) type Coefficients<S> = [Native<S>; 6];

/// Powers of x and y in each term.
const POWERS: [(usize, usize); 6] = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)];

/// Weighted sums over a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sums<S: Simd> {
    simd: S,
    /// `Σ w xᵃ yᵇ` at `[a][b]`, a + b ≤ 4.
    powers: [[Native<S>; 5]; 5],
    /// `Σ w v xᵃ yᵇ` for the terms.
    values: Coefficients<S>,
}

/// Weighted sums over one row of a window: `Σ w xᵃ` and `Σ w v xᵃ`.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowSums<S: Simd> {
    powers: [Native<S>; 5],
    values: [Native<S>; 3],
}

impl<S: Simd> RowSums<S> {
    /// The sums over the middle of a row alone.
    #[inline(always)]
    pub fn new(simd: S, [weight, weighted]: [Native<S>; 2]) -> Self {
        let zero = all(simd, 0.0);
        Self { powers: [weight, zero, zero, zero, zero], values: [weighted, zero, zero] }
    }

    /// Adds the weights at `−x` and `x`.
    #[inline(always)]
    pub fn add_weights(&mut self, column: &Column, [left, right]: [Native<S>; 2]) {
        let [x, x2, x3, x4] = column.powers;
        let (even, odd) = (right + left, right - left);
        let [p0, p1, p2, p3, p4] = self.powers;
        self.powers = [p0 + even, p1 + odd * x, p2 + even * x2, p3 + odd * x3, p4 + even * x4];
    }

    /// Adds the weighted values at `−x` and `x`.
    #[inline(always)]
    pub fn add_values(&mut self, column: &Column, [left, right]: [Native<S>; 2]) {
        let [x, x2, ..] = column.powers;
        let (even, odd) = (right + left, right - left);
        let [v0, v1, v2] = self.values;
        self.values = [v0 + even, v1 + odd * x, v2 + even * x2];
    }
}

/// Two columns of a window, as far left of its middle as right of it. Their powers are read from a
/// table, which is faster than multiplying.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column {
    /// `x`, `x²`, `x³` and `x⁴`.
    pub powers: [f32; 4],
    /// The bits of `−x` and `x` in the connected pixels of a row; see `links.rs`.
    pub bits: [u32; 2],
}

/// The pairs of columns of the largest window, going outward.
pub(super) const COLUMNS: [Column; HALF_WINDOW] = {
    let mut columns = [Column { powers: [0.0; 4], bits: [0; 2] }; HALF_WINDOW];
    let mut c = 0;
    while c < HALF_WINDOW {
        let x = (c + 1) as f32;
        let bits = [1 << (HALF_WINDOW - c - 1), 1 << (HALF_WINDOW + c + 1)];
        columns[c] = Column { powers: [x, x * x, x * x * x, x * x * x * x], bits };
        c += 1;
    }
    columns
};

impl<S: Simd> Sums<S> {
    #[inline(always)]
    pub fn zero(simd: S) -> Self {
        let zero = all(simd, 0.0);
        Self { simd, powers: [[zero; 5]; 5], values: [zero; 6] }
    }

    #[inline(always)]
    pub fn add_row(&mut self, y: f32, row: &RowSums<S>) {
        let ys = [1.0, y, y * y, y * y * y, y * y * y * y];
        for a in 0..5 {
            for (sum, y) in self.powers[a].iter_mut().zip(ys).take(5 - a) {
                *sum += row.powers[a] * y;
            }
        }
        for (sum, (a, b)) in self.values.iter_mut().zip(POWERS) {
            *sum += row.values[a] * ys[b];
        }
    }

    /// The polynomial that fits best.
    #[inline(always)]
    pub fn fit(&self) -> Coefficients<S> {
        self.solve(self.values)
    }

    /// The polynomial `z` whose values make the fit at the centre: it is `Σ w z v`.
    #[inline(always)]
    pub fn centre_weights(&self) -> Coefficients<S> {
        let mut unit = [all(self.simd, 0.0); 6];
        unit[0] = all(self.simd, 1.0);
        self.solve(unit)
    }

    /// Solves by `L D Lᵀ`; terms without a pivot get the coefficient 0.
    #[inline(always)]
    fn solve(&self, right: Coefficients<S>) -> Coefficients<S> {
        let zero = all(self.simd, 0.0);
        let mut lower = [[zero; 6]; 6];
        let mut inverse = [zero; 6];
        let mut solution = right;
        for i in 0..6 {
            // `scaled[j] = L[i][j] D[j]`
            let mut scaled = [zero; 6];
            for j in 0..i {
                let mut sum = self.entry(i, j);
                for k in 0..j {
                    sum -= scaled[k] * lower[j][k];
                }
                scaled[j] = sum;
                lower[i][j] = sum * inverse[j];
            }
            let diagonal = self.entry(i, i);
            let mut pivot = diagonal;
            for k in 0..i {
                pivot -= scaled[k] * lower[i][k];
                solution[i] -= lower[i][k] * solution[k];
            }
            inverse[i] = inverse_above(self.simd, pivot, diagonal * SMALLEST_PIVOT);
        }
        for i in (0..6).rev() {
            solution[i] *= inverse[i];
            for k in i + 1..6 {
                solution[i] -= lower[k][i] * solution[k];
            }
        }
        solution
    }

    #[inline(always)]
    fn entry(&self, i: usize, j: usize) -> Native<S> {
        let ((ai, bi), (aj, bj)) = (POWERS[i], POWERS[j]);
        self.powers[ai + aj][bi + bj]
    }
}

/// A polynomial along one row of the window: `c0 + c1 x + c2 x²`.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowPolynomial<S: Simd>([Native<S>; 3]);

impl<S: Simd> RowPolynomial<S> {
    #[inline(always)]
    pub fn new(c: &Coefficients<S>, y: f32) -> Self {
        Self([c[0] + c[2] * y + c[5] * (y * y), c[1] + c[4] * y, c[3]])
    }

    /// The value at 0.
    #[inline(always)]
    pub fn middle(&self) -> Native<S> {
        self.0[0]
    }

    /// The values at `−x` and `x`.
    #[inline(always)]
    pub fn at(&self, column: &Column) -> [Native<S>; 2] {
        let [x, x2, ..] = column.powers;
        let (even, odd) = (self.0[2] * x2 + self.0[0], self.0[1] * x);
        [even - odd, even + odd]
    }
}
