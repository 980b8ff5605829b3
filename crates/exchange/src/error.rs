//! The errors of reading and writing files, sorted by the caller's remedy.

use std::fmt;
use std::path::{Path, PathBuf};
use transect_device::{ImageError, Pixel, ViewError};
use transect_geometry::{GuideError, LengthUnit};
use transect_sensors::SensorError;

/// A place in a file. Lines count from 1, all other numbers from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line of a text file.
    Line(usize),
    /// A view of a manifest.
    View {
        /// Its place in the list of views.
        number: usize,
        /// Its file, as the manifest names it.
        name: String,
    },
    /// A view that is one line of a text file.
    ViewLine {
        /// The line.
        line: usize,
        /// The view's file, as the line names it.
        name: String,
    },
    /// A pixel of an image or a cell of a grid.
    Pixel(Pixel),
    /// An element of a mesh or a grid, such as a vertex or a face.
    Element {
        /// Its kind, such as `vertex`.
        kind: String,
        /// Its number.
        number: usize,
        /// The line it stands on, in text files.
        line: Option<usize>,
    },
}

impl fmt::Display for Place {
    /// Begins with a comma, to follow a file name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(f, ", line {line}"),
            Self::View { number, name } => write!(f, ", view {number} ({name})"),
            Self::ViewLine { line, name } => write!(f, ", line {line}, view {name}"),
            Self::Pixel(pixel) => write!(f, ", {pixel}"),
            Self::Element { kind, number, line: None } => write!(f, ", {kind} {number}"),
            Self::Element { kind, number, line: Some(line) } => {
                write!(f, ", line {line}, {kind} {number}")
            }
        }
    }
}

impl Place {
    /// The place without the comma that follows a file's name.
    pub(crate) fn words(&self) -> String {
        self.to_string().trim_start_matches(", ").to_owned()
    }
}

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file is missing or the system refuses it: check the path.
    #[error("{}: cannot be read", .path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        #[source]
        source: std::io::Error,
    },
    /// Views of a scan have no file: correct their names, or leave them out.
    #[error(
        "{}: {count} of {views} views have no file: {names}; correct the names, or pass \
         the setting `skip_missing` to leave these views out",
        .path.display()
    )]
    MissingFiles {
        /// The scan.
        path: PathBuf,
        /// Number of views without a file.
        count: usize,
        /// Number of all views.
        views: usize,
        /// The missing files.
        names: String,
    },
    /// No view of a scan has a file: put the images there, or correct their names.
    #[error(
        "{}: none of its {views} views has a file, so there is nothing to read. The first was \
         looked for at {}; put the images there, or correct the names",
        .path.display(), .first.display()
    )]
    NoFiles {
        /// The scan.
        path: PathBuf,
        /// Number of its views.
        views: usize,
        /// Where the file of the first view was expected.
        first: PathBuf,
    },
    /// The path is no scan: name another one.
    #[error("{}: not a scan; accepted are: {accepted}", .path.display())]
    NotAScan {
        /// The path.
        path: PathBuf,
        /// The accepted formats.
        accepted: String,
    },
    /// No length unit is stated: state it.
    #[error("{}: no length unit; add \"unit\": \"m\" or pass the setting `unit`", .path.display())]
    NoUnit {
        /// The manifest.
        path: PathBuf,
    },
    /// Two units were given: drop one of them.
    #[error(
        "{}: the unit is {stated}, but {asked} was asked for; lengths are never converted on reading",
        .path.display()
    )]
    UnitConflict {
        /// The scan.
        path: PathBuf,
        /// The scan's own unit.
        stated: LengthUnit,
        /// The caller's unit.
        asked: LengthUnit,
    },
    /// The file is not JSON of the expected form: repair it at the line and column of the cause.
    #[error("{}: not valid JSON for this purpose", .path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// The syntax error, with line and column.
        #[source]
        source: serde_json::Error,
    },
    /// The file contradicts itself or its format: repair it or get it again.
    #[error("{}{at}: {problem}", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where in it.
        at: Place,
        /// The problem.
        problem: String,
    },
    /// The file is sound but of a kind that is not read here: convert it.
    #[error("{}{at}: {problem}", .path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Where in it.
        at: Place,
        /// The unsupported property, and the supported ones.
        problem: String,
    },
    /// The content is readable but makes no view, sensor or plane family: correct its numbers.
    #[error("{}{at}: {what} is not usable", .path.display())]
    Unusable {
        /// The file.
        path: PathBuf,
        /// Where in it.
        at: Place,
        /// The thing that the numbers describe, such as "the sensor".
        what: &'static str,
        /// The reason.
        #[source]
        source: Box<Unusable>,
    },
}

/// Why numbers from a file make no view, sensor, image or planes.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unusable {
    /// They make no view.
    #[error(transparent)]
    View(#[from] ViewError),
    /// They make a view without a valid pixel: leave it out, or correct its file.
    #[error("{0}; leave this view out with the setting `views`, or correct its file")]
    EmptyView(ViewError),
    /// They make no sensor.
    #[error(transparent)]
    Sensor(#[from] SensorError),
    /// They make no image.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// They make no planes.
    #[error(transparent)]
    Planes(#[from] GuideError),
}

impl ReadError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io { path: path.to_owned(), source }
    }

    pub(crate) fn damaged(path: &Path, at: Place, problem: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), at, problem: problem.into() }
    }

    pub(crate) fn unsupported(path: &Path, at: Place, problem: impl Into<String>) -> Self {
        Self::Unsupported { path: path.to_owned(), at, problem: problem.into() }
    }

    pub(crate) fn unusable(
        path: &Path,
        at: Place,
        what: &'static str,
        source: impl Into<Unusable>,
    ) -> Self {
        Self::Unusable { path: path.to_owned(), at, what, source: Box::new(source.into()) }
    }
}

/// A problem in a file and its place, for readers that do not know the file's name.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Problem {
    pub(crate) at: Place,
    pub(crate) text: String,
    /// Whether the file is sound, but of an unsupported kind.
    unsupported: bool,
}

impl Problem {
    pub(crate) fn at(at: Place, text: impl Into<String>) -> Self {
        Self { at, text: text.into(), unsupported: false }
    }

    pub(crate) fn damaged(text: impl Into<String>) -> Self {
        Self::at(Place::Whole, text)
    }

    pub(crate) fn unsupported(text: impl Into<String>) -> Self {
        Self { unsupported: true, ..Self::damaged(text) }
    }

    /// The same problem, with the name of the part of the file that has it.
    pub(crate) fn of(self, part: &str) -> Self {
        Self { text: format!("{part}: {}", self.text), ..self }
    }

    pub(crate) fn in_file(self, path: &Path) -> ReadError {
        let Self { at, text: problem, unsupported } = self;
        let path = path.to_owned();
        if unsupported {
            ReadError::Unsupported { path, at, problem }
        } else {
            ReadError::Damaged { path, at, problem }
        }
    }
}

/// A file could not be written: check the folder and the space left.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot be written", .path.display())]
#[non_exhaustive]
pub struct WriteError {
    /// The file that was to be written.
    pub path: PathBuf,
    /// The error of the system.
    #[source]
    pub source: std::io::Error,
}
