use super::*;
use crate::test_data::write_to_folder;
use crate::{MeshFile, read_mesh};

/// A 2 × 3 grid with one empty cell, as text.
const GRID: &str = "ply\nformat ascii 1.0\nobj_info num_cols 3\nobj_info num_rows 2\n\
    element vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
    element range_grid 6\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 1\n1 0 1\n2 0 1.5\n0.25 1 1\n2.25 1 1\n\
    1 0\n1 1\n1 2\n1 3\n0\n1 4\n";

fn grid(text: &[u8]) -> Result<RangeGrid, ReadError> {
    let (_folder, path) = write_to_folder("scan.ply", text);
    read_range_grid(&path)
}

fn grid_error(text: &str) -> String {
    grid(text.as_bytes()).unwrap_err().to_string()
}

fn mesh(text: &[u8]) -> Result<MeshFile, ReadError> {
    let (_folder, path) = write_to_folder("mesh.ply", text);
    read_mesh(&path)
}

/// Vertices of a grid as comparable text, since NaN is not equal to itself.
fn shown(grid: &RangeGrid) -> String {
    format!("{:?} {:?}", grid.size, grid.points)
}

#[test]
fn an_interlaced_grid_is_read_row_by_row() {
    let grid = grid(GRID.as_bytes()).unwrap();
    assert_eq!((grid.size.rows, grid.size.cols), (2, 3));
    assert_eq!(grid.points[2], Point3::new(2.0, 0.0, 1.5));
    assert_eq!(grid.points[3], Point3::new(0.25, 1.0, 1.0), "odd rows are shifted");
    assert!(grid.points[4].x.is_nan(), "an empty cell is missing");
    assert_eq!(grid.points[5], Point3::new(2.25, 1.0, 1.0));
    assert!(grid.notes.is_empty(), "{:?}", grid.notes);
}

#[test]
fn text_and_both_binary_orders_give_the_same_grid() {
    let wanted = shown(&grid(GRID.as_bytes()).unwrap());
    let header = GRID.split_inclusive("end_header\n").next().unwrap();
    let vertices = [[0., 0., 1.], [1., 0., 1.], [2., 0., 1.5], [0.25, 1., 1.], [2.25, 1., 1.0f32]];
    let cells = [Some(0), Some(1), Some(2), Some(3), None, Some(4_i32)];
    for (name, big) in [("binary_little_endian", false), ("binary_big_endian", true)] {
        let mut bytes = header.replace("ascii", name).into_bytes();
        for number in vertices.as_flattened() {
            bytes.extend(if big { number.to_be_bytes() } else { number.to_le_bytes() });
        }
        for cell in cells {
            bytes.push(u8::from(cell.is_some()));
            bytes.extend(
                cell.iter().flat_map(|i| if big { i.to_be_bytes() } else { i.to_le_bytes() }),
            );
        }
        assert_eq!(shown(&grid(&bytes).unwrap()), wanted, "{name}");
        let cut = grid(&bytes[..bytes.len() - 1]).unwrap_err().to_string();
        assert!(cut.contains("scan.ply, range_grid 5: truncated"), "{cut}");
    }
}

#[test]
fn stray_header_lines_and_foreign_line_ends_are_survived_and_told() {
    let text = GRID
        .replacen("element", "comment made by hand\n\nviewpoint 0 0 1\nelement", 1)
        .replace('\n', "\r\n");
    let grid = grid(format!("{text}7 7\r\n").as_bytes()).unwrap();
    assert_eq!(
        grid.notes,
        [
            "line 7: unknown header line \"viewpoint 0 0 1\" ignored, one of 1",
            "7 bytes after the last element ignored",
        ]
    );
    assert_eq!(grid.points[5], Point3::new(2.25, 1.0, 1.0));
}

#[test]
fn truncated_files_name_the_element_and_line() {
    let cut = GRID.trim_end().trim_end_matches('4');
    assert!(grid_error(cut).ends_with("line 22, range_grid 5: truncated: the file ends here"));
    let cut = GRID.split("end_header").next().unwrap();
    assert!(grid_error(cut).ends_with("line 10: truncated: there is no end_header"));
    let odd = GRID.replace("1 0 1\n", "1 zero 1\n");
    assert!(grid_error(&odd).ends_with("line 13, vertex 1: \"zero\" is not a number here"));
}

#[test]
fn a_grid_that_disagrees_with_its_header_is_refused() {
    let wide = GRID.replace("num_cols 3", "num_cols 4");
    let end = "num_rows 2 × num_cols 4 is 8 cells, but range_grid announces 6";
    assert!(grid_error(&wide).ends_with(end), "{}", grid_error(&wide));
    let sizeless = GRID.replace("num_cols", "columns");
    assert!(grid_error(&sizeless).contains("obj_info num_rows and num_cols are needed"));
    let gridless = GRID.replace("range_grid", "other");
    assert!(grid_error(&gridless).contains("no range grid"));
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_taken() {
    let many = GRID.replace("vertex 5", "vertex 5000000000000000");
    assert!(grid_error(&many).contains("announces 5000000000000000 instances of element vertex"));
    let overflow = GRID.replace("vertex 5", "vertex 9999999999999999999");
    assert!(
        grid_error(&overflow).contains("instances") || grid_error(&overflow).contains("is not")
    );
    let grid = GRID.replace("num_cols 3", "num_cols 4294967296");
    let grid = grid.replace("num_rows 2", "num_rows 4294967296");
    assert!(grid_error(&grid).contains("is empty or absurd"));
    let list = GRID.replace("1 2\n", "99999999 2\n");
    assert!(grid_error(&list).contains("line 19, range_grid 2: a list of 99999999 numbers"));
}

#[test]
fn cells_without_their_vertex_are_named_by_row_and_column() {
    let far = GRID.replace("1 3\n", "1 7\n");
    let end = "scan.ply, row 1, column 0: vertex 7 does not exist; there are 5";
    assert!(grid_error(&far).ends_with(end), "{}", grid_error(&far));
    let negative = GRID.replace("1 3\n", "1 -3\n");
    assert!(grid_error(&negative).contains("row 1, column 0: vertex -3 does not exist"));
    let twice = grid(GRID.replace("1 3\n", "1 2\n").as_bytes()).unwrap();
    assert_eq!(
        twice.notes,
        [
            "1 vertices are in no cell of the grid and are dropped",
            "1 vertices are in several cells of the grid",
        ]
    );
}

#[test]
fn what_is_no_ply_says_so() {
    for text in ["", "solid cube\n", "P"] {
        assert!(grid_error(text).contains("line 1: "), "{}", grid_error(text));
    }
    let unknown = GRID.replace("ascii", "ebcdic");
    assert!(grid_error(&unknown).ends_with("line 2: unknown format \"ebcdic\""));
    let typeless = GRID.replace("float y", "real y");
    assert!(grid_error(&typeless).contains("line 7: \"property real y\" is not a property"));
}

const PYRAMID: &str = "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\n\
    property double confidence\nproperty double y\nproperty double z\nelement face 5\n\
    property uchar red\nproperty list uchar uint vertex_index\nend_header\n\
    0 9 0 0\n1 9 0 0\n1 9 1 0\n0 9 1 0\n0.5 9 0.5 1\n\
    255 4 3 2 1 0\n0 3 0 1 4\n0 3 1 2 4\n0 3 2 3 4\n0 3 3 0 4\n";

#[test]
fn polygons_become_fans_and_other_properties_are_passed_over() {
    let read = mesh(PYRAMID.as_bytes()).unwrap();
    assert_eq!(read.mesh.vertices[4], Point3::new(0.5, 0.5, 1.0));
    assert_eq!(read.mesh.faces[..2], [[3, 2, 1], [3, 1, 0]]);
    assert_eq!(read.mesh.faces.len(), 6);
    assert!(read.notes.is_empty());
}

#[test]
fn bad_meshes_are_named_by_vertex_and_face() {
    let text =
        |from: &str, to: &str| mesh(PYRAMID.replace(from, to).as_bytes()).unwrap_err().to_string();
    let far = text("0 3 1 2 4\n", "0 3 1 2 5\n");
    assert!(far.ends_with("line 19, face 2: vertex 5 does not exist; there are 5"), "{far}");
    let wild = text("0.5 9", "nan 9");
    assert!(wild.ends_with("mesh.ply, vertex 4: a coordinate is not finite"), "{wild}");
    let none = text("element face", "element fact");
    assert!(none.contains("the elements vertex and face are needed"), "{none}");
}

/// Vertices, faces and grids of the real files; their times are printed.
#[test]
fn the_bunny_is_read_whole() {
    let Some(folder) = crate::test_data::shared("stanford_bunny") else { return };
    let scan = crate::Scan::open(&folder.join("bun.conf")).unwrap();
    assert_eq!(scan.views.len(), 10);
    let started = std::time::Instant::now();
    let grids: Vec<_> = scan.views.iter().map(|v| read_range_grid(v.path()).unwrap()).collect();
    println!("ten range grids read in {:?}", started.elapsed());
    let valid = |g: &RangeGrid| g.points.iter().filter(|p| !p.x.is_nan()).count();
    assert_eq!(grids.iter().map(valid).sum::<usize>(), 362_272);
    assert!(grids.iter().all(|g| g.notes.is_empty() && g.size.rows == 400 && g.size.cols == 512));
    let (view, notes) = scan.views[0].load().unwrap();
    assert_eq!((view.image().valid_count(), notes.len()), (40_256, 0));
    let reference = read_mesh(&folder.join("reference/bun_zipper.ply")).unwrap().mesh;
    assert_eq!((reference.vertices.len(), reference.faces.len()), (35_947, 69_451));
}
