//! Exports read back as the same store, and anything else is refused with its line.

use super::*;
use crate::codec::{HASH_OF_NOTHING, fnv1a_from};

fn import(text: &str) -> Result<String, StoreProblem> {
    let imported = Store::import_in(Path::new("memory"), Memory::default(), text.as_bytes());
    let mut store = imported?;
    store.verify().unwrap();
    Ok(export(&store))
}

fn wild_numbers() -> impl Strategy<Value = Vec<Curve>> {
    use transect_geometry::{EndReason, Node, Point2};
    let coordinate =
        || prop_oneof![any::<f64>().prop_filter("finite", |x| x.is_finite()), -2.0..2.0];
    let measure = || any::<f32>().prop_map(f32::abs).prop_filter("finite", |x| x.is_finite());
    let measures = (measure(), measure(), measure(), measure(), measure());
    let node = (
        coordinate(),
        coordinate(),
        measures,
        any::<u32>(),
        [measure(), measure(), measure()],
        any::<bool>(),
    );
    let node = node.prop_map(|(x, y, measures, views, normal, bridged)| {
        let (sigma, footprint, weight, correlation, tan_incidence) = measures;
        let normal: nalgebra::Vector3<f32> = normal.into();
        Node::at(Point2::new(x, y))
            .with_sigma(sigma)
            .with_footprint(footprint)
            .with_weight(weight)
            .with_views(views)
            .with_correlation(correlation)
            .with_tan_incidence(Some(tan_incidence).filter(|tan| *tan != 0.0))
            .with_normal(Some(normal).filter(|normal| *normal != nalgebra::Vector3::zeros()))
            .with_bridged(bridged)
    });
    let reason = prop_oneof![
        Just(None),
        Just(Some(EndReason::MissingPixel)),
        Just(Some(EndReason::RangeJump)),
        Just(Some(EndReason::ImageBorder)),
    ];
    let ends = [reason.clone(), reason];
    let curve = (prop::collection::vec(node, 3..6), any::<bool>(), ends);
    prop::collection::vec(
        curve.prop_map(|(nodes, closed, ends)| Curve::new(nodes, closed).unwrap().with_ends(ends)),
        1..3,
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn exporting_what_was_imported_gives_the_same_bytes(
        id in ".*", curves in wild_numbers(), more in curves(), angle in prop::array::uniform3(-9.0..9.0),
    ) {
        let (_, store) = memory_store();
        add(&store, "first", &more).unwrap();
        let pose = Isometry3::rotation(Vector3::from(angle));
        let view = ViewDescription { world_from_sensor: pose, sigma: None, ..entry(&format!("{id} second")) };
        let mut view = store.begin_view(view).unwrap();
        // `fuse` would overflow the largest coordinates.
        let untouched = |_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]| partials[0].1.clone();
        view.add_planes([(PlaneIndex(i64::MIN), curves)], &untouched).unwrap();
        view.commit().unwrap();
        let text = export(&store);
        prop_assert_eq!(import(&text).unwrap(), text);
    }
}

fn sample() -> String {
    let (_, store) = memory_store();
    let triangle = vec![polyline(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.1)], true)];
    let entry = ViewDescription { world_from_sensor: Isometry3::identity(), ..entry("a") };
    let mut view = store.begin_view(entry).unwrap();
    view.set_copy(&ViewCopy(vec![0, 0x1f, 0xff])).unwrap();
    let same = |_: PlaneIndex, partials: &[(ViewId, Vec<Curve>)]| partials[0].1.clone();
    view.add_planes([(PlaneIndex(3), triangle)], &same).unwrap();
    view.commit().unwrap();
    export(&store)
}

#[test]
fn the_lines_are_the_documented_ones() {
    let curves = "[{\"closed\":true,\"nodes\":[[0.0,0.0,0.0,0.0,1.0,1,0.0,0.0,[0.0,0.0,0.0]],[1.0,0.0,0.0,0.0,1.0,1,0.0,0.0,[0.0,0.0,0.0]],[0.0,0.1,0.0,0.0,1.0,1,0.0,0.0,[0.0,0.0,0.0]]]}]";
    let expected = [
        "{\"store\":{\"format\":\"transect-model\",\"version\":4,\"unit\":\"mm\",\"planes\":{\"guide\":{\"straight\":{\"direction\":[0.0,0.0,1.0]}},\"offset\":0.0,\"interval\":0.5},\"options\":\"{\\\"order\\\":2}\",\"tool\":\"transect 0.1.0\"}}".to_owned(),
        "{\"view\":{\"id\":\"a\",\"name\":\"view a\",\"sensor\":\"pinhole\",\"source\":\"a.npy\",\"source_hash\":\"0123abcd\",\"world_from_sensor\":{\"rotation\":[0.0,0.0,0.0,1.0],\"translation\":[0.0,0.0,0.0]},\"sigma\":0.1}}".to_owned(),
        "{\"copy\":{\"view\":\"a\",\"bytes\":\"001fff\"}}".to_owned(),
        format!("{{\"partial\":{{\"plane\":3,\"view\":\"a\",\"curves\":{curves}}}}}"),
        format!("{{\"fused\":{{\"plane\":3,\"curves\":{curves}}}}}"),
    ];
    let text = sample();
    let lines: Vec<_> = text.lines().collect();
    assert_eq!(lines[..5], expected);
    assert!(lines[5].starts_with("{\"end\":{\"views\":1,\"planes\":1,\"hash\":\""), "{}", lines[5]);
    assert_eq!(lines.len(), 6);
}

#[test]
fn lines_are_read_as_some_editors_write_them() {
    let text = sample();
    let edited = format!("\u{feff}{}", text.replace('\n', "\r\n"));
    assert_eq!(import(&edited).unwrap(), text);
}

fn refusal(text: &str) -> (usize, String) {
    match import(text).unwrap_err() {
        StoreProblem::Import { line, problem } => (line, problem),
        other => panic!("refused without a line: {other}"),
    }
}

#[test]
fn an_import_is_a_whole_file_or_none() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("imported.transect");
    let text = sample();
    let refused = Store::import(&path, &text.as_bytes()[..text.len() / 2]).unwrap_err();
    assert!(refused.to_string().contains("imported.transect"), "{refused}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    Store::import(&path, text.as_bytes()).unwrap().close().unwrap();
    assert_eq!(export(&Store::open(&path).unwrap()), text);
}

#[test]
fn damaged_lines_are_named() {
    let text = sample();
    let lines: Vec<_> = text.lines().collect();
    let without = |skipped: usize| {
        let kept = lines.iter().enumerate().filter(|(i, _)| *i != skipped).map(|(_, line)| *line);
        kept.collect::<Vec<_>>().join("\n") + "\n"
    };
    for (skipped, line, problem) in [
        (0, 1, "an export begins with a line of its store"),
        (1, 2, "the copy of a view comes after the view"),
        (3, 4, "plane 3 has no lines of its views"),
        (4, 5, "the last plane has no line of its fused curves"),
        (5, 6, "the end is missing"),
    ] {
        assert_eq!(refusal(&without(skipped)), (line, problem.to_owned()));
    }
    assert_eq!(refusal(&text.replace("0.1,", "0.2,")).1, "the lines do not match their hash");
    assert_eq!(refusal(&format!("{text}\n")).1, "there is more behind the end");
    let (line, problem) = refusal(&text.replacen("\"version\":4", "\"version\":8", 1));
    assert_eq!(line, 1);
    let versions = "the export has version 8; this program reads versions 3 to 4. Export";
    assert!(problem.starts_with(versions), "{problem}");
    let (line, problem) = refusal(&text.replace("[0.0,0.1,", "[0.0,1e999,"));
    assert_eq!(line, 4);
    assert!(problem.contains("number out of range"), "{problem}");
    assert_eq!(refusal(&text.replace("\"sigma\":0.1", "\"sigma\":-0.1")).0, 2);
    assert_eq!(refusal(&text.replace("\"closed\"", "\"shut\"")).0, 4);
    assert_eq!(refusal("").0, 1);
    for (stated, wrong) in
        [("\"interval\":", "\"interval\":-"), ("\"direction\":[", "\"direction\":[1e999,")]
    {
        assert_eq!(refusal(&text.replacen(stated, wrong, 1)).0, 1, "{wrong}");
    }
    let short = text.replace(",[0.0,0.1,0.0,0.0,1.0,1,0.0,0.0,[0.0,0.0,0.0]]", "");
    assert_eq!(refusal(&short).1, "curve 0: 2 nodes cannot make a closed curve");
    let past_the_end = text.replacen("\"closed\":true", "\"closed\":true,\"bridged\":[1,3]", 1);
    let wanted = "curve 0: \"bridged\" names node 3, but the curve has 3 nodes";
    assert_eq!(refusal(&past_the_end).1, wanted);
}

#[test]
fn a_line_cut_or_changed_anywhere_is_refused() {
    let text = sample();
    for end in 0..text.len() {
        // Without the last newline nothing is missing.
        assert_eq!(import(&text[..end]).is_ok(), end + 1 == text.len(), "{end}");
    }
}

#[test]
fn a_curved_guide_is_exported_as_documented() {
    let points = [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0)];
    let points = points.map(|(x, y)| transect_geometry::Point3::new(x, y, 0.5)).to_vec();
    let guide = transect_geometry::CurvedGuide::polyline(points, Some(2.0)).unwrap();
    let planes = transect_geometry::PlaneFamily::new(guide, 0.0, 0.5).unwrap();
    let line = serde_json::to_string(&planes).unwrap();
    let wanted = concat!(
        r#"{"guide":{"curved":{"kind":{"polyline":2.0},"#,
        r#""points":[[0.0,0.0,0.5],[9.0,0.0,0.5],[9.0,9.0,0.5]]}},"offset":0.0,"interval":0.5}"#
    );
    assert_eq!(line, wanted);
    assert_eq!(serde_json::from_str::<transect_geometry::PlaneFamily>(&line).unwrap(), planes);
}

#[test]
fn every_export_begins_alike() {
    let store = Store::create_in(Path::new("memory"), Memory::default(), &header()).unwrap();
    assert!(export(&store).as_bytes().starts_with(LINES_START));
}

#[test]
fn exports_without_copies_are_still_read() {
    let text = sample();
    let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with("{\"copy\"")).collect();
    let (end, lines) = lines.split_last().unwrap();
    let lines = lines.join("\n").replacen("\"version\":4", "\"version\":3", 1) + "\n";
    let hash = fnv1a_from(HASH_OF_NOTHING, lines.as_bytes());
    let (before, _) = end.split_once("\"hash\":").unwrap();
    let old = format!("{lines}{before}\"hash\":\"{hash:016x}\"}}}}\n");
    let now = import(&old).unwrap();
    assert_eq!(now.lines().count(), 5);
    assert!(now.contains("\"version\":4"), "{now}");
}

#[test]
fn bytes_of_a_copy_are_pairs_of_digits() {
    for wrong in ["001ff", "001fgg", "é"] {
        let problem = refusal(&sample().replace("001fff", wrong));
        assert_eq!(problem, (3, "the bytes of a copy are pairs of hexadecimal digits".to_owned()));
    }
}
