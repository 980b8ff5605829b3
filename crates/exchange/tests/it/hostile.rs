//! Files from outside may hold anything: every reader answers with a value or an error that names
//! the file, never with a panic or an allocation the file does not justify.

use proptest::prelude::*;
use std::path::Path;
use transect_device::ImageSize;
use transect_exchange::{
    Counts, Scan, TriangleMesh, read_calibration, read_contours, read_mesh, read_range_grid,
    read_truth, write_file, write_npy_image, write_npy_stack, write_png_image, write_truth,
};

const GRID: &str = "ply\nformat ascii 1.0\nobj_info num_cols 2\nobj_info num_rows 2\n\
    element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 4\nproperty list uchar int vertex_indices\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 1\n1 0 1\n0 1 1\n1 1 1\n1 0\n1 1\n1 2\n1 3\n3 0 1 2\n";

const MANIFEST: &str = r#"{"unit":"m","sigma":0.1,"planes":{"normal":[0,0,1],"offset":0,"interval":1},
    "views":[{"file":"a.npy","sensor":"pinhole","fx":2,"fy":2,"cx":0,"cy":0,"rows":2,"cols":2,
    "pose":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

const STRIPE: &str = r#"{"unit":"mm","views":[{"file":"STACK","sensor":"light_stripe",
    "camera_rows":3,"camera_cols":24,"focal_length":16,"cell_width":0.27,"cell_height":2,
    "x_center":12,"y_center":1,"baseline":300,"fan_angle":1,"theta0":1.1,"dtheta":0.05,
    "stripe":{"width":4,"height":100,"median_rows":3},
    "pose":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

const TABLE: &str = r#"{"unit":"mm","views":[{"file":"a.npy","sensor":"lookup_table",
    "theta0":0,"dtheta":0.1,"calibration":"a.csv","median_window":1,"y0":0,"dy":1,
    "mounting":"xz","pose":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

const CALIBRATION: &str = "sweep,theta,p,u,v\n0,0,0.5,0,10\n0,0.1,0.5,1,10\n1,0,2.5,0,20\n\
    1,0.1,2.5,2,20\n2,0,4.5,0,30\n2,0.1,4.5,3,30\n";

const DISTORTED: &str = r#"{"unit":"m","views":[{"file":"a.npy","sensor":"pinhole",
    "fx":2,"fy":2,"cx":0,"cy":0,"distortion":[-0.1,0.02,0.01,0.01,0],
    "pose":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]}"#;

const STL: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n\
    vertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/1/1 2//2 3\nf -1 -2 \\\n-3\n";

const CONTOURS: &str = r#"{"unit":"m","planes":[{"index":3,"station":0.2,"origin":[0,0,0.2],
    "normal":[0,0,1],"x_axis":[1,0,0],"polylines":[{"closed":true,
    "points":[[0,0,0.2],[1,0,0.2],[0,1,0.2]],"sigma":[0,0,0],"views":[1,1,1]}]}]}"#;

const CONF: &str = "camera 0 0 0\nbmesh a.ply 0 0 0 0 0 0 1\n";

/// One change to a file: another byte, a cut, or a piece twice.
#[derive(Debug, Clone)]
enum Damage {
    Byte(prop::sample::Index, u8),
    Cut(prop::sample::Index),
    Repeat(prop::sample::Index, prop::sample::Index),
}

fn damages() -> impl Strategy<Value = Vec<Damage>> {
    let one = prop_oneof![
        4 => (any::<prop::sample::Index>(), any::<u8>()).prop_map(|(i, b)| Damage::Byte(i, b)),
        4 => (any::<prop::sample::Index>(), prop::sample::select(b"0123456789-.eE, \n".as_slice()))
            .prop_map(|(i, b)| Damage::Byte(i, b)),
        1 => any::<prop::sample::Index>().prop_map(Damage::Cut),
        1 => (any::<prop::sample::Index>(), any::<prop::sample::Index>())
            .prop_map(|(i, j)| Damage::Repeat(i, j)),
    ];
    prop::collection::vec(one, 1..6)
}

fn damaged(sound: &[u8], damages: &[Damage]) -> Vec<u8> {
    let mut bytes = sound.to_vec();
    for damage in damages {
        let length = bytes.len().max(1);
        match damage {
            Damage::Byte(at, value) => {
                if let Some(byte) = bytes.get_mut(at.index(length)) {
                    *byte = *value;
                }
            }
            Damage::Cut(at) => bytes.truncate(at.index(length)),
            Damage::Repeat(from, to) => {
                let (from, to) = (from.index(length), to.index(length));
                bytes.extend_from_within(
                    from.min(to).min(bytes.len())..from.max(to).min(bytes.len()),
                );
            }
        }
    }
    bytes
}

fn npy() -> Vec<u8> {
    let mut bytes = Vec::new();
    let size = transect_device::ImageSize { rows: 2, cols: 2 };
    write_npy_image(size, &[1.0, 2.0, 3.0, 4.0], &mut bytes).unwrap();
    bytes
}

fn truth() -> Vec<u8> {
    let mut bytes = Vec::new();
    let corner = |x, y| transect_geometry::Point3::new(x, y, 0.0);
    let vertices = vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)];
    write_truth(&TriangleMesh { vertices, faces: vec![[0, 1, 2]] }, &mut bytes).unwrap();
    bytes
}

/// Images of a stripe of 3 rows × 24 columns, moving from step to step.
fn stack() -> Vec<u8> {
    let light = |n: usize| 100 - 20 * (n % 24).abs_diff(10 + n / 72).min(5) as u8;
    (0..4 * 72).map(light).collect()
}

const CAMERA: ImageSize = ImageSize { rows: 3, cols: 24 };

fn stack_file() -> Vec<u8> {
    let mut bytes = Vec::new();
    write_npy_stack(4, CAMERA, Counts::Eight(&stack()), &mut bytes).unwrap();
    bytes
}

fn png_file(step: usize) -> Vec<u8> {
    let (stack, mut bytes) = (stack(), Vec::new());
    let part = stack.get(step * 72..(step + 1) * 72).unwrap();
    write_png_image(CAMERA, Counts::Eight(part), &mut bytes).unwrap();
    bytes
}

/// One triangle.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid in binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend(1_u32.to_le_bytes());
    let corners = [0.0_f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    bytes.extend(corners.iter().flat_map(|c| c.to_le_bytes()));
    bytes.extend([0; 2]);
    bytes
}

/// An error must name the file it is about.
fn names_its_file<T>(result: Result<T, transect_exchange::ReadError>, folder: &Path) {
    if let Err(error) = result {
        let text = error.to_string();
        assert!(text.contains(&folder.display().to_string()), "{text}");
    }
}

fn with_file(name: &str, bytes: &[u8], read: impl FnOnce(&Path, &Path)) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    read(&path, folder.path());
}

fn open_and_load(folder: &Path) {
    match Scan::open(folder) {
        Ok(scan) => scan.views.iter().for_each(|v| names_its_file(v.load(), folder)),
        Err(error) => names_its_file::<()>(Err(error), folder),
    }
}

/// What must hold before anything is damaged, or the tests below would test nothing.
#[test]
fn the_sound_files_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let loads = || Scan::open(folder.path()).and_then(|scan| scan.views[0].load()).map(drop);
    write("a.npy", &npy());
    write("a.csv", CALIBRATION.as_bytes());
    write("stack.npy", &stack_file());
    std::fs::create_dir(folder.path().join("stack")).unwrap();
    (0..4).for_each(|step| write(&format!("stack/{step}.png"), &png_file(step)));
    let stacks = ["stack.npy", "stack"].map(|name| STRIPE.replace("STACK", name));
    for manifest in [MANIFEST, TABLE, DISTORTED, &stacks[0], &stacks[1]] {
        write("scan.json", manifest.as_bytes());
        loads().unwrap();
    }
    for (name, bytes) in [
        ("a.stl", STL.as_bytes().to_vec()),
        ("b.stl", binary_stl()),
        ("a.obj", OBJ.as_bytes().to_vec()),
    ] {
        write(name, &bytes);
        read_mesh(&folder.path().join(name)).unwrap();
    }
}

proptest! {
    #[test]
    fn damaged_ply_files_are_survived(damages in damages()) {
        with_file("a.ply", &damaged(GRID.as_bytes(), &damages), |path, folder| {
            names_its_file(read_range_grid(path), folder);
            names_its_file(read_mesh(path), folder);
        });
    }

    #[test]
    fn damaged_truth_is_survived(damages in damages()) {
        with_file("truth.npz", &damaged(&truth(), &damages), |path, folder| {
            names_its_file(read_truth(path), folder);
        });
    }

    #[test]
    fn damaged_contours_are_survived(damages in damages()) {
        with_file("c.json", &damaged(CONTOURS.as_bytes(), &damages), |path, folder| {
            names_its_file(read_contours(path), folder);
        });
    }

    #[test]
    fn damaged_configurations_are_survived(damages in damages()) {
        with_file("a.conf", &damaged(CONF.as_bytes(), &damages), |path, folder| {
            names_its_file(Scan::open(path), folder);
        });
    }

    #[test]
    fn damaged_manifests_and_images_are_survived(damages in damages(), image: bool) {
        let (manifest, npy) = (MANIFEST.as_bytes().to_vec(), npy());
        let (manifest, npy) = if image {
            (manifest, damaged(&npy, &damages))
        } else {
            (damaged(&manifest, &damages), npy)
        };
        with_file("scan.json", &manifest, |_, folder| {
            write_file(&folder.join("a.npy"), |out| out.write_all(&npy)).unwrap();
            open_and_load(folder);
        });
    }
}

// Several files each: fewer cases, so that the disk does not decide how long tests take.
proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn damaged_stl_and_obj_files_are_survived(damages in damages(), which in 0..3_usize) {
        let (name, sound) = match which {
            0 => ("a.stl", STL.as_bytes().to_vec()),
            1 => ("a.stl", binary_stl()),
            _ => ("a.obj", OBJ.as_bytes().to_vec()),
        };
        with_file(name, &damaged(&sound, &damages), |path, folder| {
            if let Ok(read) = read_mesh(path) {
                let (vertices, faces) = (&read.mesh.vertices, &read.mesh.faces);
                assert!(vertices.iter().all(|v| v.coords.iter().all(|c| c.is_finite())));
                assert!(faces.as_flattened().iter().all(|i| (*i as usize) < vertices.len()));
            }
            names_its_file(read_mesh(path), folder);
        });
    }

    #[test]
    fn damaged_calibrations_are_survived(damages in damages(), manifest: bool) {
        let hurt = |text: &str, really: bool| {
            if really { damaged(text.as_bytes(), &damages) } else { text.as_bytes().to_vec() }
        };
        with_file("scan.json", &hurt(TABLE, manifest), |_, folder| {
            std::fs::write(folder.join("a.npy"), npy()).unwrap();
            std::fs::write(folder.join("a.csv"), hurt(CALIBRATION, !manifest)).unwrap();
            names_its_file(read_calibration(&folder.join("a.csv")), folder);
            open_and_load(folder);
        });
    }

    #[test]
    fn damaged_distortions_are_survived(damages in damages()) {
        with_file("scan.json", &damaged(DISTORTED.as_bytes(), &damages), |_, folder| {
            std::fs::write(folder.join("a.npy"), npy()).unwrap();
            open_and_load(folder);
        });
    }

    #[test]
    fn damaged_stacks_are_survived(damages in damages(), which in 0..3_usize, array: bool) {
        let name = if array { "stack.npy" } else { "stack" };
        let manifest = STRIPE.replace("STACK", name).into_bytes();
        let manifest = if which == 0 { damaged(&manifest, &damages) } else { manifest };
        with_file("scan.json", &manifest, |_, folder| {
            let hurt = |sound: Vec<u8>, n: usize| {
                if which == n { damaged(&sound, &damages) } else { sound }
            };
            std::fs::write(folder.join("stack.npy"), hurt(stack_file(), 1)).unwrap();
            std::fs::create_dir(folder.join("stack")).unwrap();
            for step in 0..4 {
                let image = hurt(png_file(step), if step == 2 { 1 } else { 2 });
                std::fs::write(folder.join(format!("stack/{step}.png")), image).unwrap();
            }
            open_and_load(folder);
        });
    }
}
