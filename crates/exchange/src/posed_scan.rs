//! A scan with other poses, in a file: what registration writes.
//!
//! A scan whose views have a file and a sensor each (`scan.json`, folders of depth images) becomes
//! a manifest that names the same files. Files of several views, such as E57, cannot be named view
//! by view. Their scan becomes a list of poses that names the scan:
//!
//! ```json
//! { "name": "site", "scan": "../site.e57",
//!   "poses": [
//!     { "view": "setup 1", "pose": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1] } ] }
//! ```
//!
//! | key | meaning |
//! |---|---|
//! | `name`, `tool` | the name of the scan, and the program that wrote the list; `tool` is optional |
//! | `scan` | the scan, relative to this file or absolute; any format but this one |
//! | `unit`, `grid`, `rings`, `poses_from` | the options `--unit`, `--grid` ([rows, columns]), `--rings` and `--poses` that the scan is opened with; optional |
//! | `poses` | the views that are used, in the order of the scan: `view` is the name in the scan, `pose` is 16 numbers, row-major, sensor to world; `surface_sigma` as in a `scan.json`, optional |

use crate::input::read_text;
use crate::manifest::{tool_of, write_key, write_list};
use crate::scan::{SURFACE_SIGMA, is_surface_sigma};
use crate::{
    LensEntry, Manifest, OpenOptions, Place, ReadError, Scan, ScanView, SensorEntry, ViewEntry,
    pose, row_major, write_manifest,
};
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use transect_device::{DepthOffsets, ImageSize};
use transect_geometry::{Isometry3, LengthUnit};

/// The command that writes scans with other poses.
const REGISTER: &str = "register";

/// The new pose of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct ViewPose {
    /// The name of the view.
    pub view: String,
    /// World coordinates from sensor coordinates.
    pub world_from_sensor: Isometry3,
    /// The error of the view's depth camera at this pose. Only manifests can state it.
    pub depth_offsets: Option<DepthOffsets>,
    /// By how much its surface may be off at this pose, in the scan's length unit.
    pub surface_sigma: Option<f64>,
}

/// A scan with other poses, ready to be written.
#[derive(Debug, Clone)]
pub enum PosedScan {
    /// A manifest that names the files of the scan's views.
    Manifest(Box<Manifest>),
    /// A list of poses that names the scan.
    Poses(PoseList),
}

/// A list of poses that names its scan.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PoseList {
    name: String,
    #[serde(default)]
    tool: String,
    scan: PathBuf,
    unit: Option<LengthUnit>,
    grid: Option<[usize; 2]>,
    rings: Option<usize>,
    poses_from: Option<PathBuf>,
    poses: Vec<NamedPose>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct NamedPose {
    view: String,
    pose: [f64; 16],
    #[serde(skip_serializing_if = "Option::is_none")]
    surface_sigma: Option<f64>,
}

impl PosedScan {
    /// Writes the file that [`Scan::open`] reads.
    ///
    /// # Errors
    /// An error of `out`.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Manifest(manifest) => write_manifest(manifest, REGISTER, out),
            Self::Poses(list) => list.write(out),
        }
    }
}

/// Whether a path is a list of poses that names its scan.
pub(crate) fn is_one(path: &Path) -> bool {
    #[derive(Deserialize)]
    struct Keys {
        scan: Option<IgnoredAny>,
        poses: Option<IgnoredAny>,
    }
    let is_json = |path: &Path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let file = file_of(path);
    let keys = is_json(&file).then(|| read_text(&file).ok()).flatten();
    let keys = keys.and_then(|text| serde_json::from_str::<Keys>(&text).ok());
    keys.is_some_and(|keys| keys.scan.is_some() && keys.poses.is_some())
}

/// The file of a path that may be its folder.
fn file_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(crate::manifest::MANIFEST_FILE) } else { path.to_owned() }
}

impl PoseList {
    /// Writes the list, one view per line.
    fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let Self { name, tool, scan, unit, grid, rings, poses_from, poses } = self;
        writeln!(out, "{{ \"name\": {},", serde_json::to_string(name)?)?;
        write_key(out, "tool", Some(tool))?;
        write_key(out, "scan", Some(scan))?;
        write_key(out, "unit", unit.as_ref())?;
        write_key(out, "grid", grid.as_ref())?;
        write_key(out, "rings", rings.as_ref())?;
        write_key(out, "poses_from", poses_from.as_ref())?;
        write_list(out, "poses", poses)
    }

    /// The list for a scan that was opened from a path, for a file in a folder that exists.
    pub(crate) fn new(
        (scan, name): (&Path, &str),
        options: &OpenOptions,
        poses: &[ViewPose],
        folder: &Path,
    ) -> Result<Self, ReadError> {
        let seen = |file: &Path| stated(seen_from(folder, file)).map(PathBuf::from);
        let named = |pose: &ViewPose| NamedPose {
            view: pose.view.clone(),
            pose: row_major(&pose.world_from_sensor),
            surface_sigma: pose.surface_sigma,
        };
        Ok(Self {
            name: name.to_owned(),
            tool: tool_of(REGISTER),
            scan: seen(scan)?,
            unit: options.unit,
            grid: options.grid.map(|grid| [grid.rows, grid.cols]),
            rings: options.rings,
            poses_from: options.poses.as_deref().map(seen).transpose()?,
            poses: poses.iter().map(named).collect(),
        })
    }

    /// Reads a list.
    pub(crate) fn read(path: &Path) -> Result<Self, ReadError> {
        let file = file_of(path);
        serde_json::from_str(&read_text(&file)?)
            .map_err(|source| ReadError::Json { path: file, source })
    }

    /// The scan that the list names, and the options to open it with; `path` is the list's own.
    pub(crate) fn scan(
        &self,
        path: &Path,
        asked: Option<LengthUnit>,
    ) -> Result<(PathBuf, OpenOptions), ReadError> {
        let file = file_of(path);
        let folder = file.parent().unwrap_or(Path::new(""));
        let scan = folder.join(&self.scan);
        if is_one(&scan) {
            let problem = "\"scan\" names another list of poses; name the scan of that list";
            return Err(ReadError::unsupported(&file, Place::Whole, problem));
        }
        if let (Some(stated), Some(asked)) = (self.unit, asked)
            && stated != asked
        {
            return Err(ReadError::UnitConflict { path: file, stated, asked });
        }
        let options = OpenOptions {
            unit: self.unit.or(asked),
            // The views of the list are looked for by name; others may lack their files.
            skip_missing: true,
            poses: self.poses_from.as_ref().map(|file| folder.join(file)),
            grid: self.grid.map(|[rows, cols]| ImageSize { rows, cols }),
            rings: self.rings,
            ..OpenOptions::default()
        };
        Ok((scan, options))
    }

    /// The views of the list, at its poses.
    pub(crate) fn applied(&self, path: &Path, mut scan: Scan) -> Result<Scan, ReadError> {
        let file = file_of(path);
        let views = std::mem::take(&mut scan.views);
        let names: Vec<&str> = views.iter().map(ScanView::name).collect();
        let listed: Vec<&str> = self.poses.iter().map(|pose| pose.view.as_str()).collect();
        let meant = meant(&file, &names, &listed)?;
        let mut posed = meant.into_iter().zip(self.poses.iter().enumerate()).peekable();
        for (number, found) in views.into_iter().enumerate() {
            let Some((_, (listed, NamedPose { view, pose, surface_sigma }))) =
                posed.next_if(|(meant, _)| *meant == number)
            else {
                continue;
            };
            let at = Place::View { number: listed, name: view.clone() };
            let pose = pose::from_row_major(pose);
            let pose = pose.map_err(|problem| ReadError::damaged(&file, at.clone(), problem))?;
            if surface_sigma.is_some_and(|sigma| !is_surface_sigma(sigma)) {
                let problem = format!("\"surface_sigma\" must be {SURFACE_SIGMA}");
                return Err(ReadError::damaged(&file, at, problem));
            }
            let found = found.with_pose(pose.world_from_sensor);
            scan.views.push(found.with_surface_sigma(*surface_sigma));
        }
        if scan.views.is_empty() {
            return Err(ReadError::damaged(&file, Place::Whole, "\"poses\" lists no view"));
        }
        scan.name.clone_from(&self.name);
        scan.inputs.insert(0, file);
        Ok(scan)
    }
}

/// The numbers of the views that a list of names means. The list has the order of the scan. Refuses
/// a list that means several selections: the first views that fit it must be the last ones, too.
pub(crate) fn meant(file: &Path, views: &[&str], listed: &[&str]) -> Result<Vec<usize>, ReadError> {
    let (mut forward, mut backward) = (0..views.len(), 0..views.len());
    let is = |view: usize, name: &str| views.get(view).is_some_and(|there| *there == name);
    let wrong = |number: usize, problem: &str| {
        let name = listed.get(number).copied().unwrap_or_default().to_owned();
        ReadError::damaged(file, Place::View { number, name }, problem)
    };
    let mut meant = Vec::with_capacity(listed.len());
    for (number, name) in listed.iter().enumerate() {
        meant.push(forward.find(|k| is(*k, name)).ok_or_else(|| {
            let problem = "the scan has no view of this name behind the views listed before it; \
                           list its views by name, in the order of the scan";
            wrong(number, problem)
        })?);
    }
    for (number, name) in listed.iter().enumerate().rev() {
        if backward.rfind(|k| is(*k, name)).as_ref() != meant.get(number) {
            let problem = "several views of the scan have this name, and the list does not name \
                           all of them; give every view of the scan a name of its own";
            return Err(wrong(number, problem));
        }
    }
    Ok(meant)
}

impl Manifest {
    /// The manifest with other poses, for a file in another folder that exists. Views without a
    /// pose are left out; the others keep their names.
    ///
    /// # Errors
    /// [`ReadError`] naming a file whose name is not Unicode, or a pose without a view of its own.
    pub(crate) fn posed(
        mut self,
        from: &Path,
        poses: &[ViewPose],
        folder: &Path,
    ) -> Result<Self, ReadError> {
        // Views without a file have no pose.
        self.views.retain(|view| from.join(&view.file).exists());
        let name = |view: &ViewEntry| view.name.as_ref().unwrap_or(&view.file).clone();
        let names: Vec<String> = self.views.iter().map(name).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let listed: Vec<&str> = poses.iter().map(|pose| pose.view.as_str()).collect();
        let meant = meant(from, &names, &listed)?;
        let mut posed = meant.into_iter().zip(poses).peekable();
        let mut views = Vec::with_capacity(poses.len());
        for (number, view) in self.views.into_iter().enumerate() {
            if let Some((_, pose)) = posed.next_if(|(meant, _)| *meant == number) {
                views.push(view.posed(from, pose, folder)?);
            }
        }
        self.views = views;
        Ok(self)
    }
}

impl ViewEntry {
    /// The view at another pose, for a file in another folder.
    fn posed(mut self, from: &Path, pose: &ViewPose, folder: &Path) -> Result<Self, ReadError> {
        let seen = |file: &str| stated(seen_from(folder, &from.join(file)));
        let file = seen(&self.file)?;
        match &mut self.sensor {
            SensorEntry::LookupTable(entry) => entry.calibration = seen(&entry.calibration)?,
            SensorEntry::Pinhole(entry) => {
                if let Some(found) = &pose.depth_offsets {
                    let known = entry.depth_offsets.take();
                    let both = known.map_or_else(|| found.clone(), |known| known.then(found));
                    entry.depth_offsets = Some(both);
                }
                if let LensEntry::Rays { rays } = &mut entry.lens {
                    *rays = seen(rays)?;
                }
            }
            _ => (),
        }
        let name = self.name.unwrap_or(self.file);
        // Numbers of a pose that stays would change in their last digits.
        let known = pose::from_row_major(&self.pose).ok();
        let stays = known.is_some_and(|known| known.world_from_sensor == pose.world_from_sensor);
        Ok(Self {
            name: (name != file).then_some(name),
            pose: if stays { self.pose } else { row_major(&pose.world_from_sensor) },
            // It is the error of the given pose.
            pose_sigma: None,
            surface_sigma: pose.surface_sigma,
            file,
            ..self
        })
    }
}

/// A path as JSON can state it.
pub(crate) fn stated(path: PathBuf) -> Result<String, ReadError> {
    path.into_os_string().into_string().map_err(|path| {
        let problem = "this name is not Unicode, so no scan.json can state it; rename the file or \
                       its folder";
        ReadError::unsupported(Path::new(&path), Place::Whole, problem)
    })
}

/// A file as a folder names it: by the way from the folder, or by absolute path where the two have
/// nothing in common but the root.
fn seen_from(folder: &Path, file: &Path) -> PathBuf {
    let resolved = |path: &Path| {
        path.canonicalize().or_else(|_| std::path::absolute(path)).unwrap_or(path.to_owned())
    };
    let (folder, file) = (resolved(folder), resolved(file));
    let both = folder.components().zip(file.components());
    let common = both.take_while(|(a, b)| a == b).count();
    if common < 2 {
        return file;
    }
    let up = folder.components().skip(common).map(|_| Path::new(".."));
    let down = file.components().skip(common).map(|part| Path::new(part.as_os_str()).to_owned());
    up.map(Path::to_owned).chain(down).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_data::with_causes;
    use std::fs;
    use tempfile::TempDir;

    /// Writes a scan with other poses into `new/scan.json`, and opens it.
    fn written(
        folder: &TempDir,
        scan: &str,
        options: &OpenOptions,
        views: &[usize],
    ) -> (Scan, Scan) {
        let path = folder.path().join(scan);
        let own = Scan::open_with(&path, options).unwrap();
        let pose = |k: &usize| {
            let moved = Isometry3::translation(*k as f64 + 0.1, 0.0, 0.0);
            let view = own.views[*k].name().to_owned();
            let surface_sigma = Some(*k as f64 + 0.5);
            ViewPose { view, world_from_sensor: moved, depth_offsets: None, surface_sigma }
        };
        let poses: Vec<_> = views.iter().map(pose).collect();
        let new = folder.path().join("new");
        fs::create_dir_all(&new).unwrap();
        let posed = own.posed(&path, options, &poses, &new).unwrap();
        crate::write_file(&new.join("scan.json"), |out| posed.write(out)).unwrap();
        (own, Scan::open(&new).unwrap())
    }

    #[test]
    fn a_list_of_poses_opens_its_scan_at_them() {
        let folder = tempfile::tempdir().unwrap();
        let conf =
            "bmesh a.ply 0 0 0 0 0 0 1\nbmesh b.ply 0 0 0 0 0 0 1\nbmesh a.ply 9 0 0 0 0 0 1\n";
        fs::write(folder.path().join("part.conf"), conf).unwrap();
        ["a.ply", "b.ply"]
            .iter()
            .for_each(|name| fs::write(folder.path().join(name), "ply").unwrap());
        let options = OpenOptions { unit: Some(LengthUnit::Inch), ..OpenOptions::default() };
        let (own, new) = written(&folder, "part.conf", &options, &[1, 2]);
        let names: Vec<_> = new.views.iter().map(|view| view.name()).collect();
        assert_eq!((names, new.unit), (vec!["b.ply", "a.ply"], own.unit));
        assert_eq!(new.views[1].world_from_sensor().translation.x, 2.1);
        assert_eq!(new.views[1].surface_sigma(), Some(2.5));
        assert_eq!(new.name, "part");
        let asked = OpenOptions { unit: Some(LengthUnit::Metre), ..OpenOptions::default() };
        let error = Scan::open_with(&folder.path().join("new"), &asked).unwrap_err();
        assert!(matches!(error, ReadError::UnitConflict { .. }), "{error}");
        // A list of a list names the scan itself.
        let again = folder.path().join("again");
        fs::create_dir(&again).unwrap();
        let world_from_sensor = Isometry3::identity();
        let poses = [ViewPose {
            view: "a.ply".to_owned(),
            world_from_sensor,
            depth_offsets: None,
            surface_sigma: None,
        }];
        let posed = new.posed(&folder.path().join("new"), &OpenOptions::default(), &poses, &again);
        let PosedScan::Poses(list) = posed.unwrap() else { panic!("a manifest") };
        assert_eq!((list.scan.as_path(), list.unit), (Path::new("../part.conf"), options.unit));
    }

    #[test]
    fn a_manifest_moves_with_its_files_and_names() {
        let folder = tempfile::tempdir().unwrap();
        let pose = row_major(&Isometry3::identity());
        let view = |file: &str, sensor: &str| {
            format!(r#"{{"file": "{file}", "sensor": "pinhole", {sensor}, "pose": {pose:?}}}"#)
        };
        let [a, b] = [view("a.npy", r#""rays": "r.npy""#), view("b.npy", r#""rays": "r.npy""#)];
        let text = format!(r#"{{"unit": "mm", "sigma": 2, "views": [{a}, {b}]}}"#);
        fs::create_dir(folder.path().join("old")).unwrap();
        fs::write(folder.path().join("old/scan.json"), text).unwrap();
        let write = |name: &str| fs::write(folder.path().join("old").join(name), "").unwrap();
        ["a.npy", "b.npy", "r.npy"].into_iter().for_each(write);
        let (own, new) = written(&folder, "old", &OpenOptions::default(), &[1]);
        assert_eq!(new.views[0].name(), "b.npy");
        assert_eq!(new.views[0].world_from_sensor().translation.x, 1.1);
        assert_eq!(new.views[0].surface_sigma(), Some(1.5));
        assert_eq!((new.unit, new.sigma, own.sigma), (own.unit, own.sigma, Some(2.0)));
        let files: Vec<_> = new.inputs[1..].iter().map(|p| p.canonicalize().unwrap()).collect();
        let old = folder.path().canonicalize().unwrap().join("old");
        assert_eq!(files, [old.join("b.npy"), old.join("r.npy")]);
    }

    /// The first view and the last one have one name; only the last one has a pose.
    #[test]
    fn a_pose_of_one_of_two_views_of_a_name_is_refused() {
        let views = ["a", "b", "a"];
        let meant = |listed: &[&str]| meant(Path::new("scan.json"), &views, listed);
        assert_eq!(meant(&["a", "b"]).unwrap(), [0, 1]);
        assert_eq!(meant(&["b", "a"]).unwrap(), [1, 2]);
        assert_eq!(meant(&["a", "a"]).unwrap(), [0, 2]);
        let error = meant(&["a"]).unwrap_err().to_string();
        let wanted = "scan.json, view 0 (a): several views of the scan have this name, and the";
        assert!(error.starts_with(wanted), "{error}");
        let error = meant(&["a", "b", "b"]).unwrap_err().to_string();
        let wanted = "scan.json, view 2 (b): the scan has no view of this name behind";
        assert!(error.starts_with(wanted), "{error}");
        let posed = |list: &str| {
            let folder = tempfile::tempdir().unwrap();
            let view = r#"{"file": "a.npy", "name": "a", "sensor": "grid", "viewpoint": [0,0,0],
                "pose": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}"#;
            let path = folder.path().join("scan.json");
            fs::write(&path, format!(r#"{{"unit": "m", "views": [{view}, {view}]}}"#)).unwrap();
            fs::write(folder.path().join("a.npy"), "").unwrap();
            let scan = Scan::open(&path).unwrap();
            let world_from_sensor = Isometry3::identity();
            let pose = |name: &str| ViewPose {
                view: name.to_owned(),
                world_from_sensor,
                depth_offsets: None,
                surface_sigma: None,
            };
            let poses: Vec<_> = list.split(' ').map(pose).collect();
            let posed = scan.posed(&path, &OpenOptions::default(), &poses, folder.path());
            posed.map(drop).map_err(|error| error.to_string())
        };
        assert_eq!(posed("a a"), Ok(()));
        assert!(posed("a").unwrap_err().contains("several views"));
        assert!(posed("a c").unwrap_err().contains("the scan has no view of this name"));
    }

    #[test]
    fn what_a_list_cannot_mean_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("a.conf"), "bmesh a.ply 0 0 0 0 0 0 1\n").unwrap();
        fs::write(folder.path().join("a.ply"), "ply").unwrap();
        let path = folder.path().join("scan.json");
        let error = |list: &str| {
            fs::write(&path, list).unwrap();
            with_causes(&Scan::open(&path).unwrap_err())
        };
        let pose = row_major(&Isometry3::identity());
        let posed = |view: &str| format!(r#"{{"view": "{view}", "pose": {pose:?}}}"#);
        let list = |scan: &str, poses: &str| {
            format!(r#"{{"name": "n", "scan": "{scan}", "poses": [{poses}]}}"#)
        };
        for (text, wanted) in [
            (list("a.conf", &posed("b.ply")), "view 0 (b.ply): the scan has no view of this"),
            (list("a.conf", ""), "\"poses\" lists no view"),
            (list("scan.json", &posed("a.ply")), "names another list of poses"),
            (list("b.conf", &posed("a.ply")), "b.conf: cannot be read"),
            (list("a.conf", r#"{"view": "a.ply", "pose": [1]}"#), "invalid length 1"),
            (list("a.conf", &posed("a.ply").replace("[1", "[-1")), "the pose is a reflection"),
            (
                list("a.conf", &posed("a.ply").replace('}', r#", "surface_sigma": -1}"#)),
                "view 0 (a.ply): \"surface_sigma\" must be a finite length of 0 or more",
            ),
            (list("a.conf", &posed("a.ply")).replace("name", "nome"), "unknown field `nome`"),
        ] {
            let error = error(&text);
            assert!(error.contains(wanted), "{error}");
        }
    }
}
