//! Images of range values (`.npy`, `.png`, `.pgm`, `.tif`) and grids of points (`.npy`).

use crate::input::read_bytes;
use crate::missing::narrowed;
use crate::npy::Npy;
use crate::png_file::{self, GreyImage, Samples};
use crate::tiff_file::{self, TiffSamples};
use crate::{Place, ReadError, pgm_file};
use std::path::Path;
use transect_device::{ImageSize, Point3};

/// Row-major values in the unit of the sensor's scale. `RangeImage` decides which are missing.
pub(crate) struct Pixels {
    pub(crate) size: ImageSize,
    pub(crate) values: Vec<f32>,
    /// Whether the file holds integers.
    pub(crate) integers: bool,
}

/// Extensions of files that may hold a depth image. `.exr` is known and refused with its reason.
pub(crate) const EXTENSIONS: [&str; 6] = ["png", "npy", "pgm", "tif", "tiff", "exr"];

/// A range or depth image: `.npy` (rows × columns), 16-bit grey `.png` or `.pgm`, or `.tif` of
/// 16-bit integers or floating-point numbers. Integers need a scale.
pub(crate) fn read(
    path: &Path,
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Pixels, ReadError> {
    let bytes = read_bytes(path)?;
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase);
    match extension.as_deref() {
        Some("npy") => from_npy(path, &bytes, scale, notes),
        Some("png") => from_png(path, &bytes, scale, notes),
        Some("pgm") => from_counts(path, pgm_file::decode(path, &bytes, notes)?, scale, notes),
        Some("tif" | "tiff") => from_tiff(path, &bytes, scale, notes),
        Some("exr") => {
            let problem = "EXR is not read; convert the depth to .npy or to a .tif of floats";
            Err(ReadError::unsupported(path, Place::Whole, problem))
        }
        _ => {
            let problem = "images are read from .npy, .png, .pgm and .tif";
            Err(ReadError::unsupported(path, Place::Whole, problem))
        }
    }
}

/// A grid of points: `.npy` of rows × columns × 3.
pub(crate) fn read_points(
    path: &Path,
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<(ImageSize, Vec<Point3>), ReadError> {
    let bytes = read_bytes(path)?;
    let array = array_of(path, &bytes, notes)?;
    let [rows, cols, 3] = *array.shape() else {
        return Err(wrong_shape(path, &array, "rows × columns × 3"));
    };
    let scale = scale_of(path, &array, scale)?;
    let points = array.triples().map(|c| Point3::from(c.map(|c| c * scale))).collect();
    Ok((ImageSize { rows, cols }, points))
}

/// The array of a file. A note tells of bytes after it.
fn array_of<'a>(
    path: &Path,
    bytes: &'a [u8],
    notes: &mut Vec<String>,
) -> Result<Npy<'a>, ReadError> {
    let array = Npy::parse(bytes).map_err(|p| p.in_file(path))?;
    notes.extend(array.leftovers());
    Ok(array)
}

fn from_npy(
    path: &Path,
    bytes: &[u8],
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Pixels, ReadError> {
    let array = array_of(path, bytes, notes)?;
    let ([rows, cols] | [rows, cols, 1]) = *array.shape() else {
        return Err(wrong_shape(path, &array, "rows × columns"));
    };
    let scale = scale_of(path, &array, scale)?;
    let values = match array.singles() {
        Some(values) if scale == 1.0 => values,
        _ => array.numbers().map(|v| narrowed(v * scale)).collect(),
    };
    let integers = array.is_integer();
    Ok(Pixels { size: ImageSize { rows, cols }, values, integers })
}

fn from_tiff(
    path: &Path,
    bytes: &[u8],
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Pixels, ReadError> {
    let (size, samples) = tiff_file::decode(path, bytes)?;
    let factor = scale.unwrap_or(1.0);
    let values = match samples {
        TiffSamples::Counts(counts) => {
            return from_counts(path, (size, counts), scale, notes);
        }
        TiffSamples::Singles(values) if factor == 1.0 => values,
        TiffSamples::Singles(values) => {
            values.into_iter().map(|v| narrowed(f64::from(v) * factor)).collect()
        }
        TiffSamples::Doubles(values) => values.into_iter().map(|v| narrowed(v * factor)).collect(),
    };
    Ok(Pixels { size, values, integers: false })
}

/// The factor of an array's numbers: the stated one; 1 for floating-point numbers without one.
fn scale_of(path: &Path, array: &Npy<'_>, stated: Option<f64>) -> Result<f64, ReadError> {
    match stated {
        None if array.is_integer() => Err(no_scale(path, "integers")),
        stated => Ok(stated.unwrap_or(1.0)),
    }
}

fn no_scale(path: &Path, what: &str) -> ReadError {
    let problem = format!("{what} need a scale; add \"scale\": length units per count to the view");
    ReadError::damaged(path, Place::Whole, problem)
}

fn wrong_shape(path: &Path, array: &Npy<'_>, wanted: &str) -> ReadError {
    let problem = format!("the array's shape is {:?}, not {wanted}", array.shape());
    ReadError::damaged(path, Place::Whole, problem)
}

/// The largest count. It means a missing pixel: 7-Scenes writes it, and a saturated count measures
/// no range.
const SATURATED: u16 = u16::MAX;

fn from_png(
    path: &Path,
    bytes: &[u8],
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Pixels, ReadError> {
    let GreyImage { size, samples } = png_file::decode(path, bytes)?;
    let Samples::Sixteen(counts) = samples else {
        let problem = "the image has 8 bits, too few for ranges: most likely it is a picture of \
                       them; export the depths themselves as 16-bit grey";
        return Err(ReadError::unsupported(path, Place::Whole, problem));
    };
    from_counts(path, (size, counts), scale, notes)
}

/// The values of an image of 16-bit counts.
fn from_counts(
    path: &Path,
    (size, counts): (ImageSize, Vec<u16>),
    scale: Option<f64>,
    notes: &mut Vec<String>,
) -> Result<Pixels, ReadError> {
    let scale = scale.ok_or_else(|| no_scale(path, "the counts of an image"))?;
    let counts = counts.into_iter();
    let saturated = counts.clone().filter(|c| *c == SATURATED).count();
    if saturated > 0 {
        notes.push(format!("{saturated} pixels at the largest count, 65535, taken as missing"));
    }
    let value = |count| match count {
        0 | SATURATED => f32::NAN,
        count => (f64::from(count) * scale) as f32,
    };
    let values: Vec<f32> = counts.map(value).collect();
    if let Some(at) = values.iter().position(|v| v.is_infinite()) {
        let pixel = size.pixel(at);
        let problem = format!("the scale {scale} makes the value infinite");
        return Err(ReadError::damaged(path, Place::Pixel(pixel), problem));
    }
    Ok(Pixels { size, values, integers: true })
}

/// Writes row-major values as `.npy` (float32), the format of images in scan manifests.
///
/// # Errors
/// An error of `out`, or a number of values that is not rows × columns.
pub fn write_npy_image(
    size: ImageSize,
    values: &[f32],
    mut out: &mut dyn std::io::Write,
) -> std::io::Result<()> {
    if size.rows.checked_mul(size.cols) != Some(values.len()) {
        let problem = format!("{} values do not fill {size}", values.len());
        return Err(std::io::Error::other(problem));
    }
    crate::npy::write_header(&mut out, "<f4", &[size.rows, size.cols])?;
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    out.write_all(&bytes)
}
