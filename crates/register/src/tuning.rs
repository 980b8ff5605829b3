//! The numbers that this crate does not derive from the data.

/// Most cells of a view. No unit. Chosen by hand: patches of a scan of half a million pixels then
/// have 8 by 8 pixels. Doubled, a coarse copy takes twice the memory, and curved surfaces are
/// followed more closely.
pub const CELLS: usize = 8192;

/// Fewest pixels along the side of a cell. No unit. Theory: a surface of second order has six
/// unknowns, and 4 by 4 pixels leave ten values to tell its noise. Doubled, images of few rows have
/// hardly any patches.
pub const LEAST_STEP: usize = 4;

/// Share of the pixels of a cell that a patch needs. No unit. Chosen by hand: an edge through the
/// middle of a cell leaves half of them. Doubled, no cell with a missing pixel has a patch.
pub const LEAST_FILLED: f64 = 0.5;

/// Share of the pixels of a cell with a sample from which it shows that nothing else is there. No
/// unit. Chosen by hand: scanners lose 1 or 2 % of their pixels at random. At 1, such scanners have
/// no free space; at half of it, thin objects hide in missing pixels.
pub const LEAST_WHOLE: f64 = 0.9;

/// Largest angle of incidence of a patch, in degrees. Chosen by hand: the limit of range jumps, see
/// `partial`. At 89 degrees, steps between two surfaces pass for patches.
pub const MAX_INCIDENCE_DEGREES: f64 = 75.0;

/// Departure of the samples of a patch from it, over their noise, from which it is no patch.
/// Theory: with ten samples or more to spare, noise alone exceeds it once in 10 000 patches.
/// Doubled, creases pass for patches.
pub const ROUGH: f64 = 2.0;

/// Departure that is allowed in images without noise, over the distance between samples. No unit.
/// Chosen by hand: far below what a crease leaves in a cell. Doubled, shallow creases pass.
pub const SAMPLING_ROUGH: f64 = 0.03;
