//! The images that a manifest names: values, sizes and the order of their pixels.

use super::*;
use crate::OpenOptions;
use transect_device::ImageOrder;

#[test]
fn images_that_several_views_name_are_told() {
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
               zero, negative, infinite or not a number; leave this view out with the setting \
               `views`, or correct its file";
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
    folder.replace("a.npy", "a.png");
    crate::test_data::write_png(&folder.path("a.png"), 2, &[0, 3, 65535, 8]);
    let (view, notes) = folder.open().unwrap().views[0].load().unwrap();
    assert_eq!(view.image().extremes(), Some((1.5, 4.0)));
    assert_eq!(notes.len(), 1, "{notes:?}");
    folder.replace(r#", "depth_scale": 0.5"#, "");
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
    folder.replace("a.npy", "a.png");
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
