//! Choices that manifests spell as a word, such as `"mounting": "xz"`.

use serde::Serializer;
use transect_sensors::PinholeScale;
use transect_sensors::light_stripe::stripe::{Peak, StripeShape};
use transect_sensors::lookup_table::{DepthPairs, ScanPlane};

/// A choice with one word per value, the same for reading and writing.
pub(super) trait Word: Copy + 'static {
    /// Every value, in the order in which messages name them.
    const ALL: &'static [Self];

    /// How manifests spell it.
    fn word(self) -> &'static str;
}

/// The value that a word spells; the other words if there is none.
pub(super) fn read<T: Word>(word: &str) -> Result<T, String> {
    let found = T::ALL.iter().copied().find(|value| value.word() == word);
    found.ok_or_else(|| format!("one of {}; it is {word:?}", known::<T>()))
}

/// All words, for messages.
pub(super) fn known<T: Word>() -> String {
    T::ALL.iter().map(|value| value.word()).collect::<Vec<_>>().join(", ")
}

/// For `#[serde(serialize_with)]`.
pub(super) fn write<T: Word, S: Serializer>(value: &T, out: S) -> Result<S::Ok, S::Error> {
    out.serialize_str(value.word())
}

impl Word for PinholeScale {
    const ALL: &'static [Self] = &[Self::Depth, Self::RayLength];

    fn word(self) -> &'static str {
        match self {
            Self::Depth => "depth",
            Self::RayLength => "ray_length",
        }
    }
}

impl Word for StripeShape {
    const ALL: &'static [Self] = &[Self::Triangle, Self::Gaussian];

    fn word(self) -> &'static str {
        match self {
            Self::Triangle => "triangle",
            Self::Gaussian => "gaussian",
        }
    }
}

impl Word for Peak {
    const ALL: &'static [Self] = &[Self::SubCell, Self::WholeCell];

    fn word(self) -> &'static str {
        match self {
            Self::SubCell => "sub_cell",
            Self::WholeCell => "whole_cell",
        }
    }
}

impl Word for DepthPairs {
    const ALL: &'static [Self] = &[Self::Neighbours, Self::HalfApart];

    fn word(self) -> &'static str {
        match self {
            Self::Neighbours => "neighbours",
            Self::HalfApart => "half_apart",
        }
    }
}

impl Word for ScanPlane {
    const ALL: &'static [Self] = &[Self::Xz, Self::Yz];

    fn word(self) -> &'static str {
        match self {
            Self::Xz => "xz",
            Self::Yz => "yz",
        }
    }
}
