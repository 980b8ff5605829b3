//! Notes: remarks about input that is usable, but unusual.

use serde::{Serialize, Serializer};
use std::fmt::{self, Display};

/// A remark for the user and the report: an assumption, a repair, or content that was ignored.
///
/// It is printed and serialised as one line.
///
/// ```
/// use transect_device::Note;
///
/// let note = Note::about("a.npy", "3 values are negative; missing");
/// assert_eq!(note.to_string(), "a.npy: 3 values are negative; missing");
/// assert_eq!(Note::new("2 of 3 views are used").to_string(), "2 of 3 views are used");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The file, the part of a file or the view that has it; `None`: the whole scan or model.
    pub about: Option<String>,
    /// The remark. Remarks that say the same about several files have equal texts.
    pub text: String,
}

impl Note {
    /// A note about a scan or a model as a whole.
    pub fn new(text: impl Into<String>) -> Self {
        Self { about: None, text: text.into() }
    }

    /// A note about a file, a part of a file or a view.
    pub fn about(about: impl Display, text: impl Into<String>) -> Self {
        Self { about: Some(about.to_string()), text: text.into() }
    }
}

impl Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.about {
            Some(about) => write!(f, "{about}: {}", self.text),
            None => f.write_str(&self.text),
        }
    }
}

impl Serialize for Note {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
