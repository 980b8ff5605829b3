//! The partial modeler on one image, per pixel and per vertex.

use super::{Column, scene};
use crate::failure::Failure;
use crate::table::say;
use crate::timing::{Variant, time};
use std::hint::black_box;
use transect_device::View;
use transect_geometry::{Node, PlaneFamily, Point2};
use transect_partial::dissertation::{DissertationOptions, JumpTest};
use transect_partial::one_pass::{Effort, OnePassOptions, Workspace, contours, partial_model_with};
use transect_partial::{BreakRule, Method, SectionAxes, partial_model};

/// Planes on which the dissertation's method is timed. Its time is proportional to their number.
const SAMPLE_PLANES: usize = 8;

const DETECTION: &str = "one pass, no plane met";
const BEST: &str = "one pass, best";
const WRITTEN: &str = "samples read and nodes written";
const CURVES: &str = "curves with all attributes";
const DISSERTATION: &str = "dissertation, plane by plane";

/// The rule that the scene's jumps are found with: twelve pixel steps of range per pixel.
fn rule() -> BreakRule {
    BreakRule::new(12_f64.atan(), 0.0)
}

/// One image and one family of planes.
pub struct Case<'a> {
    pub view: &'a View,
    pub planes: &'a PlaneFamily,
    /// The number of planes.
    pub count: usize,
    /// How often each variant is timed.
    pub rounds: usize,
}

impl Case<'_> {
    /// Prints work, memory and the time per vertex, and returns the nanoseconds per pixel of all
    /// variants.
    pub fn run(&self) -> Result<Column, Failure> {
        let axes = SectionAxes::new(self.view, self.planes)?;
        // Planes that nothing meets: what finding out costs.
        let far = PlaneFamily::new(self.planes.guide().clone(), 1e6, 1e5)?;
        let far = SectionAxes::new(self.view, &far)?;
        let mut work = Workspace::default();
        let found = contours(self.view, &axes, &rule(), &Effort::default(), &mut work)?;
        let (vertices, lines) = (found.vertex_count() as f64, found.polylines().len());
        // A workspace only grows, so what it holds at the end is the most that it needed.
        let bytes = work.bytes() as f64;
        let mut variants = self.one_pass(axes, far);
        variants.extend(self.others()?);
        let pixels = self.view.image().size().pixels() as f64;
        let per_pixel = time(&mut variants, self.rounds).into_iter().map(|s| s * 1e9 / pixels);
        let column: Column = variants.iter().map(|v| v.name).zip(per_pixel).collect();
        let of = |name| column.iter().find(|c| c.0 == name).map_or(f64::NAN, |c| c.1);
        let per_vertex = |name| (of(name) - of(DETECTION)) * pixels / vertices;
        say(&format!(
            "{vertices} vertices, {:.3} per pixel, on {lines} lines; memory beyond the image: {:.2} \
             MB, {:.0} bytes per vertex\n\
             beyond detection, the sweep takes {:.1} ns per vertex, and {CURVES} take {:.1}: {:.1} \
             times the sweep; {WRITTEN}, without any attribute: {:.1} times",
            vertices / pixels,
            bytes * 1e-6,
            bytes / vertices,
            per_vertex(BEST),
            per_vertex(CURVES),
            per_vertex(CURVES) / per_vertex(BEST),
            per_vertex(WRITTEN) / per_vertex(BEST),
        ));
        Ok(column)
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
            self.written(axes),
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

    /// The lower bound of every way to make nodes: the sweep, then both samples of each vertex are
    /// read, and a node is written that has their middle and no computed attribute.
    fn written(&self, axes: SectionAxes) -> Variant<'_> {
        let mut work = Workspace::default();
        Variant::new(WRITTEN, move || {
            let found = contours(self.view, &axes, &rule(), &Effort::default(), &mut work);
            let Ok(found) = found else { return };
            let node = |vertex| {
                let (_, [a, b]) = found.pair(vertex);
                let [a, b] = [a, b].map(|p| self.view.point_in_sensor(p).unwrap_or_default());
                Node::at(Point2::new(a.x + b.x, a.y + b.y)).with_sigma((a.z + b.z) as f32)
            };
            let lines = found.polylines().map(|line| line.vertices.iter().map(node).collect());
            black_box(lines.collect::<Vec<Vec<Node>>>());
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
}
