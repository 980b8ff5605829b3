//! Crossings solved again by another subpixel solution than the linear one (3.6).

use super::crossing::Crossing;
use super::pair_line::PairLines;
use super::vertex::Kind;
use crate::SectionAxes;
use crate::subpixel::{AngularGrid, PairLine, PairMeeting, Solver, Subpixel};
use transect_device::Pixel;
use transect_image::PreparedView;

/// Deviation of a cubic from its chord, per deviation of the samples, from which the cubic is
/// taken.
///
/// Half way between samples with noise of their own, the cubic's error has 0.64 of their variance
/// and the chord's 0.5. So the cubic is the better one where it leaves the chord by more than √0.14
/// = 0.37 deviations. That is three deviations of what noise makes of their difference.
const LEAST_BEND: f64 = 0.4;

/// The way to solve the crossings of one view.
pub(super) struct CrossingSolver<'a> {
    prepared: &'a PreparedView<'a>,
    axes: &'a SectionAxes,
    lines: PairLines<'a>,
    method: Subpixel,
    angles: Option<AngularGrid>,
}

impl<'a> CrossingSolver<'a> {
    /// `None` for the linear solution, which crossings have already.
    pub fn new(
        prepared: &'a PreparedView<'a>,
        axes: &'a SectionAxes,
        lines: PairLines<'a>,
        method: Subpixel,
    ) -> Option<Self> {
        if method == Subpixel::Cartesian {
            return None;
        }
        let frame = prepared.view().frame();
        let angles = method.uses_angles().then(|| AngularGrid::read(frame)).flatten();
        Some(Self { prepared, axes, lines, method, angles })
    }

    /// The solver for the plane at a level.
    pub fn solver(&self, level: i32) -> Solver<'_> {
        let plane = self.axes.sensor_plane(level);
        Solver::new(self.prepared.view(), plane, self.method, self.angles.as_ref())
    }

    /// Moves a crossing of a pair to where the solver finds it. Diagonals, which are no line of the
    /// scan, keep the linear solution, and so do curves that noise alone may have bent.
    pub fn refine(&self, solver: &Solver<'_>, kind: Kind, pair: [Pixel; 2], at: &mut Crossing) {
        let line = match self.method {
            Subpixel::FourPoint => self.lines.of(kind, pair),
            _ => PairLines::bare(kind, pair),
        };
        let Some(line) = line else { return };
        if let Some(meeting) = self.meeting(solver, &line) {
            at.position = self.axes.in_plane(&meeting.point);
            at.pixel = if meeting.parameter < 0.5 { line.first } else { line.second };
        }
    }

    fn meeting(&self, solver: &Solver<'_>, line: &PairLine) -> Option<PairMeeting> {
        let cubic = self.method == Subpixel::FourPoint;
        if cubic && (line.before.is_none() || line.after.is_none()) {
            return None;
        }
        let meeting = solver.meet(line)?;
        if cubic && self.prepared.sigma() > 0.0 {
            let view = self.prepared.view();
            let (p, q) = (view.point_in_sensor(line.first)?, view.point_in_sensor(line.second)?);
            let bend = (meeting.point - (p + (q - p) * meeting.parameter)).norm();
            if bend < LEAST_BEND * self.prepared.sigma_at(line.first) {
                return None;
            }
        }
        Some(meeting)
    }
}
