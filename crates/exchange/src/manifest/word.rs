//! Choices that manifests spell as a word, such as `"mounting": "xz"`.

use serde::Serializer;
use transect_sensors::PinholeScale;
use transect_sensors::light_stripe::stripe::{Peak, StripeShape};
use transect_sensors::lookup_table::{DepthPairs, ScanPlane};

/// A choice with one word per value, the same for reading and writing.
pub(super) trait Word: Copy + PartialEq + 'static {
    /// Every value with its word, in the order in which messages name them.
    const WORDS: &'static [(Self, &'static str)];
}

/// The value of a word. The error lists the known words.
pub(super) fn read<T: Word>(word: &str) -> Result<T, String> {
    let found = T::WORDS.iter().find(|(_, known)| *known == word).map(|(value, _)| *value);
    found.ok_or_else(|| format!("one of {}; it is {word:?}", known::<T>()))
}

/// All words, for messages.
pub(super) fn known<T: Word>() -> String {
    T::WORDS.iter().map(|(_, word)| *word).collect::<Vec<_>>().join(", ")
}

/// For `#[serde(serialize_with)]`.
pub(super) fn write<T: Word, S: Serializer>(value: &T, out: S) -> Result<S::Ok, S::Error> {
    let word = T::WORDS.iter().find(|(known, _)| known == value).map(|(_, word)| *word);
    out.serialize_str(word.unwrap_or_default())
}

impl Word for PinholeScale {
    const WORDS: &'static [(Self, &'static str)] =
        &[(Self::Depth, "depth"), (Self::RayLength, "ray_length")];
}

impl Word for StripeShape {
    const WORDS: &'static [(Self, &'static str)] =
        &[(Self::Triangle, "triangle"), (Self::Gaussian, "gaussian")];
}

impl Word for Peak {
    const WORDS: &'static [(Self, &'static str)] =
        &[(Self::SubCell, "sub_cell"), (Self::WholeCell, "whole_cell")];
}

impl Word for DepthPairs {
    const WORDS: &'static [(Self, &'static str)] =
        &[(Self::Neighbours, "neighbours"), (Self::HalfApart, "half_apart")];
}

impl Word for ScanPlane {
    const WORDS: &'static [(Self, &'static str)] = &[(Self::Xz, "xz"), (Self::Yz, "yz")];
}
