//! Manifests as a whole: their keys, units and poses, and what their errors name.

mod images;

use super::*;
use crate::PlanesEntry;
use crate::npy;
use crate::test_data::{in_unit, with_causes};
use std::path::PathBuf;
use transect_device::{Pixel, Point3};
use transect_geometry::LengthUnit;

const POSE: &str = "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]";

/// A folder with a 2 × 2 image `a.npy`, its manifest made of parts.
struct Folder(tempfile::TempDir);

impl Folder {
    fn with(top: &str, view: &str) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.image("a.npy", &[2, 2], &[1.0, f32::NAN, 2.0, -1.0]);
        let text = format!("{{ {top} \"views\": [ {{ {view} }} ] }}");
        std::fs::write(folder.path("scan.json"), text).unwrap();
        folder
    }

    fn pinhole(more: &str) -> Self {
        let view = format!(
            r#""file": "a.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5,
            "pose": {POSE}{more}"#
        );
        Self::with(r#""unit": "mm","#, &view)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn image(&self, name: &str, shape: &[usize], values: &[f32]) {
        let mut bytes = Vec::new();
        npy::write_header(&mut bytes, "<f4", shape).unwrap();
        bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        std::fs::write(self.path(name), bytes).unwrap();
    }

    /// Replaces a text of the manifest wherever it stands.
    fn replace(&self, text: &str, by: &str) {
        let manifest = std::fs::read_to_string(self.path("scan.json")).unwrap();
        assert!(manifest.contains(text), "{text} is not in {manifest}");
        std::fs::write(self.path("scan.json"), manifest.replace(text, by)).unwrap();
    }

    fn open(&self) -> Result<Scan, ReadError> {
        Scan::open(self.0.path())
    }

    fn error(&self) -> String {
        with_causes(&self.open().and_then(|s| s.views[0].load().map(drop)).unwrap_err())
    }
}

#[test]
fn a_manifest_opens_and_its_view_loads() {
    let scan = Folder::pinhole(r#", "rows": 2, "cols": 2"#);
    let opened = scan.open().unwrap();
    assert_eq!(opened.unit, LengthUnit::Millimetre);
    assert_eq!(opened.notes, []);
    assert_eq!(opened.inputs, [scan.path("scan.json"), scan.path("a.npy")]);
    let (view, notes) = opened.views[0].load().unwrap();
    assert!(notes.is_empty());
    assert_eq!(view.image().valid_count(), 2, "NaN and -1 are missing");
    let point = view.point_in_sensor(Pixel::new(1, 0)).unwrap();
    assert_eq!(point, Point3::new(-0.5, 0.5, 2.0));
}

#[test]
fn a_unit_is_never_guessed() {
    let pinhole = Folder::pinhole("");
    pinhole.replace(r#""unit": "mm","#, "");
    let error = pinhole.error();
    assert!(
        error
            .ends_with("scan.json: no length unit; add \"unit\": \"m\" or pass the setting `unit`")
    );
    let given = Scan::open_with(&pinhole.path("scan.json"), &in_unit(LengthUnit::Inch)).unwrap();
    assert_eq!(given.unit, LengthUnit::Inch);
    let unknown = Folder::pinhole("");
    unknown.replace("\"mm\"", "\"furlong\"");
    assert!(unknown.error().contains("\"unit\" must be one of m, dm,"), "{}", unknown.error());
}

#[test]
fn two_units_are_a_conflict_and_never_a_conversion() {
    let scan = Folder::pinhole("");
    let error = Scan::open_with(scan.0.path(), &in_unit(LengthUnit::Metre)).unwrap_err();
    assert!(error.to_string().contains("the unit is mm, but m was asked for"), "{error}");
    assert!(Scan::open_with(scan.0.path(), &in_unit(LengthUnit::Millimetre)).is_ok());
}

#[test]
fn unknown_keys_are_told_with_their_place_at_every_level() {
    let view = format!(
        r#""file": "a.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0, "cy": 0,
        "theta0": 1, "pose": {POSE}"#
    );
    let planes = r#""planes": {"normal": [0,0,1], "offset": 0, "interval": 1, "count": 3}"#;
    let folder =
        Folder::with(&format!(r#""unit": "m", "colour": 1, "scene": "x", {planes},"#), &view);
    let notes = folder.open().unwrap().notes;
    let ends = [
        "scan.json: unknown key \"colour\" ignored",
        "scan.json, view 0 (a.npy): unknown key \"theta0\" ignored",
        "scan.json: unknown key \"planes.count\" ignored",
    ];
    assert_eq!(notes.len(), 3, "{notes:?}");
    for (note, end) in notes.iter().zip(ends) {
        assert!(note.to_string().ends_with(end), "{note}");
    }
    let twice = Folder::with(r#""unit": "m","#, &format!("{view} }}, {{ {view}")).open().unwrap();
    let end = "scan.json, view 0 (a.npy): unknown key \"theta0\" ignored, in 2 views";
    assert!(twice.notes[0].to_string().ends_with(end), "{:?}", twice.notes);
}

#[test]
fn a_view_states_how_far_its_pose_may_be_wrong() {
    let stated = r#", "pose_sigma": {"rotation": 0.005, "translation": 2}"#;
    let scan = Folder::pinhole(stated).open().unwrap();
    let sigma = crate::PoseSigma { rotation: 0.005, translation: 2.0 };
    assert_eq!((scan.views[0].pose_sigma(), scan.notes), (Some(sigma), Vec::new()));
    for (wrong, found) in [("0.005", "0"), ("0.005", "-1"), ("\"translation\"", "\"place\"")] {
        let error = Folder::pinhole(&stated.replace(wrong, found)).error();
        assert!(error.contains("view 0 (a.npy)") && error.contains("pose_sigma"), "{error}");
    }
}

#[test]
fn a_view_states_how_far_its_surface_may_be_off() {
    let stated = r#", "surface_sigma": 0.25"#;
    let scan = Folder::pinhole(stated).open().unwrap();
    assert_eq!((scan.views[0].surface_sigma(), scan.notes), (Some(0.25), Vec::new()));
    let elsewhere = scan.views[0].clone().with_pose(transect_geometry::Isometry3::identity());
    assert_eq!(elsewhere.surface_sigma(), None);
    for wrong in ["-1", "NaN", "\"small\""] {
        let error = Folder::pinhole(&stated.replace("0.25", wrong)).error();
        assert!(error.contains("view 0 (a.npy)") && error.contains("surface_sigma"), "{error}");
    }
}

#[test]
fn poses_that_are_not_finite_name_file_and_view() {
    for bad in ["NaN", "-Infinity", "null"] {
        let folder = Folder::pinhole("");
        folder.replace("[1,0", &format!("[{bad},0"));
        let error = folder.error();
        let end = "scan.json, view 0 (a.npy): the pose has a number that is not finite";
        assert!(error.ends_with(end), "{error}");
    }
}

#[test]
fn rounded_rotations_are_repaired_with_one_note() {
    let folder = Folder::pinhole("");
    folder.replace("[1,0", "[1.0001,0");
    let notes = folder.open().unwrap().notes;
    let wanted = "1 of 1 poses replaced by the nearest rotation; \
                  largest deviation from orthonormal 2.0e-4, view 0 (a.npy)";
    assert!(notes[0].text.ends_with(wanted), "{notes:?}");
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let pinhole = |replaced: &str, by: &str| {
        let folder = Folder::pinhole("");
        folder.replace(replaced, by);
        folder.error()
    };
    let at = "view 0 (a.npy): ";
    for (replaced, by, wanted) in [
        ("\"fx\": 2,", "", format!("{at}missing field `fx`")),
        (
            "\"fx\": 2,",
            "\"fx\": \"2\",",
            format!("{at}\"fx\": invalid type: string \"2\", expected f64"),
        ),
        ("\"fx\": 2,", "\"fx\": 0,", "a.npy: the sensor is not usable: fx = 0".to_owned()),
        (
            "pinhole",
            "sonar",
            format!(
                "{at}\"sensor\" must be one of spherical, pinhole, light_stripe, lookup_table,"
            ),
        ),
        (
            "0,0,0,1]",
            "0,0,1]",
            format!("{at}\"pose\" must be 16 numbers, or 4 rows of 4; it has 15 numbers"),
        ),
        ("0,0,0,1]", "0,0,0,2]", format!("{at}the last row of the pose")),
        ("[1,0", "[-1,0", format!("{at}the pose is a reflection")),
        (
            "\"unit\"",
            "\"sigma\": -1, \"unit\"",
            "\"sigma\" must be a length of at least 0".to_owned(),
        ),
        ("\"unit\"", "unit", "not valid JSON for this purpose: key must be a string".to_owned()),
        ("\"a.npy\"", "\"b.npy\"", "none of its 1 views has a file".to_owned()),
    ] {
        let error = pinhole(replaced, by);
        assert!(error.contains(&wanted), "{by}: {error}");
    }
}

#[test]
fn planes_that_are_none_are_refused_before_any_image_is_read() {
    let planes = r#""unit":"m", "planes": {"normal": [0,0,1], "offset": 0, "interval": 0},"#;
    let view = format!(
        r#""file": "a.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0, "cy": 0, "pose": {POSE}"#
    );
    let error = Folder::with(planes, &view).error();
    let end = "\"planes\" is not usable: the plane interval must be a positive length, got 0";
    assert!(error.ends_with(end), "{error}");
}

/// After a byte order mark, as some editors write it.
#[test]
fn poses_of_four_rows_are_read() {
    let folder = Folder::pinhole("");
    folder.replace(POSE, "[[1,0,0,7], [0,1,0,8], [0,0,1,9], [0,0,0,1]]");
    folder.replace("{ \"unit\"", "\u{feff}{ \"unit\"");
    let scan = folder.open().unwrap();
    let origin = scan.views[0].world_from_sensor() * Point3::origin();
    assert_eq!(origin, Point3::new(7.0, 8.0, 9.0));
}

#[test]
fn the_true_pose_is_kept_as_information() {
    let folder = Folder::pinhole(&format!(r#", "pose_true": {POSE}"#));
    let (manifest, notes) = read_manifest(&folder.path("scan.json")).unwrap();
    let identity = crate::row_major(&transect_geometry::Isometry3::identity());
    assert_eq!((manifest.views[0].pose_true, notes), (Some(identity), Vec::new()));
    // Wrong as it may be, it is not used.
    let shifted = POSE.replace("1,0,0,0", "7,0,0,9");
    let folder = Folder::pinhole(&format!(r#", "pose_true": {shifted}"#));
    assert!(folder.open().unwrap().views[0].load().is_ok());
    let short = Folder::pinhole(r#", "pose_true": [1]"#).error();
    assert!(
        short.ends_with("\"pose_true\" must be 16 numbers, or 4 rows of 4; it has 1 numbers"),
        "{short}"
    );
    for note in [r#""unknown""#, r#"{"x": 1}"#, r#"[[1, 0], [0, 1]]"#] {
        let folder = Folder::pinhole(&format!(r#", "pose_true": {note}"#));
        let (manifest, notes) = read_manifest(&folder.path("scan.json")).unwrap();
        assert_eq!((manifest.views[0].pose_true, notes), (None, Vec::new()), "{note}");
    }
}

#[test]
fn a_written_manifest_reads_back() {
    let identity = crate::row_major(&transect_geometry::Isometry3::identity());
    let far = crate::row_major(&transect_geometry::Isometry3::translation(5.4e6, 1.0, 2.0));
    let view = |file: &str, sensor| ViewEntry::new(file.to_owned(), sensor, identity);
    let spherical = SensorEntry::Spherical { theta0: -3.0, dtheta: 0.1, phi0: -1.0, dphi: 0.2 };
    let grid = SensorEntry::Grid { viewpoint: [0.0, 0.0, 1.0] };
    let manifest = Manifest {
        name: "a \"room\"".to_owned(),
        unit: Some(LengthUnit::Foot),
        sigma: Some(0.1 + 0.2),
        planes: Some(PlanesEntry {
            normal: [0.0, 0.6, 0.8],
            offset: -1.5,
            interval: 1e-3,
            guide: None,
        }),
        size: Some(4.25),
        views: vec![
            ViewEntry { rows: Some(2), cols: Some(3), pose: far, ..view("a.npy", spherical) },
            ViewEntry { scale: Some(1e-3), pose_true: Some(far), ..view("b.png", grid) },
        ],
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.json");
    crate::write_file(&path, |out| write_manifest(&manifest, "manifest", out)).unwrap();
    assert_eq!(read_manifest(&path).unwrap(), (manifest, Vec::new()));
}
