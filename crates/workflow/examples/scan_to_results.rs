//! A scan on disk becomes a folder of results; then the same scan grows a model store.
//!
//! `cargo run --release -p transect-workflow --example scan_to_results` writes into a temporary
//! folder and prints the table of the run.
#![allow(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;
use std::path::Path;
use transect::Unwatched;
use transect_exchange::OpenOptions;
use transect_workflow::simulation::{
    PreparedScene, SensorKind, SensorPlan, StripeImages, describe,
};
use transect_workflow::{ModelFile, OpenScan, ResultFolder, Settings, StoreFile, table};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name);
    simulated_scan(&path("scan"))?;

    // 1. Open the scan. Its images are read later, one by one.
    let scan = OpenScan::open(path("scan"), &OpenOptions::default())?;
    assert_eq!(scan.scan().views.len(), 4);

    // 2. Choose settings. Settings that are not given come from the scan.
    let mut settings = Settings::default();
    settings.planes.interval = Some("20cm".parse()?);

    // 3. Make the model, and write every result. The scan has its truth beside it, so the table
    //    ends with a score.
    let results = ResultFolder::new(path("out"));
    let rows = scan.reconstruct(&settings, &Unwatched)?.write(&results)?;
    println!("{}", table::rows(&rows));
    let median = rows.iter().find(|row| row.metric == "median distance from truth");
    let median: f64 = median.ok_or("the run has no score")?.value.parse()?;
    assert!(median < 0.005, "the room is modelled within 5 mm, but the median is {median} m");

    // 4. The same views in a store can be removed again; the model is then that of the other views.
    let store = path("room.transect");
    scan.grow(&store, "", &settings, &Unwatched)?;
    let file = StoreFile::open(&store)?;
    let removed = file.remove_view("range_003.npy")?;
    println!("removed a view with curves on {} planes", removed.planes.len());
    assert_eq!(file.store().views()?.len(), 3);
    file.close()?;

    // 5. Both kinds of file answer the same questions.
    for model in [results.path(), &store] {
        let model = ModelFile::open(model)?;
        let mut length = 0.0;
        model.for_each_section(|_, section| length += section.length())?;
        println!("curves of {length:.1} {}", model.unit());
        assert!(length > 100.0);
    }
    Ok(())
}

/// Writes a scan of the bundled room by four depth cameras, with its truth.
fn simulated_scan(folder: &Path) -> Result<(), Box<dyn Error>> {
    let scene = PreparedScene::new(describe(Path::new("room"))?)?;
    let plan = SensorPlan { density: 0.4, ..SensorPlan::with(SensorKind::Pinhole) };
    scene.simulate(&plan)?.write(&scene, StripeImages::Extracted, folder)?;
    Ok(())
}
