//! The ids of views in a store.

use serde::{Deserialize, Serialize};

/// The id of a view: a text that the caller chooses, such as its name in the scan.
///
/// Views are fused in order of their ids, so the result does not depend on the order in which they
/// were added.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct ViewId(pub String);

impl std::fmt::Display for ViewId {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl From<&str> for ViewId {
    fn from(id: &str) -> Self {
        Self(id.to_owned())
    }
}
