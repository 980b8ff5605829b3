//! `cargo xtask bench partial`: the partial modeler, per pixel and per vertex.

use super::peers;
use super::scene::{self, Gaps};
use super::timing::{Variant, load, time};
use crate::failure::Failure;
use crate::table::say;
use std::hint::black_box;
use transect_device::View;
use transect_geometry::PlaneFamily;
use transect_partial::dissertation::{DissertationOptions, JumpTest};
use transect_partial::one_pass::{
    Effort, Instructions, OnePassOptions, Workspace, contours, partial_model_with,
};
use transect_partial::{BreakRule, Method, SectionAxes, partial_model};

/// Planes on which the dissertation's method is timed. Its time is proportional to their number.
const SAMPLE_PLANES: usize = 8;

const DETECTION: &str = "one pass, no plane met";
const OURS: &str = "one pass, AVX2";
const BEST: &str = "one pass, best";
const FRESH: &str = "one pass, fresh memory";
const CURVES: &str = "curves with all attributes";
const DISSERTATION: &str = "dissertation, plane by plane";

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
    /// Also time contourpy and GDAL, each in the first Python that has it: the one named by
    /// TRANSECT_PYTHON, python3, /usr/bin/python3.
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
                Case { view: &view, planes: &planes, count, rounds: arguments.rounds }.run()?;
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

/// One image and one family of planes.
struct Case<'a> {
    view: &'a View,
    planes: &'a PlaneFamily,
    count: usize,
    rounds: usize,
}

impl Case<'_> {
    fn run(&self) -> Result<(), Failure> {
        let axes = SectionAxes::new(self.view, self.planes)?;
        // Planes that nothing meets: what finding out costs.
        let far = PlaneFamily::new(self.planes.guide().clone(), 1e6, 1e5)?;
        let far = SectionAxes::new(self.view, &far)?;
        let mut work = Workspace::default();
        let found = contours(self.view, &axes, &rule(), &Effort::default(), &mut work)?;
        let (vertices, lines) = (found.vertex_count(), found.polylines().len());
        let bytes = work.bytes();
        let mut variants = self.one_pass(axes, far);
        variants.extend(self.others()?);
        let seconds = time(&mut variants, self.rounds);
        self.print(&variants, &seconds, (vertices, lines));
        // A workspace only grows, so what it holds at the end is the most that it needed.
        say(&format!(
            "memory beyond the image: {:.2} MB, {:.0} bytes per vertex, {:.2} per pixel",
            bytes as f64 * 1e-6,
            bytes as f64 / vertices as f64,
            bytes as f64 / self.view.image().size().pixels() as f64,
        ));
        Ok(())
    }

    fn one_pass(&self, axes: SectionAxes, far: SectionAxes) -> Vec<Variant<'_>> {
        let with = |instructions| Effort { instructions, ..Effort::default() };
        let two = |instructions| Effort { parts: 2, ..with(instructions) };
        let mut options = OnePassOptions::default();
        options.max_incidence_rad = 12_f64.atan();
        options.jump_sigmas = 0.0;
        options.smooth = false;
        let mut whole = Workspace::default();
        vec![
            self.kernel(DETECTION, far, with(Instructions::Best)),
            self.kernel("one pass, portable", axes, with(Instructions::Portable)),
            self.kernel(OURS, axes, with(Instructions::Avx2)),
            self.kernel(BEST, axes, with(Instructions::Best)),
            Variant::new(FRESH, move || {
                lines_of(self.view, &axes, &Effort::default(), &mut Workspace::default());
            }),
            self.kernel("portable, two threads", axes, two(Instructions::Portable)).threaded(),
            self.kernel("AVX2, two threads", axes, two(Instructions::Avx2)).threaded(),
            self.kernel("best, two threads", axes, two(Instructions::Best)).threaded(),
            Variant::new(CURVES, move || {
                let effort = Effort::default();
                let model =
                    partial_model_with(self.view, self.planes, &options, &effort, &mut whole);
                let _ = black_box(model);
            }),
        ]
    }

    fn kernel(&self, name: &'static str, axes: SectionAxes, effort: Effort) -> Variant<'_> {
        let mut work = Workspace::default();
        Variant::new(name, move || lines_of(self.view, &axes, &effort, &mut work))
    }

    /// The lower bound of every method, and the dissertation's method on a sample of the planes.
    fn others(&self) -> Result<Vec<Variant<'_>>, Failure> {
        let sample = scene::planes(self.view, SAMPLE_PLANES);
        let sample = sample.ok_or_else(|| Failure::because("no such planes"))?;
        let mut options = DissertationOptions::default();
        options.jump = JumpTest::ScaleFree { max_incidence_rad: 12_f64.atan(), jump_sigmas: 0.0 };
        options.smooth = false;
        let method = Method::Dissertation(options);
        // Not every sensor has the inverse mapping that this method needs.
        partial_model(self.view, &sample, &method)?;
        let dissertation = Variant::new(DISSERTATION, move || {
            let _ = black_box(partial_model(self.view, &sample, &method));
        });
        let image = self.view.image();
        let read = Variant::new("read", || {
            let rows = (0..image.size().rows).map(|row| image.row(row).iter().sum::<f32>());
            black_box(rows.sum::<f32>());
        });
        Ok(vec![read, dissertation.scaled(self.count as f64 / SAMPLE_PLANES as f64)])
    }

    fn print(&self, variants: &[Variant<'_>], seconds: &[f64], (vertices, lines): (usize, usize)) {
        let pixels = self.view.image().size().pixels();
        let of = |name| {
            let place = variants.iter().position(|v| v.name == name);
            place.and_then(|k| seconds.get(k)).copied().unwrap_or(f64::NAN)
        };
        let (detection, ours) = (of(DETECTION), of(OURS));
        let per_pixel = vertices as f64 / pixels as f64;
        say(&format!("{vertices} vertices, {per_pixel:.3} per pixel, on {lines} lines"));
        say(&counts(self.view, self.count, vertices));
        say("variant                        ns/pixel  ns/vertex beyond detection  times AVX2");
        for (variant, s) in variants.iter().zip(seconds) {
            let beyond = (s - detection) * 1e9 / vertices as f64;
            let beyond = if beyond > 0.0 { format!("{beyond:.1}") } else { "-".to_owned() };
            let per_pixel = s * 1e9 / pixels as f64;
            let (name, times) = (variant.name, s / ours);
            say(&format!("{name:<30} {per_pixel:>8.3}  {beyond:>26}  {times:>10.2}"));
        }
        say(&format!(
            "fresh memory takes {:.2} times a kept workspace; the dissertation's method {:.1} times {CURVES}",
            of(FRESH) / of(BEST),
            of(DISSERTATION) / of(CURVES),
        ));
    }
}

fn lines_of(view: &View, axes: &SectionAxes, effort: &Effort, work: &mut Workspace) {
    let found = contours(view, axes, &rule(), effort, work).map(|c| c.vertex_count());
    let _ = black_box(found);
}

/// Additions and multiplications as the dissertation's Appendix A counts them, and ours.
///
/// m × n pixels, l planes, p crossings per plane. Ours, for an imaging radar: two of each for a
/// level and two for each of the two pair tests; for a crossing at most four multiplications and
/// two additions per sample for its place, and four (with a division) and six for the crossing
/// itself.
fn counts(view: &View, planes: usize, vertices: usize) -> String {
    let (mn, m) = (view.image().size().pixels() as f64, view.image().size().rows as f64);
    let (l, lp) = (planes as f64, vertices as f64);
    let cartesian = (12.0 * l * mn + 14.0 * mn, 12.0 * l * mn + 9.0 * mn);
    let device = (14.0 * lp + 4.0 * l * mn + 3.0 * l * m, 9.0 * lp + 2.0 * l * mn);
    let ours = (6.0 * mn + 12.0 * lp, 6.0 * mn + 10.0 * lp);
    let line = |name: &str, (times, plus): (f64, f64)| {
        format!("{name} {:.1} and {:.1}", times / mn, plus / mn)
    };
    format!(
        "multiplications and additions per pixel (Appendix A): {}, {}, {}",
        line("Cartesian frame", cartesian),
        line("device frame", device),
        line("one pass at most", ours),
    )
}
