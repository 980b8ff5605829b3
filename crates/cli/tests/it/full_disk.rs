//! A disk that fills up while a store grows: a clear error, nothing lost, and going on when there
//! is room.
#![cfg(unix)]

use super::common::Folder;
use std::path::Path;
use std::process::{Command, Output};

fn transect(folder: &Folder, store: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_transect"));
    command.args(["reconstruct", "scan", "--quiet", "--out", "grown", "--store"]).arg(store);
    command.current_dir(folder.path("."));
    command
}

fn assert_told(output: &Output, store: &Path, reason: &str) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    let name = store.file_name().unwrap().to_string_lossy();
    assert!(said.contains(&*name) && said.contains(reason), "{said}");
    assert!(!said.contains("panicked"), "{said}");
}

/// Opens, verifies and counts the views of what a full disk left.
fn views_left(folder: &Folder, store: &Path) -> f64 {
    let store = store.display();
    folder.run(&format!("verify {store}")).succeeded().number("views")
}

/// A quota on the size of files, smaller than the store will be: the same error from the same
/// calls.
#[test]
fn a_quota_on_files_loses_nothing() {
    let folder = Folder::empty();
    let scene = super::common::fixture("objects.scene.toml");
    // So many that the file outgrows the size with which it is made.
    folder.run(&format!("simulate {} --views 24 --out scan", scene.display())).succeeded();
    folder.reconstruct("scan").succeeded();
    let store = folder.path("s.transect");
    let mut left = Vec::new();
    for blocks in [1000, 2100, 2500, 3200] {
        // With SIGXFSZ ignored the write fails; a block has 512 bytes.
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
        let inner = transect(&folder, &store);
        let output = Command::new("sh")
            .args(["-c", &script])
            .arg(inner.get_program())
            .args(inner.get_args())
            .current_dir(folder.path("."))
            .output()
            .unwrap();
        if output.status.success() {
            break;
        }
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains("File too large") && !said.contains("panicked"), "{said}");
        assert!(said.contains("it keeps what it had. Free space"), "{said}");
        if store.exists() {
            left.push(views_left(&folder, &store));
        }
    }
    assert!(!left.is_empty(), "every quota was large enough, or too small for a store");
    assert!(left.is_sorted(), "views were lost: {left:?}");
    assert!(transect(&folder, &store).output().unwrap().status.success());
    assert!(folder.bytes("grown/contours.json") == folder.bytes("out/contours.json"));
}

/// A file system of its own in memory, taken away at the end.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn of_kilobytes(size: u32) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let mount = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}k"), "tmpfs"])
            .arg(folder.path())
            .output();
        mount.is_ok_and(|mount| mount.status.success()).then_some(Self(folder))
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0.path()).status();
    }
}

#[test]
fn a_full_disk_loses_nothing() {
    let folder = Folder::simulated("objects.scene.toml");
    folder.reconstruct("scan").succeeded();
    let Some(disk) = SmallDisk::of_kilobytes(640) else {
        eprintln!("skipped: no file system can be mounted here (root can)");
        return;
    };
    let (store, ballast) = (disk.0.path().join("s.transect"), disk.0.path().join("ballast"));
    let mut left = Vec::new();
    for filled in [560, 480, 400, 320, 240] {
        std::fs::write(&ballast, vec![1; filled << 10]).unwrap();
        let output = transect(&folder, &store).output().unwrap();
        if output.status.success() {
            break;
        }
        assert_told(&output, &store, "No space left");
        if store.exists() {
            left.push(views_left(&folder, &store));
        }
        std::fs::remove_file(&ballast).unwrap();
    }
    assert!(!left.is_empty(), "there was always room, or never enough for a store");
    assert!(left.is_sorted(), "views were lost: {left:?}");
    let _ = std::fs::remove_file(&ballast);
    assert!(transect(&folder, &store).output().unwrap().status.success());
    assert!(folder.bytes("grown/contours.json") == folder.bytes("out/contours.json"));
}
