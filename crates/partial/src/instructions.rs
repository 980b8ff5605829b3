//! The instructions of inner loops, for the vector library.

use fearless_simd::Level;
use transect_image::Instructions;

/// The level of `fearless_simd` that stands for instructions. `transect-image` has the same for its
/// own inner loops: the library's types are in no public interface.
pub(crate) fn level(instructions: Instructions) -> Level {
    match instructions {
        Instructions::Best => Level::new(),
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        Instructions::Avx2 => Level::new().as_avx2().map_or_else(Level::baseline, Level::Avx2),
        _ => Level::baseline(),
    }
}
