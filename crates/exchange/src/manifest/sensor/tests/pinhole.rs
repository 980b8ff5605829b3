//! Cameras with depths, ray lengths, distortion, and a ray per pixel.

use super::*;

const CAMERA: &str =
    r#""file": "z.npy", "sensor": "pinhole", "fx": 4, "fy": 4, "cx": 3.5, "cy": 2.5"#;
const SIZE: ImageSize = ImageSize { rows: 6, cols: 8 };

fn folder(keys: &str) -> tempfile::TempDir {
    let folder = scan_folder(&[keys]);
    write_npy(&folder.path().join("z.npy"), &[SIZE.rows, SIZE.cols], &[2.0; 48]);
    folder
}

#[test]
fn values_may_be_depths_or_ray_lengths() {
    for (more, length) in [("", false), (r#", "holds": "ray_length""#, true)] {
        let folder = folder(&format!("{CAMERA}{more}"));
        let (view, _) = load(folder.path()).unwrap();
        let corner = view.point_in_sensor(Pixel::new(0, 0)).unwrap();
        let held = if length { corner.coords.norm() } else { corner.z };
        assert!((held - 2.0).abs() < 1e-12, "{corner}");
        assert!((corner.x / corner.z + 3.5 / 4.0).abs() < 1e-12, "{corner}");
    }
}

#[test]
fn a_principal_point_outside_the_image_is_told() {
    for (order, count) in [("", 1), (r#", "image_order": "swapped-camera""#, 0)] {
        let beside = CAMERA.replace("3.5", "5").replace("2.5", "6.5");
        let folder = folder(&format!("{beside}{order}"));
        let (_, notes) = load(folder.path()).unwrap();
        let told = notes.iter().filter(|note| note.text.contains("cx = 5, cy = 6.5 lies outside"));
        assert_eq!(told.count(), count, "{notes:?}");
    }
    let folder = folder(CAMERA);
    assert!(load(folder.path()).unwrap().1.is_empty());
}

#[test]
fn distortion_bends_the_rays_of_points() {
    let more = r#", "distortion": [-0.1, 0.02, 0.001, -0.002, 0.003]"#;
    let folder = folder(&format!("{CAMERA}{more}"));
    let (view, _) = load(folder.path()).unwrap();
    for pixel in [Pixel::new(0, 0), Pixel::new(5, 7), Pixel::new(2, 4)] {
        let p = view.point_in_sensor(pixel).unwrap();
        assert_eq!(p.z, 2.0);
        let (x, y) = (p.x / p.z, p.y / p.z);
        let r2 = x * x + y * y;
        let s = 1.0 - 0.1 * r2 + 0.02 * r2 * r2 + 0.003 * r2 * r2 * r2;
        let column = 3.5 + 4.0 * (x * s + 0.002 * x * y - 0.002 * (r2 + 2.0 * x * x));
        let row = 2.5 + 4.0 * (y * s + 0.001 * (r2 + 2.0 * y * y) - 0.004 * x * y);
        let (wanted_row, wanted_column) = (pixel.row as f64, pixel.col as f64);
        assert!((row - wanted_row).abs() < 1e-9 && (column - wanted_column).abs() < 1e-9);
    }
}

#[test]
fn a_distortion_that_cannot_be_inverted_names_key_and_pixel() {
    let folder = folder(&format!(r#"{CAMERA}, "distortion": [-0.5, 0, 0, 0, 0]"#));
    let error = error(folder.path());
    let wanted = "z.npy, row 0, column 0: \"distortion\" cannot be inverted here";
    assert!(error.contains(wanted), "{error}");
    let focal = format!(r#"{CAMERA}, "distortion": [0.1, 0, 0, 0, 0]"#);
    let error = error_with(&focal, "\"fx\": 4", "\"fx\": 0", |folder| {
        write_npy(&folder.join("z.npy"), &[6, 8], &[2.0; 48]);
    });
    assert!(error.contains("fx = 0: a positive focal length"), "{error}");
}

#[test]
fn a_table_of_rays_takes_the_place_of_the_parameters() {
    let keys = r#""file": "z.npy", "sensor": "pinhole", "rays": "rays.npy""#;
    let folder = folder(keys);
    let ray = |n: usize| [(n % 8) as f32 - 3.5, (n / 8) as f32 - 2.5, 4.0];
    let mut rays: Vec<f32> = (0..48).flat_map(ray).collect();
    let path = folder.path().join("rays.npy");
    rays[3] = f32::NAN;
    write_npy(&path, &[6, 8, 3], &rays);
    let scan = Scan::open(folder.path()).unwrap();
    assert_eq!(scan.inputs.last(), Some(&path));
    let (view, _) = load(folder.path()).unwrap();
    assert_eq!(view.point_in_sensor(Pixel::new(0, 1)), None, "a pixel without a ray");
    let corner = view.point_in_sensor(Pixel::new(5, 7)).unwrap();
    assert!((corner - Point3::new(1.75, 1.25, 2.0)).norm() < 1e-12, "{corner}");
    let array = std::fs::read(&path).unwrap();
    std::fs::write(&path, [&array[..], &array].concat()).unwrap();
    let two = error(folder.path());
    assert!(two.contains("rays.npy: \"rays\" has bytes after its last number"), "{two}");
    write_npy(&path, &[3, 16, 3], &rays);
    let other = error(folder.path());
    assert!(other.contains("rays.npy: \"rays\" has 3 rows × 16 columns, but the image"));
    rays.reverse();
    write_npy(&path, &[6, 8, 3], &rays);
    let backward = error(folder.path());
    assert!(backward.contains("rays.npy: \"rays\" is not usable: rays = "), "{backward}");
}

#[test]
fn views_that_say_the_same_share_one_table() {
    let keys = format!(r#"{CAMERA}, "distortion": [0.1, 0, 0, 0, 0]"#);
    let folder = scan_folder(&[&keys, &keys]);
    write_npy(&folder.path().join("z.npy"), &[6, 8], &[2.0; 48]);
    let scan = Scan::open(folder.path()).unwrap();
    let views: Vec<View> = scan.views.iter().map(|v| v.load().unwrap().0).collect();
    assert!(std::ptr::addr_eq(views[0].frame(), views[1].frame()));
    assert_eq!(scan.inputs.len(), 2, "each file once: {:?}", scan.inputs);
}
