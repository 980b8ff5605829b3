//! The camera of a depth sequence: a JSON file of Open3D or RealSense, or a text file.

use crate::input::read_text;
use crate::manifest::{LensEntry, PinholeEntry, SensorEntry};
use crate::open_options::check_intrinsics;
use crate::trajectory::{lines, numbers};
use crate::{CameraOption, Place, ReadError};
use serde::Deserialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use transect_sensors::{Intrinsics, PinholeScale};

/// A camera, and the size of its images where its file states it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Camera {
    pub(super) intrinsics: Intrinsics,
    distortion: Option<[f64; 5]>,
    pub(super) rows: Option<usize>,
    pub(super) cols: Option<usize>,
}

impl Camera {
    pub(super) fn read(source: &CameraOption) -> Result<Self, ReadError> {
        let path = match source {
            CameraOption::Numbers(intrinsics) => return Ok((*intrinsics).into()),
            CameraOption::File(path) => path,
        };
        let text = read_text(path)?;
        let camera = if text.trim_start().starts_with('{') {
            from_json(path, &text)
        } else {
            from_text(path, &text)
        }?;
        check_intrinsics(&camera.intrinsics)
            .map_err(|problem| ReadError::damaged(path, Place::Whole, problem))?;
        Ok(camera)
    }

    /// A focal length below 0 means that the camera's y axis points up, as ICL-NUIM states its
    /// camera. The result has y down, and whether y was turned.
    pub(super) fn with_y_down(self) -> (Self, bool) {
        let turned = self.intrinsics.fy < 0.0;
        let intrinsics = Intrinsics { fy: self.intrinsics.fy.abs(), ..self.intrinsics };
        (Self { intrinsics, ..self }, turned)
    }

    /// The sensor of images whose pixels hold this length.
    pub(super) fn sensor(&self, holds: PinholeScale) -> SensorEntry {
        let lens =
            LensEntry::Intrinsics { intrinsics: self.intrinsics, distortion: self.distortion };
        SensorEntry::Pinhole(PinholeEntry { lens, holds, depth_offsets: None })
    }
}

impl From<Intrinsics> for Camera {
    fn from(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, distortion: None, rows: None, cols: None }
    }
}

fn from_text(path: &Path, text: &str) -> Result<Camera, ReadError> {
    let all = numbers(lines(text, 0).map(|(_, line)| line)).unwrap_or_default();
    match *all.as_slice() {
        [fx, fy, cx, cy] => Ok(Intrinsics { fx, fy, cx, cy }.into()),
        [a, b, c, d, e, f, g, h, i] => from_matrix(path, [a, b, c, d, e, f, g, h, i]),
        [a, b, c, w, d, e, f, x, g, h, i, y, ref last @ ..]
            if [w, x, y] == [0.0; 3] && last == [0.0, 0.0, 0.0, 1.0] =>
        {
            from_matrix(path, [a, b, c, d, e, f, g, h, i])
        }
        _ => {
            let problem = "not a camera; expected a matrix of 3 × 3 or 4 × 4 numbers, the four \
                           numbers fx fy cx cy, or JSON";
            Err(ReadError::damaged(path, Place::Whole, problem))
        }
    }
}

/// The camera of a row-major matrix.
fn from_matrix(path: &Path, matrix: [f64; 9]) -> Result<Camera, ReadError> {
    let [fx, skew, cx, zero, fy, cy, last @ ..] = matrix;
    if [skew, zero] != [0.0, 0.0] || last != [0.0, 0.0, 1.0] {
        let problem = "not a camera matrix fx 0 cx / 0 fy cy / 0 0 1";
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    Ok(Intrinsics { fx, fy, cx, cy }.into())
}

/// The keys of the JSON files of several programs.
#[derive(Debug, Deserialize)]
struct JsonCamera {
    /// Open3D: nine numbers, column by column.
    intrinsic_matrix: Option<[f64; 9]>,
    fx: Option<f64>,
    fy: Option<f64>,
    #[serde(alias = "ppx")]
    cx: Option<f64>,
    #[serde(alias = "ppy")]
    cy: Option<f64>,
    width: Option<usize>,
    height: Option<usize>,
    /// RealSense: the coefficients of its lens model.
    coeffs: Option<[f64; 5]>,
    model: Option<String>,
    /// Open3D's parameters of one view, and of a trajectory.
    intrinsic: Option<Box<JsonCamera>>,
    parameters: Option<Vec<JsonCamera>>,
    /// Keys of other programs.
    #[serde(flatten)]
    others: BTreeMap<String, Value>,
}

/// Beginnings of the keys under which other programs state a lens distortion, in small letters.
const DISTORTIONS: [&str; 4] = ["dist", "coef", "lens", "radial"];

/// Such keys of one letter or of a letter and a number.
const COEFFICIENTS: [&str; 9] = ["d", "k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2"];

/// Whether a value holds a number other than 0.
fn holds_number(value: &Value) -> bool {
    match value {
        Value::Number(number) => number.as_f64() != Some(0.0),
        Value::Array(values) => values.iter().any(holds_number),
        Value::Object(values) => values.values().any(holds_number),
        _ => false,
    }
}

impl JsonCamera {
    /// The cameras inside this object, or the object itself.
    fn innermost(&self) -> Vec<&Self> {
        match (&self.parameters, &self.intrinsic) {
            (Some(views), _) => views.iter().flat_map(Self::innermost).collect(),
            (None, Some(inner)) => vec![inner],
            (None, None) => vec![self],
        }
    }

    /// Refuses a distortion under a key that is not read: depths would be taken for those of a
    /// camera without one.
    fn check_others(&self, path: &Path) -> Result<(), ReadError> {
        let is_distortion = |key: &str| {
            let key = key.to_ascii_lowercase();
            DISTORTIONS.iter().any(|start| key.starts_with(start))
                || COEFFICIENTS.contains(&key.as_str())
        };
        let found =
            self.others.iter().find(|(key, value)| is_distortion(key) && holds_number(value));
        let Some((key, value)) = found else { return Ok(()) };
        let problem = format!(
            "{key:?} is {value}, and a lens distortion is not read under this key; write it as \
             \"model\": \"brown_conrady\", \"coeffs\": [k1, k2, p1, p2, k3], or write undistorted \
             depth images"
        );
        Err(ReadError::unsupported(path, Place::Whole, problem))
    }

    fn camera(&self, path: &Path) -> Result<Camera, ReadError> {
        self.check_others(path)?;
        let read = match (self.intrinsic_matrix, self.fx, self.fy, self.cx, self.cy) {
            (Some([a, b, c, d, e, f, g, h, i]), ..) => {
                from_matrix(path, [a, d, g, b, e, h, c, f, i])?
            }
            (None, Some(fx), Some(fy), Some(cx), Some(cy)) => Intrinsics { fx, fy, cx, cy }.into(),
            _ => {
                let problem = "no camera; expected \"intrinsic_matrix\" with nine numbers \
                               (Open3D), or \"fx\", \"fy\", \"ppx\" and \"ppy\" (RealSense)";
                return Err(ReadError::damaged(path, Place::Whole, problem));
            }
        };
        let distortion = self.coeffs.filter(|coeffs| coeffs.iter().any(|c| *c != 0.0));
        let model = self.model.as_deref().unwrap_or("brown_conrady").to_ascii_lowercase();
        if distortion.is_some() && !matches!(model.as_str(), "brown_conrady" | "brown conrady") {
            let problem = format!(
                "the lens model is {model:?}; expected \"brown_conrady\", or \"coeffs\" of 0; \
                 write undistorted depth images"
            );
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
        Ok(Camera { distortion, rows: self.height, cols: self.width, ..read })
    }
}

fn from_json(path: &Path, text: &str) -> Result<Camera, ReadError> {
    let json: JsonCamera = serde_json::from_str(text)
        .map_err(|source| ReadError::Json { path: path.to_owned(), source })?;
    let mut cameras = json.innermost().into_iter().map(|camera| camera.camera(path));
    let empty = || ReadError::damaged(path, Place::Whole, "\"parameters\" is empty; no camera");
    let first = cameras.next().ok_or_else(empty)??;
    for other in cameras {
        if other? != first {
            let problem = "the views have different cameras; expected one camera for all images";
            return Err(ReadError::unsupported(path, Place::Whole, problem));
        }
    }
    Ok(first)
}
