//! A curve in space by arc length, made of pieces.

use super::path_point::{PathPoint, Tightest};
use super::rounded::Rounded;
use super::spline::Spline;
use crate::Vector3;

/// A curve with unit tangents that never jump.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Path {
    Rounded(Rounded),
    Spline(Spline),
}

impl Path {
    pub fn length(&self) -> f64 {
        self.starts().last().copied().unwrap_or(0.0)
    }

    /// Stations where pieces begin, and the end of the last one.
    pub fn starts(&self) -> &[f64] {
        match self {
            Self::Rounded(path) => &path.starts,
            Self::Spline(path) => &path.starts,
        }
    }

    /// Where it bends most.
    pub fn sharpest(&self) -> Tightest {
        match self {
            Self::Rounded(path) => path.sharpest(),
            Self::Spline(path) => path.sharpest(),
        }
    }

    /// The piece that holds a station.
    pub fn piece_at(&self, station: f64) -> usize {
        let starts = self.starts();
        let after = starts.partition_point(|start| *start <= station);
        after.saturating_sub(1).min(starts.len().saturating_sub(2))
    }

    /// Beyond its ends the curve goes on straight.
    pub fn at(&self, station: f64) -> PathPoint {
        let on_curve = station.clamp(0.0, self.length());
        let piece = self.piece_at(on_curve);
        let mut at = match self {
            Self::Rounded(path) => path.at(piece, on_curve),
            Self::Spline(path) => path.at(piece, on_curve),
        };
        if station != on_curve {
            at.point += at.tangent * (station - on_curve);
            at.bend = Vector3::zeros();
        }
        at
    }
}
