//! E57 files (ASTM E2807): the structured scans of terrestrial scanners.
//!
//! A file holds any number of scans. A scan is structured if every record has a row and a column.
//! Each structured scan is a view: a grid of points as its scanner saw them, with the scan's pose.
//! Records that are absent or invalid are missing pixels. Images, colours and intensities are not
//! read. Lengths are metres by the standard.
//!
//! The crate `e57` decodes pages, XML and packed records. It trusts announced sizes in two places:
//! the length of the XML part, and records without any bits. Both are checked here before.

mod grid;
mod records;

use crate::scan::{FramedImage, LoadView};
use crate::{OpenOptions, Place, ReadError, Scan, ScanView, input, pose, survey};
use e57::{E57Reader, Header, PointCloud, RecordDataType};
use nalgebra::Quaternion;
use std::fs::File;
use std::io::{Read, Seek};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use transect_device::Note;
use transect_geometry::{Isometry3, LengthUnit};

/// The first bytes of every E57 file.
const SIGNATURE: &[u8; 8] = b"ASTM-E57";

/// Most fields of a record. The standard names 20, and extensions add a few. Each field costs up to
/// 16 bytes per bit of a packet of 64 KiB, so that doubled, a hostile file takes 1 GB.
const MOST_FIELDS: usize = 64;

/// The way out for a scan without rows and columns.
const EXPORT: &str = "export the setups as structured (gridded) E57 scans, or as PTX";

/// Whether a file has the name or the first bytes of an E57 file.
pub(crate) fn is_one(path: &Path) -> bool {
    let named = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("e57"));
    path.is_file() && (named || begins_with_signature(path).unwrap_or(false))
}

fn begins_with_signature(path: &Path) -> Result<bool, std::io::Error> {
    let mut start = [0; SIGNATURE.len()];
    File::open(path)?.read_exact(&mut start)?;
    Ok(start == *SIGNATURE)
}

/// The structured scans of a file. Reads the file's XML part alone.
pub(crate) fn open(path: &Path, options: &OpenOptions) -> Result<Scan, ReadError> {
    let mut notes = Vec::new();
    // The standard (ASTM E2807) states metres.
    let unit = options.unit.unwrap_or(LengthUnit::Metre);
    let clouds = reader(path)?.pointclouds();
    let (mut views, mut refused) = (Vec::new(), Vec::new());
    for (number, cloud) in clouds.iter().enumerate() {
        let name = name_of(number, &clouds);
        match unstructured(cloud) {
            Some(reason) => refused.push(format!("scan {number} ({name}) {reason}")),
            None => views.push(view(path, number, name, cloud, &mut notes)?),
        }
    }
    if views.is_empty() {
        return Err(nothing_left(path, &refused));
    }
    if !refused.is_empty() {
        let (count, all, reasons) = (refused.len(), clouds.len(), refused.join("; "));
        let text = format!("{count} of {all} scans left out: {reasons}; {EXPORT}");
        notes.push(Note::about(path.display(), text));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let inputs = vec![path.to_owned()];
    Ok(Scan { name, unit, sigma: None, planes: None, views, notes, inputs })
}

/// The error for a file without a structured scan. A damaged page is named first, because it may be
/// the reason.
fn nothing_left(path: &Path, refused: &[String]) -> ReadError {
    let damage = input::open(path).map(|file| E57Reader::validate_crc(file).err());
    match damage {
        Err(error) => return error,
        Ok(Some(error)) => return damaged(path, Place::Whole, &error),
        Ok(None) => {}
    }
    if refused.is_empty() {
        return ReadError::damaged(path, Place::Whole, "the file holds no scan; export it again");
    }
    let shown: Vec<&str> = refused.iter().take(3).map(String::as_str).collect();
    let more = refused.len() - shown.len();
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let problem = format!(
        "no scan has rows and columns, so none can be traced: {}{more}; {EXPORT}",
        shown.join("; ")
    );
    ReadError::unsupported(path, Place::Whole, problem)
}

/// Why a scan is no grid; `None` if it may be one.
fn unstructured(cloud: &PointCloud) -> Option<String> {
    let bounds = cloud.index_bounds.as_ref();
    let single = |min: Option<i64>, max: Option<i64>| min.is_some() && min == max;
    if cloud.records == 0 {
        Some("holds no point".to_owned())
    } else if !cloud.has_cartesian() && !cloud.has_spherical() {
        Some("has neither cartesianX, Y, Z nor sphericalRange, Azimuth, Elevation".to_owned())
    } else if !cloud.has_row_column() {
        Some(format!("has {} points without rowIndex and columnIndex", cloud.records))
    } else if bounds.is_some_and(|b| single(b.row_min, b.row_max)) {
        Some("has a single row".to_owned())
    } else if bounds.is_some_and(|b| single(b.column_min, b.column_max)) {
        Some("has a single column".to_owned())
    } else {
        None
    }
}

/// The name that a scan has alone, or its name with its number.
fn name_of(number: usize, clouds: &[PointCloud]) -> String {
    let named = |cloud: &PointCloud| cloud.name.clone().filter(|name| !name.trim().is_empty());
    let Some(name) = clouds.get(number).and_then(named) else { return format!("scan {number}") };
    let alone = clouds.iter().filter_map(named).filter(|other| *other == name).count() == 1;
    if alone { name } else { format!("{name} #{number}") }
}

fn view(
    path: &Path,
    number: usize,
    name: String,
    cloud: &PointCloud,
    notes: &mut Vec<Note>,
) -> Result<ScanView, ReadError> {
    let at = Place::View { number, name: name.clone() };
    let refused = |problem: String| ReadError::damaged(path, at.clone(), problem);
    check_fields(cloud).map_err(refused)?;
    let (world_from_sensor, note) = pose_of(cloud).map_err(refused)?;
    notes.extend(note.map(|text| Note::about(format_args!("{}{at}", path.display()), text)));
    let source = Arc::new(E57View { path: path.to_owned(), at, cloud: cloud.clone() });
    Ok(ScanView::new(name, path.to_owned(), world_from_sensor, source))
}

/// Refuses records that take no space in the file, whose number nothing limits.
fn check_fields(cloud: &PointCloud) -> Result<(), String> {
    let has_bits = |kind: &RecordDataType| match kind {
        RecordDataType::Integer { min, max } => min < max,
        RecordDataType::ScaledInteger { min, max, .. } => min < max,
        _ => true,
    };
    if !cloud.prototype.iter().any(|field| has_bits(&field.data_type)) {
        return Err("all fields of the records are constant; export the scan again".to_owned());
    }
    let fields = cloud.prototype.len();
    if fields > MOST_FIELDS {
        return Err(format!("a record has {fields} fields; at most {MOST_FIELDS} are read"));
    }
    Ok(())
}

/// The pose of a scan, with a note if its quaternion was normalised. Without a pose, or without a
/// part of it, the scan's coordinates are those of the file.
fn pose_of(cloud: &PointCloud) -> Result<(Isometry3, Option<String>), String> {
    let e57::Transform { rotation: q, translation: t } =
        cloud.transform.clone().unwrap_or_default();
    pose::from_quaternion([t.x, t.y, t.z], Quaternion::new(q.w, q.x, q.y, q.z))
}

/// One structured scan of a file.
#[derive(Debug)]
struct E57View {
    path: PathBuf,
    at: Place,
    cloud: PointCloud,
}

impl LoadView for E57View {
    fn load(&self, notes: &mut Vec<String>) -> Result<FramedImage, ReadError> {
        let mut reader = reader(&self.path)?;
        let raw = reader.pointcloud_raw(&self.cloud);
        let raw = raw.map_err(|e| damaged(&self.path, self.at.clone(), &e))?;
        let refused = |problem| ReadError::damaged(&self.path, self.at.clone(), problem);
        let cells = records::read(&self.cloud, raw).map_err(refused)?;
        let grid = grid::of(cells, self.cloud.index_bounds.as_ref(), notes);
        let (size, points) = grid.map_err(refused)?;
        survey::framed(&self.path, &self.at, size, points, None, notes)
    }

    fn place(&self) -> Place {
        self.at.clone()
    }
}

/// A reader of a regular file whose XML part fits into the file.
fn reader(path: &Path) -> Result<E57Reader<File>, ReadError> {
    let mut file = input::open(path)?;
    let refused = |error: e57::Error| damaged(path, Place::Whole, &error);
    let header = Header::read(&mut file).map_err(refused)?;
    let io = |error| ReadError::io(path, error);
    let size = file.metadata().map_err(io)?.len();
    if header.xml_length > size {
        let announced = header.xml_length;
        let problem = format!("the file announces {announced} bytes of XML, but has {size} bytes");
        return Err(ReadError::damaged(path, Place::Whole, problem));
    }
    file.rewind().map_err(io)?;
    E57Reader::new(file).map_err(refused)
}

fn damaged(path: &Path, at: Place, error: &e57::Error) -> ReadError {
    ReadError::damaged(path, at, format!("{error}; copy or export the file again"))
}

#[cfg(test)]
mod tests;
