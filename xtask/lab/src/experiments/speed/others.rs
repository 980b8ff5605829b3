//! Other contouring programs on the same height image, jump test off in both.
//!
//! They run in Python, each in the first interpreter that has it: the one that `--python` names,
//! the one in target/peers, the one that `TRANSECT_PYTHON` names, the path's, the system's. The
//! same script proves equal work. contourpy: as many vertices on every plane, each within 1e-6
//! pixel. GDAL goes half a pixel beyond borders and into gaps, and shifts levels that meet a pixel;
//! away from those, both must have the same vertices.

use super::super::lab::Lab;
use super::super::python;
use super::Column;
use crate::failure::Failure;
use crate::table::say;
use crate::timing::{Variant, time};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use transect_device::View;
use transect_exchange::{write_file, write_npy_image};
use transect_geometry::PlaneFamily;
use transect_partial::one_pass::{
    Contours, Effort, Instructions, Kind, Vertex, Workspace, contours, seen,
};
use transect_partial::{BreakRule, SectionAxes};
use transect_workflow::default_folder as default_out;

const SCRIPT: &str = "lab/src/experiments/speed/contour_peers.py";
/// Timed rounds of the other programs, which take long.
const ROUNDS: usize = 3;

/// A rule by which every pair of valid neighbours belongs to one surface.
fn no_jumps() -> BreakRule {
    BreakRule::new(0.0, 1e30)
}

/// Times and compares the other programs on an image and some planes. Returns the multiples of our
/// time that each takes.
pub fn compare(
    programs: &[Program],
    (view, planes, count): (&View, &PlaneFamily, usize),
    rounds: usize,
) -> Result<Column, Failure> {
    let mut multiples = Vec::new();
    let axes = SectionAxes::new(view, planes)?;
    let (rule, mut work) = (no_jumps(), Workspace::default());
    let folder = default_out("bench");
    std::fs::create_dir_all(&folder).map_err(|e| Failure::with_file(&folder, e))?;
    let size = view.image().size();
    let levels = seen(view, &axes, &rule, Instructions::Best).levels;
    write_file(&folder.join("levels.npy"), |out| write_npy_image(size, &levels, out))?;
    let found = contours(view, &axes, &rule, &Effort::default(), &mut work)?;
    let rows = found
        .polylines()
        .flat_map(|line| line.vertices.iter().map(move |v| (f64::from(line.level), v)));
    let rows: Vec<[f64; 3]> = rows.map(|(level, v)| in_pixels(&found, level, v)).collect();
    let bytes: Vec<u8> = rows.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    write_file(&folder.join("vertices.f64"), |out| out.write_all(&bytes))?;
    let mut ours = [Variant::new("one pass", || {
        let _ = black_box(
            contours(view, &axes, &rule, &Effort::default(), &mut work).map(|c| c.vertex_count()),
        );
    })];
    say(&format!("jump test off, {} vertices", rows.len()));
    for program in programs {
        // Before and after, since the machine's speed changes while the other one runs.
        let before = time(&mut ours, rounds)[0];
        let line = program.run(&folder, count)?;
        let after = time(&mut ours, rounds)[0];
        let ours = 0.5 * (before + after) * 1e9 / size.pixels() as f64;
        let (took, verdict) = line.split_once('\t').unwrap_or_default();
        let took: f64 = took.parse().unwrap_or(f64::NAN);
        let (name, times) = (program.name, took / ours);
        multiples.push((name, times));
        say(&format!(
            "  {name}: {took:.1} ns/pixel, {times:.0} times one pass with {ours:.3}; {verdict}"
        ));
    }
    Ok(multiples)
}

/// Another contouring program and the Python that has it.
pub struct Program {
    name: &'static str,
    python: PathBuf,
}

impl Program {
    /// The programs that are there, and why another one is not.
    pub fn all(lab: &Lab) -> (Vec<Self>, Option<Failure>) {
        let (mut programs, mut missing) = (Vec::new(), None);
        for (name, modules) in [("contourpy", "contourpy, numpy"), ("GDAL", "osgeo.gdal, numpy")] {
            match lab.any_python(modules) {
                Ok(python) => programs.push(Self { name, python }),
                Err(reason) => missing = Some(reason),
            }
        }
        (programs, missing)
    }

    /// Runs the program on the image in a folder; its line of output.
    fn run(&self, folder: &Path, count: usize) -> Result<String, Failure> {
        let (folder, count) = (folder.to_string_lossy(), count.to_string());
        python::run(&self.python, SCRIPT, &[self.name, &folder, &count, &ROUNDS.to_string()])
    }
}

/// Plane, column and row of a vertex, in pixels.
fn in_pixels(found: &Contours<'_>, level: f64, vertex: &Vertex) -> [f64; 3] {
    let (kind, [a, b]) = found.pair(vertex);
    let t = f64::from(vertex.t);
    let along = |a: usize, b: usize| a as f64 + t * (b as f64 - a as f64);
    match kind {
        Kind::Up => [level, a.col as f64, along(a.row, b.row)],
        Kind::Left => [level, along(a.col, b.col), a.row as f64],
        Kind::Rising | Kind::Falling => [level, along(a.col, b.col), along(a.row, b.row)],
    }
}
