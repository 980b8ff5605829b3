//! Opening a scan: the one list of scan formats.
//!
//! To add a format, write a module with a function like `manifest::open` and add a line to
//! [`FORMATS`]. See "Add a scan format" in `docs/add-a-sensor.md`.

use crate::{
    FileNames, Manifest, OpenOptions, Place, PoseList, PosedScan, ReadError, Scan, ScanView,
    ViewPose, cloud, depth_sequence, depth_sequence_manifest, e57, manifest, posed_scan, ptx,
    read_manifest, stanford,
};
use std::path::Path;
use transect_device::{ImageOrder, Note};

/// Reads a scan as a manifest whose files are relative to the scan's folder.
type ReadManifest = fn(&Path, &OpenOptions) -> Result<Manifest, ReadError>;

/// A kind of scan on disk.
struct Format {
    /// The words for it in the message that lists the accepted formats.
    name: &'static str,
    /// Whether a path is of this kind. The path exists.
    recognise: fn(&Path) -> bool,
    /// The fields of [`OpenOptions`] that only some formats have a use for, and this one has.
    uses: &'static [&'static str],
    /// Reads everything but the images.
    open: fn(&Path, &OpenOptions) -> Result<Scan, ReadError>,
    /// Reads the scan as a manifest beside its images; `None` where views have no file of their
    /// own.
    manifest: Option<ReadManifest>,
}

/// The formats in the order in which they are tried.
const FORMATS: [Format; 9] = [
    Format {
        name: "a folder with scan.json",
        recognise: |path| manifest::is_in(path) && !posed_scan::is_one(path),
        uses: &[],
        open: |folder, options| manifest::open(&folder.join(manifest::MANIFEST_FILE), options),
        manifest: Some(|folder, _| Ok(read_manifest(&folder.join(manifest::MANIFEST_FILE))?.0)),
    },
    Format {
        name: "a scan manifest (*.json)",
        recognise: |path| is_file_with(path, "json") && !posed_scan::is_one(path),
        uses: &[],
        open: manifest::open,
        manifest: Some(|path, _| Ok(read_manifest(path)?.0)),
    },
    Format {
        name: "a list of poses that names its scan (*.json)",
        recognise: posed_scan::is_one,
        uses: &[],
        open: |path, options| {
            let list = PoseList::read(path)?;
            let (scan, options) = list.scan(path, options.unit)?;
            list.applied(path, Scan::open_with(&scan, &options)?)
        },
        manifest: None,
    },
    Format {
        name: "a folder of depth images with poses and a camera (TUM, ICL-NUIM, ScanNet, 7-Scenes, \
               Open3D)",
        recognise: depth_sequence::is_one,
        uses: &["poses", "camera", "depth_scale", "pixels_hold", "max_time_difference"],
        open: depth_sequence::open,
        manifest: Some(|folder, options| {
            Ok(depth_sequence_manifest(folder, FileNames::Relative, options)?.0)
        }),
    },
    Format {
        name: "a Stanford configuration (*.conf), or a folder with one",
        recognise: |path| stanford::configuration(path).is_some(),
        uses: &[],
        open: stanford::open,
        manifest: None,
    },
    Format {
        name: "an E57 file with structured scans (*.e57)",
        recognise: e57::is_one,
        uses: &[],
        open: e57::open,
        manifest: None,
    },
    Format {
        name: "a PTX file (*.ptx)",
        recognise: |path| is_file_with(path, "ptx"),
        uses: &[],
        open: ptx::open,
        manifest: None,
    },
    Format {
        name: "a cloud of a structured scan or a rotating lidar (*.pcd, *.ply, *.bin)",
        recognise: cloud::is_file,
        uses: &["poses", "grid", "rings"],
        open: cloud::open_file,
        manifest: None,
    },
    Format {
        name: "a folder of such clouds with their poses",
        recognise: cloud::is_folder,
        uses: &["poses", "grid", "rings"],
        open: cloud::open_folder,
        manifest: None,
    },
];

/// Files that are recognised and cannot be read: extensions, and the reason with the way out.
const REFUSED: [(&[&str], &str); 2] = [
    (
        &["las", "laz"],
        "LAS and LAZ keep no rows and columns, so no point has neighbours to trace. Export the scan \
         positions structured from the scanner's program, as E57 or PTX",
    ),
    (
        &["xyz", "pts", "asc"],
        "lists of points state neither rows and columns nor the place of the scanner, so no point \
         has neighbours to trace. Export the scan structured, as E57, PTX or organised PCD",
    ),
];

fn is_file_with(path: &Path, extension: &str) -> bool {
    !path.is_dir() && path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}

/// What a path that is no scan is, with the way out, if it is known.
fn what_it_is(path: &Path) -> Option<String> {
    if is_file_with(path, "transect") || path.join("model.transect").is_file() {
        let model = "a model and no scan; pass the scan that it was made of, which the report.json \
                     of its run names";
        return Some(model.to_owned());
    }
    let is_refused = |(extensions, _): &&(&[&str], _)| {
        extensions.iter().any(|extension| is_file_with(path, extension))
    };
    let refused = REFUSED.iter().find(is_refused).map(|(_, reason)| (*reason).to_owned());
    refused.or_else(|| stanford::several(path)).or_else(|| {
        let scan = scan_within(path)?;
        Some(format!("a folder that holds scans; pass one, such as {scan}"))
    })
}

/// The first file of a folder that is a scan by itself; `None` for a file, too.
fn scan_within(folder: &Path) -> Option<String> {
    let entries = std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path());
    let mut files: Vec<_> = entries.filter(|path| path.is_file()).collect();
    files.sort();
    let scan = files.iter().find(|path| FORMATS.iter().any(|format| (format.recognise)(path)))?;
    Some(scan.display().to_string())
}

/// Checks that a folder can be listed. One that cannot is recognised as no format.
fn check_listed(path: &Path) -> Result<(), ReadError> {
    if path.is_dir() {
        std::fs::read_dir(path).map_err(|e| ReadError::io(path, e))?;
    }
    Ok(())
}

/// The problem of a setting that the format of a scan has no use for. In a folder, a manifest comes
/// before all other files, such as the images that the setting is meant for.
fn without_use(setting: &str, path: &Path) -> String {
    let problem =
        format!("the setting `{setting}` has no meaning for a scan of this format; leave it out");
    if !manifest::is_in(path) {
        return problem;
    }
    let manifest = path.join(manifest::MANIFEST_FILE);
    format!(
        "{problem}: {} is read, which states the cameras, scales and poses; or rename that file, \
         so that the folder is read without it",
        manifest.display()
    )
}

impl Scan {
    /// Opens a scan whose files state their unit, or have one by convention.
    ///
    /// # Errors
    /// See [`Scan::open_with`].
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        Self::open_with(path, &OpenOptions::default())
    }

    /// Opens a scan of any format in the table of the crate's page.
    ///
    /// # Errors
    /// [`ReadError`] if the path is none of these, or a file is missing or damaged. Also if no unit
    /// is known, if the files state another unit than the options, or if the format has no use for
    /// an option.
    pub fn open_with(path: &Path, options: &OpenOptions) -> Result<Self, ReadError> {
        std::fs::metadata(path).map_err(|e| ReadError::io(path, e))?;
        let Some(format) = FORMATS.iter().find(|format| (format.recognise)(path)) else {
            check_listed(path)?;
            return Err(match what_it_is(path) {
                Some(problem) => ReadError::unsupported(path, Place::Whole, problem),
                None => {
                    let accepted = FORMATS.map(|format| format.name).join("; ");
                    ReadError::NotAScan { path: path.to_owned(), accepted }
                }
            });
        };
        if let Some(setting) = options.unused(format.uses) {
            return Err(ReadError::unsupported(path, Place::Whole, without_use(setting, path)));
        }
        let mut scan = (format.open)(path, options)?;
        scan.settle_missing(path, options.skip_missing)?;
        match options.image_order {
            Some(order) => scan.in_order(order),
            None => Ok(scan),
        }
    }

    /// The scan, its images read in another order of pixels.
    fn in_order(mut self, order: ImageOrder) -> Result<Self, ReadError> {
        for view in &mut self.views {
            *view = view.in_order(order).ok_or_else(|| manifest::no_order(view.path(), order))?;
        }
        let text = format!("images are read as asked for: {}", order.meaning());
        self.notes.push(Note::new(text));
        Ok(self)
    }

    /// A scan with other poses, for a file in a folder that exists. `poses` are those of the views
    /// to use, by name, in the order of the scan; `options` are those the scan was opened with.
    ///
    /// # Errors
    /// [`ReadError`] if the scan's own files cannot be read any more, or have names that are not
    /// Unicode. A pose whose name does not tell its view is an error, too.
    pub fn posed(
        &self,
        path: &Path,
        options: &OpenOptions,
        poses: &[ViewPose],
        folder: &Path,
    ) -> Result<PosedScan, ReadError> {
        if posed_scan::is_one(path) {
            let (scan, options) = PoseList::read(path)?.scan(path, options.unit)?;
            return self.posed(&scan, &options, poses, folder);
        }
        let format = FORMATS.iter().find(|format| (format.recognise)(path));
        let Some(manifest) = format.and_then(|format| format.manifest) else {
            let names: Vec<&str> = self.views.iter().map(ScanView::name).collect();
            let listed: Vec<&str> = poses.iter().map(|pose| pose.view.as_str()).collect();
            posed_scan::meant(path, &names, &listed)?;
            let list = PoseList::new((path, &self.name), options, poses, folder)?;
            return Ok(PosedScan::Poses(list));
        };
        let beside = if path.is_dir() { path } else { path.parent().unwrap_or(Path::new("")) };
        let mut manifest = manifest(path, options)?.posed(beside, poses, folder)?;
        manifest.unit = Some(self.unit);
        for view in &mut manifest.views {
            view.image_order = view.image_order.or(options.image_order);
        }
        Ok(PosedScan::Manifest(Box::new(manifest)))
    }

    /// Leaves out the views without a file, or refuses them.
    fn settle_missing(&mut self, path: &Path, skip: bool) -> Result<(), ReadError> {
        let is_missing = |view: &&ScanView| !view.path().exists();
        let missing: Vec<_> = self.views.iter().filter(is_missing).map(ScanView::path).collect();
        if missing.is_empty() {
            return Ok(());
        }
        if let (true, [first, ..]) = (missing.len() == self.views.len(), &missing[..]) {
            let (path, first) = (path.to_owned(), first.to_path_buf());
            return Err(ReadError::NoFiles { path, views: self.views.len(), first });
        }
        let names: Vec<_> = missing.iter().map(|file| file.display().to_string()).collect();
        let (count, views, names) = (missing.len(), self.views.len(), names.join(", "));
        if !skip {
            return Err(ReadError::MissingFiles { path: path.to_owned(), count, views, names });
        }
        let text = format!("{count} of {views} views left out, without a file: {names}");
        self.notes.push(Note::about(path.display(), text));
        self.inputs.retain(|file| file.exists());
        self.views.retain(|view| view.path().exists());
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::skipped;

    #[test]
    fn what_is_no_scan_is_told_what_would_be() {
        let folder = tempfile::tempdir().unwrap();
        let error = Scan::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("accepted are: a folder with scan.json; "), "{error}");
        std::fs::write(folder.path().join("pump.e57"), "").unwrap();
        let error = Scan::open(folder.path()).unwrap_err().to_string();
        assert!(error.contains("pass one, such as ") && error.contains("pump.e57"), "{error}");
        for name in ["a.conf", "b.conf"] {
            std::fs::write(folder.path().join(name), "bmesh a.ply 0 0 0 0 0 0 1\n").unwrap();
        }
        let told = |error: &ReadError| {
            let text = error.to_string();
            assert!(text.contains("2 Stanford configurations"), "{text}");
            assert!(text.contains("a.conf, ") && text.ends_with("b.conf"), "{text}");
        };
        told(&Scan::open(folder.path()).unwrap_err());
        std::fs::write(folder.path().join("a.ply"), "ply").unwrap();
        told(&Scan::open(folder.path()).unwrap_err());
        for name in ["a.conf", "b.conf", "a.ply"] {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
        let missing = Scan::open(&folder.path().join("nowhere")).unwrap_err();
        assert!(matches!(missing, ReadError::Io { .. }), "{missing}");
        let text = folder.path().join("notes.md");
        std::fs::write(&text, "no scan").unwrap();
        assert!(matches!(Scan::open(&text), Err(ReadError::NotAScan { .. })));
        for (name, reason) in [("a.laz", "LAS and LAZ keep no rows"), ("a.XYZ", "lists of points")]
        {
            let path = folder.path().join(name);
            std::fs::write(&path, "LASF").unwrap();
            let error = Scan::open(&path).unwrap_err().to_string();
            assert!(error.contains(&format!("{name}: {reason}")) && error.contains("as E57"));
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_that_cannot_be_listed_is_an_error_of_its_own() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let closed = folder.path().join("closed");
        std::fs::create_dir(&closed).unwrap();
        let allow = |mode| std::fs::set_permissions(&closed, PermissionsExt::from_mode(mode));
        allow(0o000).unwrap();
        if std::fs::read_dir(&closed).is_ok() {
            return skipped("this user may list every folder");
        }
        let error = Scan::open(&closed).unwrap_err();
        allow(0o700).unwrap();
        assert!(matches!(error, ReadError::Io { .. }), "{error}");
        let error = Scan::open(&closed).unwrap_err();
        assert!(matches!(error, ReadError::NotAScan { .. }), "{error}");
    }

    #[test]
    fn an_option_without_use_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bun.conf");
        std::fs::write(&path, "bmesh b.ply 0 0 0 0 0 0 1\n").unwrap();
        let options = OpenOptions { rings: Some(32), ..OpenOptions::default() };
        let error = Scan::open_with(&path, &options).unwrap_err().to_string();
        let wanted =
            "bun.conf: the setting `rings` has no meaning for a scan of this format; leave it out";
        assert!(error.ends_with(wanted), "{error}");
    }

    #[test]
    fn views_without_a_file_are_an_error_that_says_how_to_go_on() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bun.conf");
        std::fs::write(&path, "mesh a.ply 0 0 0 0 0 0 1\nbmesh b.ply 0 0 0 0 0 0 1\n").unwrap();
        std::fs::write(folder.path().join("b.ply"), "ply").unwrap();
        let error = Scan::open(&path).unwrap_err().to_string();
        assert!(error.contains("bun.conf: 1 of 2 views have no file: "), "{error}");
        assert!(error.ends_with(
            "a.ply; correct the names, or pass the setting `skip_missing` to leave these views out"
        ));
        let skip = OpenOptions { skip_missing: true, ..OpenOptions::default() };
        let scan = Scan::open_with(&path, &skip).unwrap();
        let names: Vec<_> = scan.views.iter().map(ScanView::name).collect();
        assert_eq!((names, scan.inputs.len()), (vec!["b.ply"], 2), "{:?}", scan.inputs);
        assert!(
            scan.notes[1].text.contains("1 of 2 views left out, without a file: "),
            "{:?}",
            scan.notes
        );
        std::fs::remove_file(folder.path().join("b.ply")).unwrap();
        for options in [skip, OpenOptions::default()] {
            let error = Scan::open_with(&path, &options).unwrap_err().to_string();
            assert!(error.contains("bun.conf: none of its 2 views has a file"), "{error}");
            assert!(error.contains("a.ply") && !error.contains("skip_missing"), "{error}");
        }
    }
}
