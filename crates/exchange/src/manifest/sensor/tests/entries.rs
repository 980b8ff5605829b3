//! The keys of every sensor, read and written.

use super::*;
use crate::test_data::scan_folder;
use crate::{Manifest, ViewEntry, read_manifest, write_manifest};
use transect_device::DepthOffsets;
use transect_sensors::LightStripeParameters;
use transect_sensors::light_stripe::stripe::{Peak, StripeFinder, StripeProfile, StripeShape};
use transect_sensors::lookup_table::{CalibrationOptions, DepthPairs, ScanPlane};

fn view(sensor: SensorEntry) -> ViewEntry {
    let pose = crate::row_major(&transect_geometry::Isometry3::identity());
    let file = "image.npy".to_owned();
    ViewEntry::new(file, sensor, pose)
}

/// What a written sensor is read back as, with the text it was written to.
fn round_trip(sensor: &SensorEntry) -> (SensorEntry, String) {
    let manifest = Manifest::new("scan".to_owned(), vec![view(sensor.clone())]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.json");
    crate::write_file(&path, |out| write_manifest(&manifest, "manifest", out)).unwrap();
    let (back, notes) = read_manifest(&path).unwrap();
    assert_eq!(notes, []);
    (back.views[0].sensor.clone(), std::fs::read_to_string(&path).unwrap())
}

/// Reads a sensor from keys beside `file`, with the notes.
fn read(keys: &str) -> Result<(SensorEntry, Vec<Note>), String> {
    let folder = scan_folder(&[&format!(r#""file": "image.npy", {keys}"#)]);
    let read = read_manifest(&folder.path().join("scan.json"));
    let (manifest, notes) = read.map_err(|e| e.to_string())?;
    Ok((manifest.views[0].sensor.clone(), notes))
}

const STRIPE: &str = r#""sensor": "light_stripe", "camera_rows": 494, "camera_cols": 768,
    "focal_length": 16, "cell_width": 0.0084, "cell_height": 0.0098, "x_center": 384,
    "y_center": 246.5, "baseline": 300, "fan_angle": 1.0"#;

const TABLE: &str = r#""sensor": "lookup_table", "theta0": -0.3, "dtheta": 0.01,
    "calibration": "sweeps.csv", "y0": 5, "dy": -0.5, "mounting": "yz""#;

#[test]
fn a_light_stripe_reads_back_as_it_was_written() {
    let mut parameters = LightStripeParameters::smart_eye();
    let profile = StripeProfile::gaussian(6.5, 200.0);
    let finder = StripeFinder {
        least_height: 31.0,
        median_rows: 3,
        peak: Peak::WholeCell,
        ..StripeFinder::new(profile)
    };
    let listed = LightStripeEntry::new(&parameters, Some(finder.into()));
    assert_eq!(listed.parameters(200), parameters);
    assert_eq!(StripeEntry::from(finder).finder(200.0), finder);
    parameters.farthest = f64::INFINITY;
    let angles = AnglesEntry::Steps { theta0: 1.0, dtheta: -0.002 };
    let steps = LightStripeEntry { angles, ..LightStripeEntry::new(&parameters, None) };
    for entry in [listed, steps] {
        let entry = SensorEntry::LightStripe(entry);
        let (back, text) = round_trip(&entry);
        assert_eq!(back, entry, "{text}");
    }
}

#[test]
fn a_light_stripe_has_the_documented_defaults() {
    let keys = format!(r#"{STRIPE}, "theta0": 1, "dtheta": 0.01, "stripe": {{}}"#);
    let (sensor, notes) = read(&keys).unwrap();
    assert_eq!(notes, []);
    let SensorEntry::LightStripe(entry) = sensor else { panic!("{sensor:?}") };
    let parameters = &entry.parameters;
    assert_eq!(
        (parameters.mirror_axis, parameters.mirror_face, parameters.farthest),
        (0.0, 0.0, f64::INFINITY)
    );
    let stripe = entry.stripe.unwrap();
    assert_eq!(stripe, StripeEntry::default());
    assert_eq!((stripe.shape, stripe.width, stripe.height), (StripeShape::Triangle, 8.0, None));
    let library = StripeFinder::new(StripeProfile::triangle(8.0, 90.0));
    assert_eq!(stripe.finder(90.0), library);
    assert_eq!((library.median_rows, library.peak), (5, Peak::SubCell), "as the table says");
    let angles = entry.parameters(3).theta_laser.as_radians().to_vec();
    assert_eq!(angles, [1.0, 1.01, 1.02]);
}

#[test]
fn a_lookup_table_reads_back_as_it_was_written() {
    let viewpoints = ViewpointsEntry { projector: [-30.0, 0.0], receiver: [30.0, 0.5] };
    let entry = LookupTableEntry {
        theta0: -0.36,
        dtheta: 0.0019,
        calibration: "sweeps.csv".to_owned(),
        median_window: 1,
        pairs: DepthPairs::HalfApart,
        y0: -20.0,
        dy: 0.25,
        mounting: ScanPlane::Xz,
        tilt: 0.1,
        viewpoints: Some(viewpoints),
    };
    let other = LookupTableEntry {
        viewpoints: None,
        pairs: DepthPairs::Neighbours,
        mounting: ScanPlane::Yz,
        ..entry.clone()
    };
    for entry in [entry, other] {
        let entry = SensorEntry::LookupTable(entry);
        let (back, text) = round_trip(&entry);
        assert_eq!(back, entry, "{text}");
    }
}

#[test]
fn a_lookup_table_has_the_documented_defaults() {
    let (sensor, _) = read(TABLE).unwrap();
    let SensorEntry::LookupTable(entry) = sensor else { panic!("{sensor:?}") };
    assert_eq!(entry.options(), CalibrationOptions::default());
    let usual = CalibrationOptions { median_window: 7, pairs: DepthPairs::Neighbours };
    assert_eq!(entry.options(), usual, "as the table says");
    assert_eq!((entry.tilt, entry.viewpoints), (0.0, None));
}

#[test]
fn a_pinhole_reads_back_as_it_was_written() {
    let intrinsics = Intrinsics { fx: 585.0, fy: 586.0, cx: 320.0, cy: 240.0 };
    let plain = SensorEntry::pinhole(intrinsics);
    let (back, text) = round_trip(&plain);
    assert_eq!(back, plain);
    assert!(!text.contains("holds") && !text.contains("distortion"), "{text}");
    let distortion = Some([-0.1, 0.02, 1e-3, -2e-3, 0.3]);
    let lens = LensEntry::Intrinsics { intrinsics, distortion };
    let offsets = DepthOffsets::new(2, 2, vec![0.0, 1e-3, -2e-3, 0.5]).unwrap();
    let depth_offsets = Some(offsets.clone());
    let distorted = PinholeEntry { lens, holds: PinholeScale::RayLength, depth_offsets };
    let depth_offsets = Some(offsets.after_scale(0.99).unwrap());
    let scaled = PinholeEntry { depth_offsets, ..distorted.clone() };
    let lens = LensEntry::Rays { rays: "rays.npy".to_owned() };
    let rays = PinholeEntry { lens, holds: PinholeScale::Depth, depth_offsets: None };
    for entry in [distorted, scaled, rays] {
        let entry = SensorEntry::Pinhole(entry);
        assert_eq!(round_trip(&entry).0, entry);
    }
}

#[test]
fn keys_of_another_sensor_are_told() {
    let stripe =
        format!(r#"{STRIPE}, "theta_laser": [1, 1.1], "theta0": 1, "stripe": {{"rows": 1}}"#);
    let table = format!(r#"{TABLE}, "baseline": 3"#);
    let rays = r#""sensor": "pinhole", "rays": "r.npy", "fx": 2"#;
    for (keys, unknown) in [
        (stripe.as_str(), &["stripe.rows", "theta0"][..]),
        (&table, &["baseline"]),
        (rays, &["fx"]),
    ] {
        let (_, notes) = read(keys).unwrap();
        assert_eq!(notes.len(), unknown.len(), "{notes:?}");
        for (note, key) in notes.iter().zip(unknown) {
            let end = format!("view 0 (image.npy): unknown key \"{key}\" ignored");
            assert!(note.to_string().ends_with(&end), "{note}");
        }
    }
}

/// Each error names its view, and has the text beside it.
fn assert_named(errors: &[(String, &str)]) {
    for (error, wanted) in errors {
        assert!(error.contains("view 0 (image.npy): ") && error.contains(wanted), "{error}");
    }
}

#[test]
fn what_is_missing_or_wrong_in_a_light_stripe_names_its_key() {
    let stripe = |more: &str| read(&format!("{STRIPE}, {more}")).unwrap_err();
    let steps = r#""theta0": 1, "dtheta": 0.1"#;
    assert_named(&[
        (stripe(r#""theta0": 1"#), "no \"dtheta\"; it must be a number of radians, unless"),
        (
            stripe(r#""theta_laser": 3"#),
            "\"theta_laser\": invalid type: integer `3`, expected a sequence",
        ),
        (stripe(&format!(r#"{steps}, "stripe": 3"#)), "stripe must be a JSON object"),
        (
            stripe(&format!(r#"{steps}, "stripe": {{"shape": "box"}}"#)),
            "\"stripe.shape\": unknown variant `box`, expected `triangle` or `gaussian`",
        ),
        (
            stripe(&format!(r#"{steps}, "stripe": {{"peak": "exact"}}"#)),
            "\"stripe.peak\": unknown variant `exact`, expected `whole_cell` or `sub_cell`",
        ),
        (
            read(&STRIPE.replace("494", "-1")).unwrap_err(),
            "\"camera_rows\": invalid value: integer `-1`, expected usize",
        ),
    ]);
}

#[test]
fn what_is_missing_or_wrong_in_a_lookup_table_names_its_key() {
    let table = |from: &str, to: &str| {
        assert!(TABLE.contains(from));
        read(&TABLE.replace(from, to)).unwrap_err()
    };
    assert_named(&[
        (table("\"yz\"", "\"xy\""), "\"mounting\": unknown variant `xy`, expected `xz` or `yz`"),
        (table(r#", "mounting": "yz""#, ""), "missing field `mounting`"),
        (
            table("\"sweeps.csv\"", "7"),
            "\"calibration\": invalid type: integer `7`, expected a string",
        ),
        (
            table("\"y0\"", "\"pairs\": \"all\", \"y0\""),
            "\"pairs\": unknown variant `all`, expected `neighbours` or",
        ),
        (
            table("\"y0\"", "\"projector\": [0, 0], \"y0\""),
            "no \"receiver\"; it must be [u, v], and stand with",
        ),
        (
            table("\"y0\"", "\"receiver\": [0, 0], \"y0\""),
            "no \"projector\"; it must be [u, v], and stand with",
        ),
        (
            table("\"y0\"", "\"receiver\": [0], \"y0\""),
            "\"receiver\": invalid length 1, expected an array of length 2",
        ),
    ]);
}

#[test]
fn what_is_missing_or_wrong_in_a_pinhole_names_its_key() {
    let camera = r#""sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0, "cy": 0"#;
    let pinhole = |more: &str| read(&format!("{camera}, {more}")).unwrap_err();
    assert_named(&[
        (
            pinhole(r#""holds": "disparity""#),
            "\"holds\": unknown variant `disparity`, expected `depth` or",
        ),
        (
            pinhole(r#""distortion": [0, 0, 0, 0]"#),
            "\"distortion\": invalid length 4, expected an array of length 5",
        ),
        (
            pinhole(r#""distortion": [0, 0, 0, 0, null]"#),
            "\"distortion\": invalid type: null, expected f64",
        ),
    ]);
}
