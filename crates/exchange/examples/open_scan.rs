//! Opens a scan and reports its views. Without an argument it writes a small scan first.
//!
//! ```text
//! cargo run -p transect-exchange --example open_scan [SCAN]
//! ```

#![allow(clippy::print_stdout, reason = "an example that prints its result")]

use std::error::Error;
use std::path::{Path, PathBuf};
use transect_device::{ImageSize, Isometry3};
use transect_exchange::{
    Manifest, PlanesEntry, Scan, SensorEntry, ViewEntry, row_major, write_file, write_manifest,
    write_npy_image,
};
use transect_geometry::LengthUnit;
use transect_sensors::Intrinsics;

/// A folder with one depth image of a wall 2 m away, and its manifest.
fn write_scan(folder: &Path) -> Result<(), Box<dyn Error>> {
    let size = ImageSize { rows: 4, cols: 6 };
    write_file(&folder.join("wall.npy"), |out| write_npy_image(size, &[2.0; 24], out))?;
    let camera = SensorEntry::pinhole(Intrinsics { fx: 5.0, fy: 5.0, cx: 2.5, cy: 1.5 });
    let pose = row_major(&Isometry3::identity());
    let view = ViewEntry::new("wall.npy".to_owned(), camera, pose);
    let mut manifest = Manifest::new("wall".to_owned(), vec![view]);
    manifest.unit = Some(LengthUnit::Metre);
    manifest.planes = Some(PlanesEntry::new([0.0, 1.0, 0.0], 0.0, 0.1));
    write_file(&folder.join("scan.json"), |out| write_manifest(&manifest, "open_scan", out))?;
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let folder = tempfile::tempdir()?;
    let path = match std::env::args_os().nth(1) {
        Some(path) => PathBuf::from(path),
        None => {
            write_scan(folder.path())?;
            folder.path().to_owned()
        }
    };
    // Opening reads the small files only. Each image is read when its view is loaded.
    let scan = Scan::open(&path)?;
    scan.notes.iter().for_each(|note| println!("note: {note}"));
    println!("{}: {} views, lengths in {}", scan.name, scan.views.len(), scan.unit);
    for source in &scan.views {
        let (view, notes) = source.load()?;
        notes.iter().for_each(|note| println!("note: {note}"));
        let (valid, size) = (view.image().valid_count(), view.image().size());
        println!("{}: {size}, {valid} valid pixels", view.name());
        assert!(valid > 0, "a view without valid pixels is an error");
    }
    Ok(())
}
