use super::*;
use crate::npy;
use crate::test_data::{in_unit, with_causes};
use crate::{OpenOptions, PlanesEntry};
use std::path::PathBuf;
use transect_device::{ImageOrder, Pixel, Point3};
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
    let text = std::fs::read_to_string(pinhole.path("scan.json")).unwrap();
    std::fs::write(pinhole.path("scan.json"), text.replace(r#""unit": "mm","#, "")).unwrap();
    let error = pinhole.error();
    assert!(
        error
            .ends_with("scan.json: no length unit; add \"unit\": \"m\" or pass the setting `unit`")
    );
    let given = Scan::open_with(&pinhole.path("scan.json"), &in_unit(LengthUnit::Inch)).unwrap();
    assert_eq!(given.unit, LengthUnit::Inch);
    std::fs::write(pinhole.path("scan.json"), text.replace("\"mm\"", "\"furlong\"")).unwrap();
    assert!(pinhole.error().contains("\"unit\" must be one of m, dm,"), "{}", pinhole.error());
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
fn images_that_several_views_name_and_equal_poses_are_told() {
    let view = |file: &str, x: usize| {
        format!(
            r#""file": "{file}", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5,
            "pose": [1,0,0,{x}, 0,1,0,0, 0,0,1,0, 0,0,0,1]"#
        )
    };
    let notes = |views: [(&str, usize); 3]| {
        let views = views.map(|(file, x)| view(file, x)).join("}, {");
        let folder = Folder::with(r#""unit": "m","#, &views);
        folder.image("b.npy", &[2, 2], &[1.0; 4]);
        folder.image("c.npy", &[2, 2], &[1.0; 4]);
        folder.open().unwrap().notes
    };
    assert_eq!(notes([("a.npy", 0), ("b.npy", 1), ("c.npy", 1)]), []);
    let equal = notes([("a.npy", 1), ("b.npy", 1), ("c.npy", 1)]);
    let text = "scan.json: all 3 views have the same pose; expected different ones";
    assert!(equal.len() == 1 && equal[0].to_string().contains(text), "{equal:?}");
    let repeated = notes([("a.npy", 0), ("b.npy", 1), ("a.npy", 2)]);
    let text = "scan.json: 2 views have the same image a.npy: views 0, 2; expected";
    assert!(repeated.len() == 1 && repeated[0].to_string().contains(text), "{repeated:?}");
}

#[test]
fn images_are_read_in_the_order_that_a_view_or_the_caller_states() {
    let camera = |more: &str| {
        let view = format!(
            r#""file": "a.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0.5, "cy": 0,
            "pose": {POSE}{more}"#
        );
        Folder::with(r#""unit": "mm","#, &view)
    };
    let point = |scan: &Scan, row, col| {
        scan.views[0].load().unwrap().0.point_in_sensor(Pixel::new(row, col))
    };
    let plain = camera("");
    let asked = |order: ImageOrder, folder: &Folder| {
        let options = OpenOptions { image_order: Some(order), ..OpenOptions::default() };
        Scan::open_with(folder.0.path(), &options)
    };
    // The file holds 1, missing / 2, missing.
    let right = plain.open().unwrap();
    for order in ImageOrder::ALL {
        let of_caller = asked(order, &plain).unwrap();
        assert!(of_caller.notes[0].text.ends_with(order.meaning()), "{:?}", of_caller.notes);
        let stated = camera(&format!(r#", "image_order": "{order}""#));
        let of_view = stated.open().unwrap();
        for (row, col) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let there = point(&of_view, row, col);
            assert_eq!(there, point(&of_caller, row, col), "{order}");
            let (in_row, in_col) = match order {
                ImageOrder::Transposed => (col, row),
                ImageOrder::Mirrored => (row, 1 - col),
                ImageOrder::UpsideDown => (1 - row, col),
                ImageOrder::SwappedCamera => (row, col),
            };
            let depth = point(&right, in_row, in_col).map(|p| p.z);
            assert_eq!(there.map(|p| p.z), depth, "{order}, row {row}, column {col}");
        }
        let twice = with_causes(&asked(order, &stated).unwrap_err());
        assert!(twice.contains(&format!("cannot be read as {order}")), "{twice}");
    }
    assert_eq!(point(&right, 1, 0), Some(Point3::new(-0.5, 1.0, 2.0)));
    let swapped = asked(ImageOrder::SwappedCamera, &plain).unwrap();
    assert_eq!(point(&swapped, 1, 0), Some(Point3::new(0.0, 0.5, 2.0)));
    let wrong = Folder::pinhole(r#", "image_order": "sideways""#).error();
    assert!(wrong.contains("\"image_order\": unknown variant `sideways`"), "{wrong}");
    let grid = Folder::with(
        r#""unit": "m","#,
        &format!(
            r#""file": "a.npy", "sensor": "grid", "viewpoint": [0, 0, 0], "pose": {POSE},
            "image_order": "transposed""#
        ),
    );
    assert!(grid.error().contains("a.npy: images of this format and sensor"), "{}", grid.error());
}

#[test]
fn offsets_of_depth_are_taken_out_and_lost_pixels_are_told() {
    let load = |value: &str| {
        let offsets = format!(
            r#", "depth_offsets": {{"rows": 2, "cols": 2, "values": [{value}, {value}, {value}, {value}]}}"#
        );
        let (view, notes) = Folder::pinhole(&offsets).open().unwrap().views[0].load().unwrap();
        let depth = |row| view.point_in_sensor(Pixel::new(row, 0)).map(|p| p.z);
        ([depth(0), depth(1)], notes)
    };
    // The depths are 1 and 2: 1 / (1 / 1 + 1) and 1 / (1 / 2 + 1), in f32.
    let ([near, far], notes) = load("1");
    assert!((near.unwrap() - 0.5).abs() < 1e-6 && (far.unwrap() - 2.0 / 3.0).abs() < 1e-6);
    assert!(notes.is_empty(), "{notes:?}");
    let ([near, far], notes) = load("-0.75");
    assert!((near.unwrap() - 4.0).abs() < 1e-6 && far.is_none());
    assert!(
        notes[0].to_string().contains("a.npy: \"depth_offsets\" take 1 pixels behind"),
        "{notes:?}"
    );
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
fn poses_that_are_not_finite_name_file_and_view() {
    for bad in ["NaN", "-Infinity", "null"] {
        let folder = Folder::pinhole("");
        let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
        let text = text.replacen("[1,0", &format!("[{bad},0"), 1);
        std::fs::write(folder.path("scan.json"), text).unwrap();
        let error = folder.error();
        let end = "scan.json, view 0 (a.npy): the pose has a number that is not finite";
        assert!(error.ends_with(end), "{error}");
    }
}

#[test]
fn rounded_rotations_are_repaired_with_one_note() {
    let folder = Folder::pinhole("");
    let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
    std::fs::write(folder.path("scan.json"), text.replacen("[1,0", "[1.0001,0", 1)).unwrap();
    let notes = folder.open().unwrap().notes;
    let wanted = "1 of 1 poses replaced by the nearest rotation; \
                  largest deviation from orthonormal 2.0e-4, view 0 (a.npy)";
    assert!(notes[0].text.ends_with(wanted), "{notes:?}");
}

#[test]
fn what_is_missing_or_wrong_is_named() {
    let pinhole = |replaced: &str, by: &str| {
        let folder = Folder::pinhole("");
        let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
        assert!(text.contains(replaced));
        std::fs::write(folder.path("scan.json"), text.replace(replaced, by)).unwrap();
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

#[test]
fn an_image_of_another_size_names_both() {
    let error = Folder::pinhole(r#", "rows": 2, "cols": 3"#).error();
    let end = "a.npy: the image has 2 rows × 2 columns, but the manifest or the camera file states 2 \
               rows × 3 columns, or most images have them";
    assert!(error.ends_with(end), "{error}");
}

#[test]
fn an_image_without_a_valid_pixel_names_its_file() {
    let folder = Folder::pinhole("");
    folder.image("a.npy", &[2, 2], &[0.0; 4]);
    let error = folder.error();
    let end = "a.npy: the view is not usable: every pixel is missing: \
               zero, negative, infinite or not a number";
    assert!(error.ends_with(end), "{error}");
    folder.image("a.npy", &[2, 2], &[1.0]);
    assert!(
        folder.error().contains("truncated: the header announces [2, 2]"),
        "{}",
        folder.error()
    );
}

#[test]
fn sixteen_bit_images_need_a_scale() {
    let folder = Folder::pinhole(r#", "depth_scale": 0.5"#);
    let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
    let text = text.replace("a.npy", "a.png");
    crate::test_data::write_png(&folder.path("a.png"), 2, &[0, 3, 65535, 8]);
    std::fs::write(folder.path("scan.json"), &text).unwrap();
    let (view, notes) = folder.open().unwrap().views[0].load().unwrap();
    assert_eq!(view.image().extremes(), Some((1.5, 4.0)));
    assert_eq!(notes.len(), 1, "{notes:?}");
    let unscaled = text.replace(r#", "depth_scale": 0.5"#, "");
    std::fs::write(folder.path("scan.json"), unscaled).unwrap();
    assert!(folder.error().contains("add \"scale\": length units per count"), "{}", folder.error());
}

/// The image of 2 × 2 pixels, in every form that programs write.
#[test]
fn integers_halves_fortran_order_and_a_third_dimension_are_read() {
    let header = |descr: &str, fortran: &str, shape: &str| {
        let text =
            format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}, }}");
        let length = (text.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00".as_slice(), &length, text.as_bytes()].concat()
    };
    let counts = [1500_u16, 0, 2000, 65535].map(u16::to_le_bytes).concat();
    let columns = [1500_u16, 2000, 0, 65535].map(u16::to_le_bytes).concat();
    let halves = [0x3e00_u16, 0x7e00, 0x4000, 0xbc00].map(u16::to_le_bytes).concat();
    let scaled = r#", "scale": 0.001, "missing": 65535"#;
    for (bytes, keys) in [
        ([header("<u2", "False", "(2, 2)"), counts.clone()].concat(), scaled),
        ([header("<u2", "True", "(2, 2)"), columns].concat(), scaled),
        ([header("<u2", "False", "(2, 2, 1)"), counts.clone()].concat(), scaled),
        ([header("<f2", "False", "(2, 2)"), halves].concat(), ""),
    ] {
        let folder = Folder::pinhole(keys);
        std::fs::write(folder.path("a.npy"), bytes).unwrap();
        let (view, notes) = folder.open().unwrap().views[0].load().unwrap();
        let image = view.image();
        assert_eq!((image.extremes(), image.valid_count()), (Some((1.5, 2.0)), 2), "{keys}");
        assert_eq!((image.get(Pixel::new(1, 0)), notes), (Some(2.0), Vec::new()), "{keys}");
    }
    let folder = Folder::pinhole("");
    let unscaled = [header("<u2", "False", "(2, 2)"), counts].concat();
    std::fs::write(folder.path("a.npy"), unscaled).unwrap();
    let wanted = "a.npy: integers need a scale; add \"scale\": length units per count to the view";
    assert!(folder.error().ends_with(wanted), "{}", folder.error());
}

#[test]
fn poses_of_four_rows_are_read() {
    let folder = Folder::pinhole("");
    let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
    let rows = "[[1,0,0,7], [0,1,0,8], [0,0,1,9], [0,0,0,1]]";
    let text = format!("\u{feff}{}", text.replace(POSE, rows));
    std::fs::write(folder.path("scan.json"), text).unwrap();
    let scan = folder.open().unwrap();
    let origin = scan.views[0].world_from_sensor() * Point3::origin();
    assert_eq!(origin, Point3::new(7.0, 8.0, 9.0));
}

/// Both forms of the key: for all views, and for one.
#[test]
fn stated_missing_values_are_missing() {
    let view = |more: &str| {
        format!(
            r#""file": "a.npy", "sensor": "pinhole", "fx": 2, "fy": 2, "cx": 0.5, "cy": 0.5,
            "pose": {POSE}{more}"#
        )
    };
    for (top, keys) in [(r#""missing": 2,"#, view("")), ("", view(r#", "missing": 2"#))] {
        let folder = Folder::with(&format!(r#""unit": "m", {top}"#), &keys);
        let (view, _) = folder.open().unwrap().views[0].load().unwrap();
        assert_eq!(view.image().extremes(), Some((1.0, 1.0)));
    }
    let wrong = Folder::pinhole(r#", "missing": "none""#).error();
    assert!(wrong.ends_with("\"missing\": a number, or [x, y, z] for a grid of points"), "{wrong}");
}

#[test]
fn two_different_scales_are_refused() {
    let wrong = Folder::pinhole(r#", "scale": 1, "depth_scale": 0.5"#).error();
    assert!(wrong.contains("the same as depth_scale, its older name, which is 0.5"), "{wrong}");
    Folder::pinhole(r#", "scale": 0.5, "depth_scale": 0.5"#).open().unwrap();
}

#[test]
fn damaged_png_images_are_refused() {
    let folder = Folder::pinhole(r#", "depth_scale": 0.5"#);
    let text = std::fs::read_to_string(folder.path("scan.json")).unwrap();
    std::fs::write(folder.path("scan.json"), text.replace("a.npy", "a.png")).unwrap();
    let counts: Vec<u16> = (0..400).collect();
    crate::test_data::write_png(&folder.path("a.png"), 20, &counts);
    let sound = std::fs::read(folder.path("a.png")).unwrap();
    for length in [0, 7, 20, sound.len() / 2] {
        std::fs::write(folder.path("a.png"), &sound[..length]).unwrap();
        assert!(folder.error().contains("a.png: cannot be decoded"), "{}", folder.error());
    }
}

#[test]
fn spherical_and_grid_sensors_load() {
    let spherical = format!(
        r#""file": "a.npy", "sensor": "spherical", "theta0": 0, "dtheta": 0.5, "phi0": 0,
        "dphi": 0.25, "pose": {POSE}"#
    );
    let scan = Folder::with(r#""unit": "m", "sigma": 0.004,"#, &spherical).open();
    let scan = scan.unwrap();
    assert_eq!(scan.sigma, Some(0.004));
    let grid =
        format!(r#""file": "g.npy", "sensor": "grid", "viewpoint": [0, 0, 5], "pose": {POSE}"#);
    let folder = Folder::with(r#""unit": "m","#, &grid);
    let points = [0., 0., 1., 1., 0., 1., 0., 1., 1., 1., 1., 1.];
    folder.image("g.npy", &[2, 2, 3], &points);
    let (view, _) = folder.open().unwrap().views[0].load().unwrap();
    assert_eq!(view.point_in_sensor(Pixel::new(1, 0)), Some(Point3::new(0.0, 1.0, 1.0)));
    folder.image("g.npy", &[2, 6], &points);
    assert!(
        folder.error().contains("shape is [2, 6], not rows × columns × 3"),
        "{}",
        folder.error()
    );
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
