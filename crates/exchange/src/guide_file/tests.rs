use super::*;
use crate::test_data::write_to_folder;
use proptest::prelude::*;

fn read(name: &str, text: &str) -> Result<Vec<Point3>, ReadError> {
    let (_folder, path) = write_to_folder(name, text.as_bytes());
    read_guide(&path, GuideKind::Polyline(None), LengthUnit::Metre)
        .map(|(guide, _)| guide.points().to_vec())
}

fn problem(name: &str, text: &str) -> String {
    let error = read(name, text).unwrap_err();
    let cause = std::error::Error::source(&error).map(ToString::to_string).unwrap_or_default();
    format!("{error}: {cause}")
}

fn wanted() -> Vec<Point3> {
    [(1.0, 2.0, 3.0), (4.0, 5.0, 3.0), (4.5, 9.0, 3.0)]
        .map(|(x, y, z)| Point3::new(x, y, z))
        .to_vec()
}

/// A drawing whose entities are these pairs of code and value.
fn drawing(entities: &str) -> String {
    let pairs = entities.split_whitespace().collect::<Vec<_>>().join("\n");
    format!("999\nby hand\n0\nSECTION\n2\nENTITIES\n{pairs}\n0\nENDSEC\n0\nEOF\n")
}

#[test]
fn all_forms_give_the_same_points() {
    let table = "x,y,z\n1,2,3\n# a comment\n4; 5; 3\n4.5 9 3  # the last one\n";
    let line = r#"{"type":"LineString","coordinates":[[1,2,3],[4,5,3],[4.5,9,3]]}"#;
    let feature = format!(r#"{{"type":"Feature","properties":{{}},"geometry":{line}}}"#);
    let collection = format!(r#"{{"type":"FeatureCollection","features":[{feature}]}}"#);
    let light = "0 LWPOLYLINE 8 axis 90 3 70 0 38 3.0 10 1 20 2 10 4 20 5 10 4.5 20 9";
    let heavy = "0 POLYLINE 66 1 70 8 0 VERTEX 10 1 20 2 30 3 0 VERTEX 10 4 20 5 30 3 \
                 0 VERTEX 10 4.5 20 9 30 3 0 SEQEND";
    let lines = "0 LINE 10 1 20 2 30 3 11 4 21 5 31 3 0 LINE 10 4 20 5 30 3 11 4.5 21 9 31 3";
    assert_eq!(read("a.csv", table).unwrap(), wanted());
    let units = table.replace("x,y,z", "\"X\" [m]; Y_world (m); z");
    assert_eq!(read("a.csv", &units).unwrap(), wanted());
    for text in [line, &feature, &collection] {
        assert_eq!(read("a.geojson", text).unwrap(), wanted());
    }
    let flat = "0 POLYLINE 66 1 30 3.0 70 0 0 VERTEX 10 1 20 2 30 0 0 VERTEX 10 4 20 5 30 0 \
                0 VERTEX 10 4.5 20 9 30 0 0 SEQEND";
    for entities in [light, heavy, lines, flat] {
        assert_eq!(read("a.dxf", &drawing(entities)).unwrap(), wanted(), "{entities}");
    }
    for header in ["9\n$INSUNITS\n70\n6\n", "9\n$INSUNITS\n70\n0\n"] {
        assert_eq!(read("a.dxf", &(header.to_owned() + &drawing(light))).unwrap(), wanted());
    }
    let latin = [b"999\nStra\xdfe\n", drawing(light).as_bytes()].concat();
    let (_folder, path) = write_to_folder("a.dxf", &latin);
    read_guide(&path, GuideKind::Spline, LengthUnit::Metre).unwrap();
}

/// A `LINE` between two points of a polyline.
fn line([from, to]: [usize; 2]) -> String {
    let point = |k: usize| [0.0, 1.0, 3.0, 6.5, 10.0].get(k).map(|x| (*x, 2.0 + x * x));
    let ((a, b), (c, d)) = (point(from).unwrap(), point(to).unwrap());
    format!(" 0 LINE 10 {a} 20 {b} 30 3 11 {c} 21 {d} 31 3")
}

#[test]
fn lines_join_in_any_order_and_run_as_most_were_drawn() {
    let read = |lines: &[[usize; 2]]| {
        let entities: String = lines.iter().copied().map(line).collect();
        let (_folder, path) = write_to_folder("a.dxf", drawing(&entities).as_bytes());
        let (guide, notes) =
            read_guide(&path, GuideKind::Polyline(None), LengthUnit::Metre).unwrap();
        let x: Vec<f64> = guide.points().iter().map(|p| p.x).collect();
        (x, notes.into_iter().map(|note| note.to_string()).collect::<Vec<_>>())
    };
    let forward = vec![0.0, 1.0, 3.0, 6.5, 10.0];
    let backward: Vec<f64> = forward.iter().rev().copied().collect();
    let drawn = [[0, 1], [1, 2], [2, 3], [3, 4]];
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [2, 0, 3, 1], [1, 2, 0, 3]] {
        let lines = order.map(|k| drawn[k]);
        assert_eq!(read(&lines), (forward.clone(), vec![]), "{order:?}");
        let turned = lines.map(|[from, to]| [to, from]);
        assert_eq!(read(&turned), (backward.clone(), vec![]), "{order:?}");
    }
    // The last line is longer than the others together.
    let (x, notes) = read(&[[1, 0], [4, 3], [1, 2], [2, 3]]);
    assert_eq!(x, backward);
    let wanted = "a.dxf: 2 of 4 LINEs are drawn against the direction of most of the length; the \
                  guide runs from (10, 102, 3) to (0, 2, 3); draw one polyline";
    assert!(notes.len() == 1 && notes[0].contains(wanted), "{notes:?}");
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    for (name, text, wanted) in [
        ("a.csv", "1,2,3\n4,5\n", "line 2: 2 numbers"),
        ("a.csv", "1,2,3\n4,,5,6\n", "line 2: \"4,,5,6\" is not three numbers"),
        ("a.csv", "1,5;2;3\n", "write decimal points, not commas"),
        ("a.csv", "1,5,2,5,3,5\n", "6 numbers, not the three x, y and z; write decimal points"),
        ("a.csv", "1,2,3\n4,five,6\n", "line 2: \"4,five,6\" is not three numbers"),
        ("a.csv", "0,0,2O\n1,2,3\n4,5,6\n", "line 1: \"0,0,2O\" is not three numbers"),
        ("a.csv", "y,x,z\n1,2,3\n4,5,6\n", "line 1: \"y,x,z\" names no x, y and z in this order"),
        ("a.csv", "lat;lon;h\n1,2,3\n4,5,6\n", "line 1: \"lat;lon;h\" names no x, y and z"),
        ("a.csv", "1,2,3\n\n1,2,3\n", "line 3: the point repeats"),
        ("a.csv", "1,2,3\nnan,2,3\n", "line 2: a coordinate is not finite"),
        ("a.csv", "1,2,3\n", "a guide has 1 points"),
        ("a.csv", "0,0,0\n1,0,0\n0.5,0,0\n", "turns back on itself at point 1"),
        ("a.tex", "1,2,3\n", "ends in .csv"),
        ("a.json", "{\"type\":\n\"Point\"", "line 2: not valid JSON"),
        ("a.json", r#"{"type":"Point","coordinates":[1,2,3]}"#, "0 objects of type LineString"),
        (
            "a.json",
            r#"{"type":"LineString","coordinates":[[1,2,3],[1,2]]}"#,
            "position 1: [1,2] is not",
        ),
    ] {
        let found = problem(name, text);
        assert!(found.contains(wanted), "{found}\n{wanted}");
    }
    for (entities, wanted) in [
        ("0 LWPOLYLINE 70 1 10 1 20 2 10 3 20 4", "line 8: the LWPOLYLINE is closed"),
        ("0 LWPOLYLINE 10 1 20 2 42 0.5 10 3 20 4", "has arcs"),
        ("0 LINE 10 1 20 2 11 3 21 4 0 LINE 10 9 20 2 11 8 21 4", "2 separate"),
        (
            "0 LINE 10 1 20 2 11 3 21 4 0 LINE 10 3 20 4 11 8 21 4 0 LINE 10 3 20 4 11 9 21 0",
            "2 separate",
        ),
        ("0 LINE 10 1 20 two 11 3 21 4", "line 12: \"two\" is no number"),
        ("0 LINE 10 1 11 3 21 4", "LINE has no group 20"),
        ("0 POLYLINE 0 VERTEX 10 1 20 2", "no SEQEND"),
        (
            "0 POLYLINE 0 VERTEX 10 1 20 2 0 POLYLINE 0 VERTEX 10 3 20 4 0 SEQEND",
            "line 16: a POLYLINE begins before the one before it has ended",
        ),
        ("0 LWPOLYLINE 10 1 20 2 10 3", "not finite"),
        ("0 LWPOLYLINE 10 1 20 2 10 3 20 4 0 ARC 10 1 20 2 40 3", "line 18: ARC is no guide"),
        ("0 INSERT 2 axis", "0 separate polylines or lines; a guide is one. 1 blocks (INSERT)"),
        ("0 ENDSEC 9 $INSUNITS 70 4", "$INSUNITS, is 4 (mm), but the scan's is m"),
        (
            "0 POLYLINE 66 1 70 12 0 VERTEX 70 48 10 1 20 2 30 3 0 VERTEX 70 40 10 4 20 5 30 3 \
             0 VERTEX 70 40 10 4.5 20 9 30 3 0 SEQEND",
            "line 8: the POLYLINE is fitted by a spline",
        ),
        ("0 POLYLINE 70 16 0 VERTEX 10 1 20 2 0 SEQEND", "the POLYLINE is a mesh; draw"),
        ("0 POLYLINE 70 64 0 VERTEX 10 1 20 2 0 SEQEND", "the POLYLINE is a mesh; draw"),
        ("0 LWPOLYLINE 230 -1 10 1 20 2 10 3 20 4", "turned coordinate system"),
    ] {
        let found = problem("a.dxf", &drawing(entities));
        assert!(found.contains(wanted), "{found}\n{wanted}");
    }
}

proptest! {
    #[test]
    fn random_files_are_a_finite_guide_or_an_error(
        text in "[-0-9a-zA-Z,;:.{}\\[\\]\" \n]{0,200}", name in 0..3_usize,
        cut in 0..400_usize, change in any::<u8>(),
    ) {
        let name = ["a.csv", "a.json", "a.dxf"][name];
        let is_guide = |points: &[Point3]| {
            points.len() > 1 && points.iter().all(|p| p.coords.iter().all(|c| c.is_finite()))
        };
        prop_assert!(read(name, &text).map_or(true, |points| is_guide(&points)));
        let light = drawing("0 LWPOLYLINE 90 3 38 3.0 10 1 20 2 10 4 20 5 10 4.5 20 9");
        let mut bytes = light.into_bytes();
        bytes.truncate(cut);
        if let Some(byte) = bytes.last_mut() {
            *byte = change;
        }
        let (_folder, path) = write_to_folder("a.dxf", &bytes);
        let guide = read_guide(&path, GuideKind::Spline, LengthUnit::Metre);
        prop_assert!(guide.map_or(true, |(guide, _)| is_guide(guide.points())));
    }
}
