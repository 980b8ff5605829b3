//! A curve in space by arc length, made of pieces: what all curved guides have in common.

use super::rounded::Rounded;
use super::spline::Spline;
use crate::{Point3, Vector3};

/// What is known of a curve at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PathPoint {
    pub point: Point3,
    /// Unit tangent.
    pub tangent: Vector3,
    /// Change of the tangent per length: towards the centre of curvature, one over its radius long.
    pub bend: Vector3,
}

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
