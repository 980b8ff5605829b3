//! Sensors in numbers of rows and columns, for loops over whole images that need no sensor.
//!
//! Where all rays start in one point and a ray is made of a row's and a column's numbers, levels and
//! the test for range jumps are a few multiplications per pixel. These tables hand those numbers
//! over, so that one inner loop serves every such sensor.

/// A linear form of every sample of a sensor whose points are `d3` times a ray, as numbers of its row
/// and its column: `d3 · (factor[i] · column[j] + addend[i]) + constant`.
///
/// Tables are made in `f64` and rounded once; the rest is left to inner loops in `f32`. Their result is
/// within `2⁻²² · (|d3 · g| + |constant|)` of the form, with `g` the form's gradient along the ray's parts.
#[derive(Debug, Clone, Default)]
pub struct SeparableForm {
    /// Per row: factor and addend.
    pub rows: Vec<[f32; 2]>,
    /// One number per column.
    pub columns: Vec<f32>,
    /// What is left at the sensor frame's origin.
    pub constant: f32,
}

/// Products of neighbouring rays `a` (here) and `b` (the neighbour), each scaled to value 1.
///
/// For samples `p = d3 · a` and `q = d3′ · b` the pair's geometry follows from them alone:
/// `range_step · √here = |d3′ · other − d3 · here|` and `lateral · √here = d3′ · across`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RayProduct {
    /// `a · a`.
    pub here: f32,
    /// `a · b`.
    pub other: f32,
    /// `|a × b|`.
    pub across: f32,
}

/// Products of all neighbouring rays of one kind, as sums of a number of the row and one of the column.
#[derive(Debug, Clone, Default)]
pub struct RayProducts {
    /// One per row.
    pub rows: Vec<RayProduct>,
    /// One per column; empty where every column's is zero.
    pub columns: Vec<RayProduct>,
}
