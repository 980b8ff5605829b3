//! Real files of other programs, and files that the crate `e57` writes here.

use crate::test_data::{shared, with_causes};
use crate::{ReadError, Scan};
use e57::{
    E57Writer, IndexBounds, Quaternion, Record, RecordDataType, RecordName, RecordValue, Transform,
    Translation,
};
use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;
use transect_device::{Note, Pixel, View};
use transect_geometry::{LengthUnit, Point3};

/// The grid of the files that are written here.
const ROWS: usize = 4;
const COLS: usize = 5;

/// A structured scan to be written.
struct Written {
    /// The coordinates, as doubles or as scaled integers of 0.1 mm.
    names: [RecordName; 3],
    scaled: bool,
    /// Row, column, coordinates and invalid state.
    records: Vec<([usize; 2], [f64; 3], i64)>,
    bounds: Option<IndexBounds>,
    pose: Option<Transform>,
    name: Option<&'static str>,
}

impl Written {
    /// A wall at x = 3, as a scanner at the origin sees it: rows upwards, columns to the right.
    fn wall() -> Self {
        let point = |row, col| ([row, col], [3.0, 2.0 - col as f64, row as f64 - 1.0], 0);
        let cells = (0..COLS).flat_map(|col| (0..ROWS).map(move |row| (row, col)));
        Self {
            names: [RecordName::CartesianX, RecordName::CartesianY, RecordName::CartesianZ],
            scaled: false,
            records: cells.map(|(row, col)| point(row, col)).collect(),
            bounds: None,
            pose: None,
            name: Some("hall"),
        }
    }

    /// The same wall as ranges and angles, with all azimuths turned by some full circles.
    fn spherical(turns: f64) -> Self {
        let mut wall = Self::wall();
        wall.names = [
            RecordName::SphericalRange,
            RecordName::SphericalAzimuth,
            RecordName::SphericalElevation,
        ];
        for (_, [x, y, z], _) in &mut wall.records {
            let range = (*x * *x + *y * *y + *z * *z).sqrt();
            (*x, *y, *z) = (range, y.atan2(*x) + 2.0 * PI * turns, (*z / range).asin());
        }
        wall
    }

    fn prototype(&self) -> Vec<Record> {
        let record = |name, data_type| Record { name, data_type };
        let index = || RecordDataType::Integer { min: 0, max: 200_000 };
        let state = match self.names[0] {
            RecordName::CartesianX => RecordName::CartesianInvalidState,
            _ => RecordName::SphericalInvalidState,
        };
        let coordinate = if self.scaled {
            RecordDataType::ScaledInteger { min: -100_000, max: 100_000, scale: 1e-4, offset: 0.5 }
        } else {
            RecordDataType::F64
        };
        let mut fields = vec![
            record(RecordName::RowIndex, index()),
            record(RecordName::ColumnIndex, index()),
            record(state, RecordDataType::Integer { min: 0, max: 2 }),
        ];
        fields.extend(self.names.iter().map(|name| record(name.clone(), coordinate.clone())));
        fields
    }

    fn add_to(&self, file: &mut E57Writer<std::fs::File>) {
        let mut cloud = file.add_pointcloud("guid", self.prototype()).unwrap();
        cloud.set_name(self.name.map(str::to_owned));
        cloud.set_transform(self.pose.clone());
        for ([row, col], point, state) in &self.records {
            let integer = |n: i64| RecordValue::Integer(n);
            let mut values = vec![integer(*row as i64), integer(*col as i64), integer(*state)];
            values.extend(point.map(|c| match self.scaled {
                true => RecordValue::ScaledInteger(((c - 0.5) * 1e4).round() as i64),
                false => RecordValue::Double(c),
            }));
            cloud.add_point(values).unwrap();
        }
        if let Some(bounds) = &self.bounds {
            cloud.set_index_bounds(Some(bounds.clone()));
        }
        cloud.finalize().unwrap();
    }
}

/// A file with some scans.
fn file(scans: &[Written]) -> (tempfile::TempDir, Result<Scan, ReadError>) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("site.e57");
    let mut file = E57Writer::from_file(&path, "guid").unwrap();
    scans.iter().for_each(|scan| scan.add_to(&mut file));
    file.finalize().unwrap();
    let scan = Scan::open(&path);
    (folder, scan)
}

/// The only view of a file with one scan, with its notes.
fn loaded(scan: Written) -> Result<(View, Vec<Note>), String> {
    let (_folder, scan) = file(&[scan]);
    let view = scan.and_then(|scan| scan.views[0].load());
    view.map_err(|error| with_causes(&error))
}

fn point(view: &View, row: usize, col: usize) -> Option<Point3> {
    view.point_in_sensor(Pixel::new(row, col))
}

#[test]
fn all_kinds_of_coordinates_give_the_same_points() {
    let scaled = Written { scaled: true, ..Written::wall() };
    for scan in [Written::wall(), scaled, Written::spherical(0.0), Written::spherical(-2.0)] {
        let (view, notes) = loaded(scan).unwrap();
        assert_eq!(
            (view.image().size().to_string().as_str(), notes.len()),
            ("4 rows × 5 columns", 0)
        );
        for ([row, col], [x, y, z], _) in Written::wall().records {
            let off = point(&view, row, col).unwrap() - Point3::new(x, y, z);
            assert!(off.norm() < 1e-12, "row {row}, column {col}: {off}");
        }
    }
}

#[test]
fn absent_and_invalid_records_are_missing_pixels() {
    let mut scan = Written::wall();
    scan.records[7].2 = 1;
    scan.records[8].2 = 2;
    scan.records.remove(3);
    let (view, notes) = loaded(scan).unwrap();
    assert_eq!((view.image().valid_count(), notes.len()), (ROWS * COLS - 3, 0));
    for (row, col) in [(3, 0), (3, 1), (0, 2)] {
        assert_eq!(point(&view, row, col), None, "row {row}, column {col}");
    }
    let mut scan = Written::wall();
    scan.records[7].2 = 3;
    let error = loaded(scan).unwrap_err();
    assert!(error.ends_with("record 7: the invalid state is 3; expected 0, 1 or 2"), "{error}");
}

#[test]
fn stated_bounds_make_the_grid_unless_records_contradict_them() {
    let bounds = |row_max, column_min| IndexBounds {
        row_min: Some(0),
        row_max: Some(row_max),
        column_min: Some(column_min),
        column_max: Some(9),
        ..IndexBounds::default()
    };
    let with = |bounds| loaded(Written { bounds: Some(bounds), ..Written::wall() });
    let (view, notes) = with(bounds(5, -1)).unwrap();
    assert_eq!((view.image().size().to_string().as_str(), notes.len()), ("6 rows × 11 columns", 0));
    assert_eq!(point(&view, 0, 1), Some(Point3::new(3.0, 2.0, -1.0)), "column 0 is the second");
    let (view, notes) = with(bounds(2, 0)).unwrap();
    assert_eq!(view.image().size().to_string(), "4 rows × 10 columns");
    let wanted = "view 0 (hall): indexBounds states rows 0 to 2, but the records have 0 to 3";
    assert!(notes[0].to_string().contains(wanted), "{notes:?}");
    let error = with(bounds(1 << 40, 0)).unwrap_err();
    assert!(error.contains("at least 1 of 100 cells must have a record"), "{error}");
    let error = with(bounds(i64::MAX, i64::MIN)).unwrap_err();
    assert!(error.contains("view 0 (hall): indexBounds states "), "{error}");
}

#[test]
fn records_of_one_cell_are_returns_of_a_pulse_or_no_grid() {
    let mut scan = Written::wall();
    scan.records.push(([1, 1], [9.0, 3.0, 0.0], 0));
    let (view, notes) = loaded(scan).unwrap();
    assert_eq!(point(&view, 1, 1), Some(Point3::new(3.0, 1.0, 0.0)));
    assert!(
        notes[0].to_string().contains("view 0 (hall): 1 of 21 records left out: another"),
        "{notes:?}"
    );
    let mut scan = Written::wall();
    scan.records.iter_mut().for_each(|record| record.0 = [record.0[0] / 2, record.0[1] / 4]);
    let error = loaded(scan).unwrap_err();
    assert!(error.contains("16 of 20 records have the row and column of an earlier"), "{error}");
}

#[test]
fn degrees_in_place_of_radians_are_refused() {
    let mut scan = Written::spherical(0.0);
    scan.records[6].1[2] = -FRAC_PI_2.to_degrees();
    let error = loaded(scan).unwrap_err();
    assert!(error.contains("view 0 (hall): record 6: the elevation is -90; expected"), "{error}");
}

#[test]
fn every_scan_has_its_pose_and_a_name_of_its_own() {
    let pose = |w, z| Transform {
        rotation: Quaternion { w, x: 0.0, y: 0.0, z },
        translation: Translation { x: 4e5, y: 5e6, z: 60.0 },
    };
    let with = |pose, name| Written { pose, name, ..Written::wall() };
    let scans = [
        with(Some(pose(1.0, 1.0)), Some("hall")),
        with(None, Some("hall")),
        with(None, None),
        Written { records: Vec::new(), ..Written::wall() },
    ];
    let (_folder, scan) = file(&scans);
    let scan = scan.unwrap();
    let names: Vec<&str> = scan.views.iter().map(|view| view.name()).collect();
    assert_eq!(names, ["hall #0", "hall #1", "scan 2"]);
    assert_eq!((scan.name.as_str(), scan.unit, scan.inputs.len()), ("site", LengthUnit::Metre, 1));
    // A quarter turn about z: x becomes y.
    let turned = scan.views[0].world_from_sensor() * Point3::new(3.0, 0.0, 0.0);
    assert!((turned - Point3::new(4e5, 5e6 + 3.0, 60.0)).norm() < 1e-9, "{turned}");
    assert!(
        scan.notes[0]
            .to_string()
            .ends_with("view 0 (hall #0): quaternion of length 1.4142 normalised")
    );
    assert!(scan.notes[1].text.contains("1 of 4 scans left out: scan 3 (hall #3) holds no point"));
    let (_folder, scan) = file(&[with(Some(pose(0.0, 0.0)), None)]);
    let error = scan.unwrap_err().to_string();
    assert!(error.ends_with("view 0 (scan 0): the quaternion has length 0, which is no rotation"));
}

/// The answer to a file: its views as rows × columns and valid pixels, or the error.
fn answer(path: &Path) -> String {
    let loaded = Scan::open(path).and_then(|scan| {
        let views = scan.views.iter().map(|view| {
            let (view, _) = view.load()?;
            Ok(format!("{}, {} valid", view.image().size(), view.image().valid_count()))
        });
        views.collect::<Result<Vec<_>, _>>()
    });
    loaded.map_or_else(|error| with_causes(&error), |views| views.join("; "))
}

#[test]
fn samples_of_other_programs_open_or_are_refused_with_their_reason() {
    let Some(folder) = shared("e57_samples") else { return };
    let samples = [
        ("cartesian_invalid_state_single", "scan 0 (scan 0) has 3 points without rowIndex"),
        ("corrupt_crc", "invalid checksum (expected: [18, 82, 96, 122], actual: [254, 66, 197"),
        ("corrupt_crc", " for page 33; copy or export the file again"),
        ("empty", "the file holds no scan; export it again"),
        ("empty_pc", "scan 0 (scan 0) holds no point"),
        ("float_intensity_without_min_max", "has 1 points without rowIndex and columnIndex"),
        ("integer_intensity", "has 2 points without rowIndex and columnIndex"),
        ("las2e57_no_images_tag", "has 153 points without rowIndex and columnIndex"),
        ("no_ext_namespace", "has 1 points without rowIndex and columnIndex"),
        ("original_guids", "has 1 points without rowIndex and columnIndex"),
        // All rows, columns and coordinates of this file are 0, for libE57, too.
        ("read_error", "view 0 (scan 0): the scan has 1 rows × 1 columns, so no cell has"),
        ("scaled_integer_intensity", "has 2 points without rowIndex and columnIndex"),
        ("testWithNormals", "(dummyWithNormals - Cloud) has 2 points without rowIndex"),
        ("tinyCartesianFloatRgb", "(exp2.fls.subsampled) has 2090 points without rowIndex"),
        ("tiny_pc_and_images", "has 2 points without rowIndex and columnIndex"),
        ("tiny_pc_with_extension", "has 1 points without rowIndex and columnIndex"),
        ("tiny_spherical", "has 360 points without rowIndex and columnIndex; export the setups"),
        ("translationWithoutRotation", "(Scan 0) has 4 points without rowIndex"),
    ];
    for (name, wanted) in samples {
        let found = answer(&folder.join(format!("{name}.e57")));
        assert!(found.contains(wanted), "{name}: {found}");
    }
    let files = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path());
    let files = files.filter(|p| p.extension().is_some_and(|e| e == "e57")).count();
    assert_eq!(files, samples.len() - 1, "each file has its line");
}

#[test]
fn a_terrestrial_scan_opens_with_its_absent_records_missing() {
    let Some(folder) = shared("tls_pump_e57") else { return };
    let found = answer(&folder.join("pumpAVisualReferenceImage.e57"));
    assert_eq!(found, "1074 rows × 345 columns, 155201 valid");
}
