//! Ground that no view measured is marked in the files of results.

use super::common::Folder;

/// Whether both ends of a unit lie in one wall of the room, of 6 by 5 m.
fn lies_in_wall([a, b]: &[[f64; 3]; 2]) -> bool {
    let near = |k: usize, wall: f64| [a, b].iter().all(|end| (end[k] - wall).abs() < 0.005);
    [0.0, 6.0].iter().any(|x| near(0, *x)) || [0.0, 5.0].iter().any(|y| near(1, *y))
}

/// Simulates a bundled scene, models it, and asserts that each unit far longer than the samples
/// apart is marked as bridged. `may_be_long` tells which surfaces views see at a grazing angle.
/// Returns the length of the longest marked unit.
fn long_units_are_marked(scene: &str, may_be_long: fn(&[[f64; 3]; 2]) -> bool) -> f64 {
    let folder = Folder::empty();
    folder.run(&format!("simulate {scene} --out scan")).succeeded();
    // Without its truth a scan is not scored, which takes most of the time.
    std::fs::remove_file(folder.path("scan/truth.npz")).unwrap();
    folder.reconstruct("scan").succeeded();
    let contours = folder.json("out/contours.json");
    let mut units = Vec::new();
    for plane in contours["planes"].as_array().unwrap() {
        for line in plane["polylines"].as_array().unwrap() {
            let points: Vec<[f64; 3]> = serde_json::from_value(line["points"].clone()).unwrap();
            let marked: Option<Vec<usize>> =
                serde_json::from_value(line["bridged"].clone()).unwrap();
            let is_marked = |k: usize| marked.as_ref().is_some_and(|marked| marked.contains(&k));
            let closing = if line["closed"] == true { points.first() } else { None };
            let ends = points.iter().skip(1).chain(closing);
            for (k, (a, b)) in points.iter().zip(ends).enumerate() {
                let length = (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
                units.push((length, is_marked(k), [*a, *b]));
            }
        }
    }
    units.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Samples on curved surfaces are up to 1 / cos 78 = 4.8 times as far apart as head-on.
    let longest = 6.0 * units[units.len() / 2].0;
    let unmarked = units
        .iter()
        .filter(|(length, is_marked, ends)| !is_marked && *length > longest && !may_be_long(ends));
    assert_eq!(unmarked.collect::<Vec<_>>(), Vec::<&_>::new(), "{scene}: more than {longest}");
    let longest = units.iter().rfind(|unit| unit.1).map(|unit| unit.0);
    longest.expect("there is unseen ground")
}

/// Two views see the rim of the mask and the board behind it, and not the ground between.
#[test]
fn the_mask_is_not_joined_to_the_board_behind_it() {
    long_units_are_marked("face_mask --sensor lookup_table --views 2", |_| false);
}

#[test]
fn long_units_of_the_room_are_marked() {
    // A mark has two units. On plane 8 two views end at furniture in front of a wall, 0.26 m apart.
    assert!(long_units_are_marked("room", lies_in_wall) < 0.11);
}
