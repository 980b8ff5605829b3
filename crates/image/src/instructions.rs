//! Which processor instructions the inner loops use.

use fearless_simd::Level;

/// Which instructions the inner loops may use. Results are the same to the bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The best that the processor has.
    #[default]
    Best,
    /// AVX2 where the processor has it, else as portable.
    Avx2,
    /// Those that every processor of the build's target has.
    Portable,
}

impl Instructions {
    /// The level of `fearless_simd` for the inner loops of this crate and of `transect-partial`.
    #[doc(hidden)]
    pub fn level(self) -> Level {
        match self {
            Self::Best => Level::new(),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Self::Avx2 => Level::new().as_avx2().map_or_else(Level::baseline, Level::Avx2),
            _ => Level::baseline(),
        }
    }
}
