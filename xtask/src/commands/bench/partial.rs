//! `cargo xtask bench partial`: the partial modeler, per pixel and per vertex.

use super::baselines::Baselines;
use super::peers;
use super::scene::{self, Gaps};
use super::timing::{Variant, load, time};
use crate::failure::Failure;
use crate::table::say;
use std::cell::RefCell;
use std::hint::black_box;
use transect_device::View;
use transect_geometry::PlaneFamily;
use transect_partial::one_pass::{
    Effort, Instructions, OnePassOptions, Workspace, contours, partial_model_with, seen,
};
use transect_partial::{BreakRule, SectionAxes};

/// Planes on which the plane-by-plane methods are timed; they are linear in their number.
const SAMPLE_PLANES: usize = 8;

/// Options of `bench partial`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Rows and columns of the image.
    #[arg(long, value_delimiter = ',', default_values_t = [512, 1024, 2048])]
    size: Vec<usize>,
    /// Numbers of planes.
    #[arg(long, value_delimiter = ',', default_values_t = [16, 64, 256, 1024])]
    planes: Vec<usize>,
    /// Where pixels are missing.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Gaps::Single, Gaps::Clustered])]
    gaps: Vec<Gaps>,
    /// Also time contourpy and GDAL, where a Python has them (TRANSECT_PYTHON names it).
    #[arg(long)]
    peers: bool,
    /// How often each variant is timed.
    #[arg(long, default_value_t = 11)]
    rounds: usize,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    for &size in &arguments.size {
        for &gaps in &arguments.gaps {
            let view = scene::view(size, gaps).ok_or_else(|| Failure::because("no such view"))?;
            for &count in &arguments.planes {
                let planes = scene::planes(&view, count);
                let planes = planes.ok_or_else(|| Failure::because("no such planes"))?;
                say(&format!(
                    "\n{size} × {size} pixels, {count} planes, {gaps:?} gaps, load {}",
                    load()
                ));
                case(&view, &planes, count, arguments.rounds)?;
                if arguments.peers {
                    peers::compare(&view, &planes, count, arguments.rounds)?;
                }
            }
        }
    }
    Ok(())
}

/// The rule that the scene's jumps are found with: twelve pixel steps of range per pixel.
fn rule() -> BreakRule {
    BreakRule::new(12_f64.atan(), 0.0)
}

fn case(view: &View, planes: &PlaneFamily, count: usize, rounds: usize) -> Result<(), Failure> {
    let axes = SectionAxes::new(view, planes)?;
    let far = PlaneFamily::new(planes.guide(), 1e6, 1e5)?;
    let far = SectionAxes::new(view, &far)?;
    let rule = rule();
    let seen = seen(view, &axes, &rule, Instructions::Best);
    let baselines = Baselines::new(view, &axes, &seen);
    let baselines = RefCell::new(baselines.ok_or_else(|| Failure::because("no baselines"))?);
    let sample: Vec<f32> = (0..SAMPLE_PLANES)
        .map(|k| (k as f32 + 0.5) * count as f32 / SAMPLE_PLANES as f32 - 0.5 * count as f32)
        .map(f32::round)
        .collect();
    let pixels = view.image().size().pixels() as f64;
    let crossings =
        contours(view, &axes, &rule, &Effort::default(), &mut Workspace::default())?.vertex_count();
    let kernel = |name, axes: &'_ SectionAxes, effort: Effort| {
        let mut work = Workspace::default();
        let axes = *axes;
        Variant::new(name, move || {
            let _ = black_box(
                contours(view, &axes, &rule, &effort, &mut work).map(|c| c.vertex_count()),
            );
        })
    };
    let with = |instructions| Effort { instructions, ..Effort::default() };
    let options =
        OnePassOptions {
            max_incidence_rad: 12_f64.atan(),
            jump_sigmas: 0.0,
            smooth: false,
            ..OnePassOptions::default()
        };
    let mut whole = Workspace::default();
    let scale = count as f64 / SAMPLE_PLANES as f64;
    let mut variants = vec![
        Variant::new("read", || {
            black_box(baselines.borrow().read());
        }),
        Variant::new("read + heights", || {
            black_box(baselines.borrow().heights());
        }),
        Variant::new("read + heights + levels", || {
            black_box(baselines.borrow_mut().levels());
        }),
        kernel("detection", &far, with(Instructions::Best)),
        kernel("one pass, portable", &axes, with(Instructions::Portable)),
        kernel("one pass, AVX2", &axes, with(Instructions::Avx2)),
        kernel("one pass, best", &axes, with(Instructions::Best)),
        Variant::new("one pass, fresh", || {
            let mut work = Workspace::default();
            let _ = black_box(
                contours(view, &axes, &rule, &Effort::default(), &mut work)
                    .map(|c| c.vertex_count()),
            );
        }),
        kernel("one pass, 2 threads", &axes, Effort { parts: 2, ..Effort::default() }).threaded(),
        Variant::new("curves with all attributes", || {
            let _ = black_box(partial_model_with(
                view,
                planes,
                &options,
                &Effort::default(),
                &mut whole,
            ));
        }),
        Variant::new("dissertation, fused", || {
            black_box(baselines.borrow_mut().fused(&sample));
        })
        .scaled(scale),
        Variant::new("dissertation, stored", || {
            black_box(baselines.borrow_mut().stored(&sample));
        })
        .scaled(scale),
        Variant::new("Cartesian", || {
            black_box(baselines.borrow_mut().cartesian(&sample));
        })
        .scaled(scale),
    ];
    let seconds = time(&mut variants, rounds);
    let detection = seconds[3];
    say(&format!("{crossings} vertices, {:.3} per pixel", crossings as f64 / pixels));
    say("variant                        ns/pixel   ns/vertex beyond detection   ratio");
    let ours = seconds[5];
    for (variant, s) in variants.iter().zip(&seconds) {
        say(&format!(
            "{:<30} {:>8.3}   {:>10.1}   {:>8.2}",
            variant.name,
            s * 1e9 / pixels,
            (s - detection) * 1e9 / crossings as f64,
            s / ours,
        ));
    }
    Ok(())
}
