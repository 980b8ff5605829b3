//! The cells and rings of points, and the angles that both follow from.

use crate::error::Problem;
use transect_geometry::Point3;

/// The laser and the column of every point.
pub(super) struct Cells {
    pub(super) lasers: usize,
    pub(super) cols: usize,
    /// The cell of a point; `None` for a point that is left out.
    pub(super) cell: Vec<Option<(u16, u32)>>,
}

/// The ring of every point, as a number from 0 without gaps.
pub(super) struct Rings {
    pub(super) count: usize,
    pub(super) numbers: Vec<u16>,
}

/// Most rings of a file. Chosen by hand: eight times the most lasers of a rotating lidar in use.
/// Doubled, a damaged field makes a grid of more rows before it is refused.
pub(super) const MOST_RINGS: usize = 1024;

impl Rings {
    pub(super) fn of_field(values: &[u16]) -> Result<Self, Problem> {
        let mut numbers = vec![None; usize::from(u16::MAX) + 1];
        for value in values {
            if let Some(number) = numbers.get_mut(usize::from(*value)) {
                *number = Some(0);
            }
        }
        let mut count = 0_u16;
        for number in numbers.iter_mut().flatten() {
            *number = count;
            count = count.saturating_add(1);
        }
        if usize::from(count) > MOST_RINGS {
            let problem = format!("{count} different rings; expected at most {MOST_RINGS}");
            return Err(Problem::damaged(problem));
        }
        let number = |v: &u16| numbers.get(usize::from(*v)).copied().flatten().unwrap_or(0);
        Ok(Self { count: count.into(), numbers: values.iter().map(number).collect() })
    }
}

/// Whether a point is a return.
pub(super) fn is_valid(point: &Point3) -> bool {
    point.coords.iter().all(|c| c.is_finite()) && *point != Point3::origin()
}

/// Angle of a point above the plane of rotation, in radians.
pub(super) fn elevation(point: &Point3) -> f64 {
    point.z.atan2(point.x.hypot(point.y))
}
