//! Texts in decoded values.

use serde::{Deserialize, Deserializer};

/// Reads a text by way of the decoder's own bytes. For an owned text, the decoder would reserve
/// memory by the announced length, before that many bytes are known to exist.
pub(crate) fn read<'de, D: Deserializer<'de>>(decoder: D) -> Result<String, D::Error> {
    <&str>::deserialize(decoder).map(str::to_owned)
}
