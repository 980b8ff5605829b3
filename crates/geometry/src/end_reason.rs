//! Why an open curve ends.

use serde::{Deserialize, Serialize};

/// Why a curve ends where it does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum EndReason {
    /// A pixel beside the end is missing.
    MissingPixel,
    /// The surface ends or hides behind another one: neighbouring pixels belong to different ones.
    RangeJump,
    /// The image ends.
    ImageBorder,
}

impl std::fmt::Display for EndReason {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::MissingPixel => "missing pixel",
            Self::RangeJump => "range jump",
            Self::ImageBorder => "image border",
        })
    }
}
