//! `cargo xtask bench partial`: the partial modeler, per pixel and per vertex.

use super::peers;
use super::scene;
use super::timing::{Variant, time};
use crate::failure::Failure;
use crate::table::say;
use std::hint::black_box;
use transect_device::View;
use transect_geometry::PlaneFamily;
use transect_partial::dissertation::{DissertationOptions, JumpTest};
use transect_partial::one_pass::{Effort, OnePassOptions, Workspace, contours, partial_model_with};
use transect_partial::{BreakRule, Method, SectionAxes, partial_model};

/// Planes on which the dissertation's method is timed. Its time is proportional to their number.
const SAMPLE_PLANES: usize = 8;

const DETECTION: &str = "one pass, no plane met";
const BEST: &str = "one pass, best";
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
    let Arguments { size, planes, peers, rounds } = arguments;
    size.iter().try_for_each(|&size| columns(size, planes, *rounds, *peers).map(drop))
}

/// Times an image with some numbers of planes: nanoseconds per pixel of each variant, and the
/// multiples of the sweep's time that other programs take. Without one of these, the second is
/// empty.
pub fn columns(
    size: usize,
    counts: &[usize],
    rounds: usize,
    with_peers: bool,
) -> Result<[Columns; 2], Failure> {
    let view = scene::view(size).ok_or_else(|| Failure::because("no such view"))?;
    let mut columns = [Columns::new(), Columns::new()];
    for &count in counts {
        let planes = scene::planes(&view, count);
        let planes = planes.ok_or_else(|| Failure::because("no such planes"))?;
        say(&format!("\n{size} × {size} pixels, {count} planes"));
        columns[0].push(Case { view: &view, planes: &planes, count, rounds }.run()?);
        if with_peers {
            columns[1].extend(peers::compare(&view, &planes, count, rounds)?);
        }
    }
    Ok(columns)
}

/// The names and figures of each number of planes.
pub type Columns = Vec<Vec<(&'static str, f64)>>;

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
    /// Prints the times of all variants, and returns their nanoseconds per pixel.
    fn run(&self) -> Result<Vec<(&'static str, f64)>, Failure> {
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
        let pixels = self.view.image().size().pixels() as f64;
        Ok(variants.iter().zip(seconds).map(|(v, s)| (v.name, s * 1e9 / pixels)).collect())
    }

    fn one_pass(&self, axes: SectionAxes, far: SectionAxes) -> Vec<Variant<'_>> {
        let mut options = OnePassOptions::default();
        options.max_incidence_rad = 12_f64.atan();
        options.jump_sigmas = 0.0;
        options.smooth = false;
        let mut whole = Workspace::default();
        vec![
            self.kernel(DETECTION, far),
            self.kernel(BEST, axes),
            Variant::new(CURVES, move || {
                let effort = Effort::default();
                let model =
                    partial_model_with(self.view, self.planes, &options, &effort, &mut whole);
                let _ = black_box(model);
            }),
        ]
    }

    fn kernel(&self, name: &'static str, axes: SectionAxes) -> Variant<'_> {
        let mut work = Workspace::default();
        Variant::new(name, move || {
            let found = contours(self.view, &axes, &rule(), &Effort::default(), &mut work);
            let _ = black_box(found.map(|c| c.vertex_count()));
        })
    }

    /// The lower bound of every method, and the dissertation's method on a sample of the planes.
    fn others(&self) -> Result<Vec<Variant<'_>>, Failure> {
        let sample = scene::planes(self.view, SAMPLE_PLANES);
        let sample = sample.ok_or_else(|| Failure::because("no such planes"))?;
        let jump = JumpTest::ScaleFree { max_incidence_rad: 12_f64.atan(), jump_sigmas: 0.0 };
        let mut options = DissertationOptions::default();
        (options.jump, options.smooth) = (jump, false);
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
        let scale = self.count as f64 / SAMPLE_PLANES as f64;
        Ok(vec![read, Variant { scale, ..dissertation }])
    }

    fn print(&self, variants: &[Variant<'_>], seconds: &[f64], (vertices, lines): (usize, usize)) {
        let pixels = self.view.image().size().pixels();
        let of = |name| {
            let place = variants.iter().position(|v| v.name == name);
            place.and_then(|k| seconds.get(k)).copied().unwrap_or(f64::NAN)
        };
        let (detection, sweep) = (of(DETECTION), of(BEST));
        let per_pixel = vertices as f64 / pixels as f64;
        say(&format!("{vertices} vertices, {per_pixel:.3} per pixel, on {lines} lines"));
        say("variant                        ns/pixel  ns/vertex beyond detection  times sweep");
        for (variant, s) in variants.iter().zip(seconds) {
            let beyond = (s - detection) * 1e9 / vertices as f64;
            let beyond = if beyond > 0.0 { format!("{beyond:.1}") } else { "-".to_owned() };
            let per_pixel = s * 1e9 / pixels as f64;
            let (name, times) = (variant.name, s / sweep);
            say(&format!("{name:<30} {per_pixel:>8.3}  {beyond:>26}  {times:>11.2}"));
        }
        say(&format!(
            "the dissertation's method takes {:.1} times {CURVES}",
            of(DISSERTATION) / of(CURVES),
        ));
    }
}
