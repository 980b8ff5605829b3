//! Tables of numbers per row and per column, for inner loops over whole images.
//!
//! The tables exist for sensors whose rays all start in one point and combine a row's number with a
//! column's number. A level, or the test for a range jump, then takes a few multiplications per
//! pixel, and one inner loop serves every such sensor.

/// A linear form of every sample, for sensors whose points are `d3` times a ray. The value at row i
/// and column j is `d3 · (factor[i] · column[j] + addend[i]) + constant`.
///
/// The tables are computed in `f64` and rounded once; inner loops run in `f32`. Their result is
/// within `2⁻²² · (|d3 · g| + |constant|)` of the form, with `g` the form's gradient along the
/// ray's parts.
#[derive(Debug, Clone, Default)]
pub struct SeparableForm {
    /// Per row: factor and addend.
    pub rows: Vec<[f32; 2]>,
    /// One number per column.
    pub columns: Vec<f32>,
    /// The value at the sensor frame's origin.
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

/// Products of all neighbouring rays of one kind. Each is a number of the row plus a number of the
/// column.
#[derive(Debug, Clone, Default)]
pub struct RayProducts {
    /// One per row.
    pub rows: Vec<RayProduct>,
    /// One per column; empty if all of them are zero.
    pub columns: Vec<RayProduct>,
}
