use super::*;
use crate::test_data::write_to_folder;
use proptest::prelude::*;
use transect_geometry::Point3;

fn read(name: &str, bytes: &[u8]) -> Result<MeshFile, ReadError> {
    let (_folder, path) = write_to_folder(name, bytes);
    read_mesh(&path)
}

fn error(name: &str, bytes: &[u8]) -> String {
    read(name, bytes).unwrap_err().to_string()
}

/// Two triangles that share an edge; the first corner is far off, as survey coordinates are.
const SQUARE: &str = "solid a square\n\
    facet normal 0 0 1\n outer loop\n vertex 5400000.000001 0 0\n vertex 1 0 0\n vertex 1 1 0\n\
    endloop\nendfacet\n\
    facet normal nan nan nan\n outer loop\n vertex 5400000.000001 -0 0\n vertex 1 1 0\n\
    vertex 0 1 2.5e-1\n endloop\nendfacet\nendsolid a square\n";

fn binary(title: &[u8], triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut bytes = title.to_vec();
    bytes.resize(80, b' ');
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        bytes.extend(triangle.as_flattened().iter().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.5], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

#[test]
fn text_triangles_share_vertices_of_equal_coordinates() {
    let lower = read("a.stl", SQUARE.as_bytes()).unwrap();
    assert_eq!(lower.mesh.faces, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(lower.mesh.vertices[0], Point3::new(5_400_000.000_001, 0.0, 0.0));
    assert_eq!(lower.mesh.vertices[3], Point3::new(0.0, 1.0, 0.25));
    assert!(lower.notes.is_empty());
    let upper = SQUARE.to_ascii_uppercase().replace('\n', "\r\n");
    assert_eq!(read("A.STL", upper.as_bytes()).unwrap().mesh, lower.mesh);
    let two = format!("\n{SQUARE}\n{SQUARE}");
    assert_eq!(read("a.stl", two.as_bytes()).unwrap().mesh.faces.len(), 4);
    let latin = SQUARE.as_bytes().iter().map(|&b| if b == b'q' { 0xe9 } else { b });
    assert_eq!(read("a.stl", &latin.collect::<Vec<_>>()).unwrap().mesh, lower.mesh);
}

#[test]
fn binary_files_may_begin_with_solid() {
    let other = [TRIANGLE[1], TRIANGLE[0], [0.0, -1.0, 0.0]];
    let wanted = read("a.stl", &binary(b"made by a program", &[TRIANGLE, other])).unwrap().mesh;
    assert_eq!(wanted.faces, [[0, 1, 2], [1, 0, 3]]);
    assert_eq!(wanted.vertices[0], Point3::new(0.0, 0.0, 0.5));
    let solid = binary(b"solid made by a program", &[TRIANGLE, other]);
    assert_eq!(read("a.stl", &solid).unwrap().mesh, wanted);
    // Also where the length is not what the number of triangles says.
    let longer = [&solid[..], b"tail"].concat();
    let read_longer = read("a.stl", &longer).unwrap();
    assert_eq!(read_longer.mesh, wanted);
    assert_eq!(read_longer.notes, ["4 bytes after the last triangle ignored"]);
    let cut = error("a.stl", &solid[..solid.len() - 1]);
    let end = "a.stl: truncated: the header announces 2 triangles, 1 follow";
    assert!(cut.ends_with(end), "{cut}");
}

#[test]
fn triangles_without_area_are_dropped_and_told() {
    let flat = [TRIANGLE[0], TRIANGLE[1], TRIANGLE[1]];
    let mesh = read("a.stl", &binary(b"", &[flat, TRIANGLE])).unwrap();
    assert_eq!(mesh.mesh.faces.len(), 1);
    assert_eq!(mesh.notes, ["1 triangles with two equal corners dropped"]);
    assert!(error("a.stl", &binary(b"", &[flat])).ends_with("a.stl: there are no triangles"));
}

#[test]
fn damaged_stl_files_are_named_by_line_and_triangle() {
    let text = |from: &str, to: &str| {
        assert!(SQUARE.contains(from));
        error("a.stl", SQUARE.replace(from, to).as_bytes())
    };
    for (error, wanted) in [
        (text("0 1 2.5e-1", "nan 1 0"), "line 13, triangle 1: a coordinate is not finite"),
        (text("0 1 2.5e-1", "0 1 2.5e999"), "line 13, triangle 1: a coordinate is not finite"),
        (text("0 1 2.5e-1", "0 1"), "line 13, triangle 1: a vertex must have three numbers"),
        (text("0 1 2.5e-1", "0 1 x"), "line 13, triangle 1: a vertex must have three numbers"),
        (text("vertex 1 0 0\n", ""), "line 7, triangle 0: a facet of 2 vertices"),
        (text("endloop", "vertex 1 2 3"), "line 7, triangle 0: a facet of more than three"),
        (text("outer loop\n", "banana\n"), "line 3, triangle 0: \"banana\" does not belong"),
        (text("facet normal 0", "face 0"), "line 2, triangle 0: \"face\" does not belong"),
        (text("endsolid a square\n", ""), "line 15: truncated: there is no endsolid"),
        (error("a.stl", &SQUARE.as_bytes()[..140]), "truncated: there is no endsolid"),
        (error("a.stl", b""), "truncated inside the header"),
        (error("a.stl", b"solid\nendsolid\n"), "there are no triangles"),
    ] {
        assert!(error.contains(wanted), "{error}");
    }
    let wild = [TRIANGLE, [TRIANGLE[0], [f32::NAN, 0.0, 0.0], TRIANGLE[2]]];
    let wild = error("a.stl", &binary(b"", &wild));
    assert!(wild.ends_with("a.stl, triangle 1: a coordinate is not finite"), "{wild}");
    let mut many = binary(b"", &[TRIANGLE]);
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let many = error("a.stl", &many);
    assert!(many.ends_with("the header announces 4294967295 triangles, 1 follow"), "{many}");
}

const OBJ: &str = "# a roof\nmtllib roof.mtl\no left\nv 0 0 0\nv 1 0 0 1.0\nv 1 1 0.5 0.2 0.3 0.4\n\
    v 0 1 0.5\nvn 0 0 1\nvt 0 0\nusemtl red\nf 1 2/1 3/1/1 4//1 # polygon\ns off\no right\n\
    v 5400000.000001 1 1\nf -1 \\\n  -2 -3\n";

#[test]
fn polygons_are_fanned_and_corners_may_count_backwards() {
    let read = read("roof.obj", OBJ.as_bytes()).unwrap();
    assert_eq!(read.mesh.faces, [[0, 1, 2], [0, 2, 3], [4, 3, 2]]);
    assert_eq!(read.mesh.vertices.len(), 5);
    assert_eq!(read.mesh.vertices[2], Point3::new(1.0, 1.0, 0.5));
    assert_eq!(read.mesh.vertices[4].x, 5_400_000.000_001);
    assert!(read.notes.is_empty());
    let windows = self::read("roof.obj", OBJ.replace('\n', "\r\n").as_bytes()).unwrap();
    assert_eq!(windows.mesh, read.mesh);
    let early = self::read("a.obj", b"f 1 2 3\nf 1 2\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(early.mesh.faces, [[0, 1, 2]]);
    assert_eq!(early.notes, ["1 faces with fewer than 3 corners dropped"]);
}

#[test]
fn damaged_obj_files_are_named_by_line_and_element() {
    let text = |from: &str, to: &str| {
        assert!(OBJ.contains(from));
        error("roof.obj", OBJ.replace(from, to).as_bytes())
    };
    for (error, wanted) in [
        (text("v 1 0 0 1.0", "v 1 nan 0"), "line 5, vertex 1: a coordinate is not finite"),
        (text("v 1 0 0 1.0", "v 1 1e999 0"), "line 5, vertex 1: a coordinate is not finite"),
        (text("v 1 0 0 1.0", "v 1 0"), "line 5, vertex 1: a vertex must have three numbers"),
        (text("v 1 0 0 1.0", "v 1 0 zero"), "line 5, vertex 1: \"zero\" is not a number"),
        (text("f 1 2/1", "f 0 2/1"), "line 11, face 0: \"0\" names no vertex; there are 4 so far"),
        (text("f 1 2/1", "f 1 /1"), "line 11, face 0: \"/1\" names no vertex"),
        (text("f 1 2/1", "f 1 6/1"), "line 11, face 0: vertex 6 does not exist; there are 5"),
        (text("-2 -3", "-2 -6"), "line 15, face 1: \"-6\" names no vertex; there are 5 so far"),
        (text("f 1 2/1", "f 99999999999 2"), "line 11, face 0: \"99999999999\" names no vertex"),
        (text("f 1 2/1", "f -9223372036854775808 2"), "line 11, face 0: \"-92233720368547"),
        (error("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "a.obj: there are no faces"),
        (error("a.obj", b"\xff\x00\xfe"), "a.obj: there are no faces"),
        (error("a.obj", b"f 1 2 3\n"), "line 1, face 0: vertex 3 does not exist; there are 0"),
    ] {
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn other_extensions_are_told_what_is_read() {
    for name in ["a.glb", "a"] {
        let error = error(name, b"");
        assert!(error.ends_with("meshes are read from .ply, .stl and .obj"), "{error}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// A mesh written as PLY, OBJ and both kinds of STL is the same surface in all of them.
    #[test]
    fn all_formats_hold_the_same_triangles(
        points in prop::collection::vec(prop::array::uniform3(-1e3..1e3_f32), 4..20),
    ) {
        let faces: Vec<[usize; 3]> = (0..points.len() - 2).map(|i| [i, i + 1, i + 2]).collect();
        let corners: Vec<[[f32; 3]; 3]> = faces.iter().map(|f| f.map(|i| points[i])).collect();
        let numbers = |p: &[f32; 3]| format!("{} {} {}\n", p[0], p[1], p[2]);
        let vertices: String = points.iter().map(numbers).collect();
        let lines = |of: fn([usize; 3]) -> String| faces.iter().map(|f| of(*f)).collect::<String>();
        let ply = format!(
            "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\n\
             property float z\nelement face {}\nproperty list uchar int vertex_indices\n\
             end_header\n{vertices}{}",
            points.len(), faces.len(), lines(|[a, b, c]| format!("3 {a} {b} {c}\n")),
        );
        let obj: String = points.iter().map(|p| format!("v {}", numbers(p))).collect();
        let obj = obj + &lines(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
        let facet = |t: &[[f32; 3]; 3]| {
            let loops: String = t.iter().map(|p| format!("vertex {}", numbers(p))).collect();
            format!("facet normal 0 0 0\nouter loop\n{loops}endloop\nendfacet\n")
        };
        let text: String = corners.iter().map(facet).collect();
        let text = format!("solid\n{text}endsolid\n");
        let triangles = |name: &str, bytes: &[u8]| -> Vec<[Point3; 3]> {
            let mesh = read(name, bytes).unwrap().mesh;
            mesh.faces.iter().map(|f| f.map(|i| mesh.vertices[i as usize])).collect()
        };
        let wanted: Vec<[Point3; 3]> =
            corners.iter().map(|t| t.map(|p| Point3::from(p.map(f64::from)))).collect();
        prop_assert_eq!(triangles("a.stl", &binary(b"", &corners)), wanted.clone());
        // Text has the shortest digits that give the f32 back, which is not the f64 of it.
        let close = |a: &[[Point3; 3]]| a.iter().flatten().zip(wanted.iter().flatten())
            .all(|(p, q)| (p - q).amax() <= 1e3 * f64::from(f32::EPSILON));
        for (name, bytes) in [("a.ply", &ply), ("a.obj", &obj), ("a.stl", &text)] {
            let found = triangles(name, bytes.as_bytes());
            prop_assert_eq!(found.len(), wanted.len());
            prop_assert!(close(&found), "{}", name);
        }
    }
}
