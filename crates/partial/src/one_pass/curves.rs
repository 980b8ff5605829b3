//! From lines to curves, plane by plane.

use super::OnePassOptions;
use super::along_guide::AlongGuide;
use super::bend::Bend;
use super::bridge::{Gaps, Solved, Strand};
use super::contours::{Contours, Polyline};
use super::crossing::{Crossing, solve};
use super::ends::ends;
use super::near_tangent::NearTangent;
use super::nodes::NodeMaker;
use super::pair_line::PairLines;
use super::refine::CrossingSolver;
use super::vertex::Kind;
use crate::pixel_grid::Grid;
use crate::repeats::drop_repeats;
use crate::{PartialCurve, PartialModel, PlaneCurves, SectionAxes};
use transect_device::{Pixel, Vector3, View};
use transect_geometry::EndReason;
use transect_geometry::PlaneFrame;
use transect_image::BreakRule;
use transect_image::PreparedView;

/// Deviations of the noise over the plane beyond which a pair's rise is its surface's.
const WIDE_SIGMAS: f64 = 6.0;

/// The lines of a view, and what they were found with.
#[derive(Clone, Copy)]
pub(super) struct Lines<'a> {
    /// The view in which the lines were found.
    pub view: &'a View,
    pub prepared: &'a PreparedView<'a>,
    pub axes: &'a SectionAxes,
    pub rule: &'a BreakRule,
    pub contours: &'a Contours<'a>,
    /// Where crossings are solved along a curved guide.
    pub along: Option<&'a AlongGuide>,
}

impl Lines<'_> {
    /// The curves of all lines, grouped by plane. Lines are sorted by plane.
    pub fn model(&self, options: &OnePassOptions) -> PartialModel {
        let Self { view, prepared, axes, rule, contours, along } = *self;
        let grid = Grid::new(view.frame());
        let pairs = PairLines { view, rule, grid };
        let refined = CrossingSolver::new(prepared, axes, pairs, options.subpixel);
        let refinement = refined.filter(|_| along.is_none());
        let gaps = Gaps { view, rule, contours, grid, gap: options.gap.div_ceil(prepared.step()) };
        let mut near_tangent =
            NearTangent::new(view, prepared, axes, rule, options.excursion_sigmas);
        let mut nodes = NodeMaker {
            prepared,
            least_sigma_factor: options.least_sigma_factor,
            crossings: Vec::new(),
            upward: Vec::new(),
        };
        let mut model = PartialModel::default();
        let lines: Vec<Polyline<'_>> = contours.polylines().collect();
        let mut crossings = Vec::new();
        for lines in lines.chunk_by(|a, b| a.level == b.level) {
            self.solve(lines, &pairs, refinement.as_ref(), &mut crossings);
            let mut solved = with_crossings(lines, &crossings);
            solved.retain(|line| !near_tangent.is_noise(line, contours));
            let strands = gaps.bridge(&solved);
            let found = strands.iter().filter_map(|s| curve(&gaps, s, &solved, &mut nodes));
            let curves: Vec<PartialCurve> = found.collect();
            if let (Some(line), false) = (lines.first(), curves.is_empty()) {
                model.planes.push(PlaneCurves { plane: line.plane, curves });
            }
        }
        model
    }

    /// Crossings of all vertices of one plane's lines, in order.
    fn solve(
        &self,
        lines: &[Polyline<'_>],
        pairs: &PairLines<'_>,
        refinement: Option<&CrossingSolver<'_>>,
        crossings: &mut Vec<Crossing>,
    ) {
        crossings.clear();
        crossings.reserve(lines.iter().map(|line| line.vertices.len()).sum());
        let Some(level) = lines.first().map(|line| line.level) else { return };
        let along = self.along.map(|along| (along, along.frame(self.axes.plane(level))));
        let refined = refinement.map(|r| (r, r.solver(level)));
        let given = PairLines { view: self.prepared.given(), ..*pairs };
        crossings.extend(lines.iter().flat_map(|line| line.vertices).map(|vertex| {
            let (kind, pair) = self.contours.pair(vertex);
            let mut crossing = match &along {
                Some((along, plane)) => along.solve(kind, pair, plane),
                None => solve(self.view, self.axes, kind, pair, level),
            };
            if let Some((refinement, solver)) = &refined {
                refinement.refine(solver, kind, pair, &mut crossing);
            }
            let along = along.as_ref().map(|(along, plane)| (*along, plane));
            if let Some(line) = given.untested(kind, pair) {
                let views = [given.view, self.prepared.view()];
                let step = |beyond, near| self.step(views, [beyond, near], along);
                let (share, chord) = (f64::from(crossing.share), [&crossing.pair, &crossing.ray]);
                crossing.bend = Bend::at(share, chord, &line, (self.prepared, self.rule), step);
            }
            if let Some(wide) = self.wide(&crossing, (kind, pair), &given, along) {
                crossing.across = wide;
            }
            crossing
        }));
    }

    /// From one sample to another one of the same line, three pixels apart, if noise may have
    /// turned the pair itself.
    ///
    /// Noise picks the pairs that are crossed: they are those that it made steeper. Samples beside
    /// them are not picked. A smoothed pair keeps its direction, which a whole window made. Around
    /// others, samples count as they were given, since those far from all planes stay so.
    fn wide(
        &self,
        crossing: &Crossing,
        (kind, pair): (Kind, [Pixel; 2]),
        pairs: &PairLines<'_>,
        along: Option<(&AlongGuide, &PlaneFrame)>,
    ) -> Option<Vector3> {
        if self.prepared.shared_pixels(crossing.pixel) > 0.0 {
            return None;
        }
        let rise = crossing.ray.z.abs();
        let least = WIDE_SIGMAS * self.prepared.sigma_at(crossing.pixel) * rise;
        if least == 0.0 || crossing.pair.z.abs() > least {
            return None;
        }
        let line = pairs.of(kind, pair)?;
        let pair = [line.before?, line.after?];
        Some(self.step([pairs.view; 2], pair, along)? / 3.0)
    }

    /// From a sample of one view to a sample of another, in plane coordinates with the height
    /// third.
    fn step(
        &self,
        views: [&View; 2],
        pixels: [Pixel; 2],
        along: Option<(&AlongGuide, &PlaneFrame)>,
    ) -> Option<Vector3> {
        let ([a, b], [from, to]) = (views, pixels);
        let step = b.point_in_sensor(to)? - a.point_in_sensor(from)?;
        Some(along.map_or_else(|| self.axes.turn(&step), |(along, plane)| along.turn(&step, plane)))
    }
}

/// The curve of a strand; `None` if it has too few nodes.
fn curve(
    gaps: &Gaps<'_>,
    strand: &Strand,
    lines: &[Solved<'_>],
    nodes: &mut NodeMaker<'_>,
) -> Option<PartialCurve> {
    collect(strand, lines, &mut nodes.crossings);
    nodes.count_upward();
    let count = nodes.crossings.len();
    if count < 2 + usize::from(strand.closed) {
        return None;
    }
    let all = (0..count).map(|k| nodes.node(k, strand.closed)).collect();
    let pixels = nodes.crossings.iter().map(|c| nodes.prepared.in_image(c.pixel)).collect();
    let ends = if strand.closed { None } else { reasons(gaps, strand, lines) };
    PartialCurve::new((all, strand.closed), pixels, ends)
}

/// Why an open strand begins and ends where it does.
fn reasons(gaps: &Gaps<'_>, strand: &Strand, lines: &[Solved<'_>]) -> Option<[EndReason; 2]> {
    let vertices = || strand.lines.iter().flat_map(|k| lines[*k].line.vertices);
    let mut from_start = vertices();
    let first = (from_start.next()?, from_start.next()?);
    let mut from_end = vertices().rev();
    let last = (from_end.next()?, from_end.next()?);
    Some(ends(gaps, [first, last]))
}

/// Lines with their crossings, which lie one after the other.
fn with_crossings<'a>(lines: &[Polyline<'a>], crossings: &'a [Crossing]) -> Vec<Solved<'a>> {
    let mut rest = crossings;
    let solved = lines.iter().map(|line| {
        let (crossings, others) = rest.split_at(line.vertices.len().min(rest.len()));
        rest = others;
        Solved { line: *line, crossings }
    });
    solved.collect()
}

/// The crossings of a strand, with its bridges marked.
fn collect(strand: &Strand, lines: &[Solved<'_>], crossings: &mut Vec<Crossing>) {
    crossings.clear();
    for (position, line) in strand.lines.iter().enumerate() {
        let solved = &lines[*line];
        crossings.extend_from_slice(solved.crossings);
        let joined = position + 1 < strand.lines.len() || strand.closed && !solved.line.closed;
        if let (true, Some(last)) = (joined, crossings.last_mut()) {
            last.bridged_after = true;
        }
    }
    drop_repeats(crossings, strand.closed);
}
