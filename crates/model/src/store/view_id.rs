//! The names by which a store tells its views apart.

use serde::{Deserialize, Serialize};

/// What tells a view from the others: a text that the caller chooses, such as its name in the scan.
///
/// The order of ids is the order in which views are handed to fusion, so that it depends on the
/// set of views alone and not on when each of them came.
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
