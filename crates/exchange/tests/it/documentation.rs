//! The manifest entries on the documentation's page of sensors are ones that the reader takes.

use std::collections::BTreeSet;
use transect_exchange::read_manifest;

const PAGE: &str = include_str!("../../../../docs/sensors.md");

/// The page's JSON blocks that are views.
fn entries() -> Vec<&'static str> {
    let blocks = PAGE.split("```json\n").skip(1).map(|b| b.split("```").next().unwrap());
    blocks.filter(|b| b.contains("\"sensor\"")).collect()
}

#[test]
fn every_example_is_read_without_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.json");
    let mut sensors = BTreeSet::new();
    for entry in entries() {
        std::fs::write(&path, format!("{{ \"unit\": \"mm\", \"views\": [{entry}] }}")).unwrap();
        let (manifest, notes) = read_manifest(&path).unwrap();
        assert_eq!(notes, [], "{entry}");
        let written = serde_json::to_value(&manifest.views[0]).unwrap();
        sensors.insert(written["sensor"].as_str().unwrap().to_owned());
    }
    let all = ["grid", "light_stripe", "lookup_table", "pinhole", "spherical"];
    assert!(sensors.iter().eq(&all), "{sensors:?}");
}
