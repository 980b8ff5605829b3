//! Whether points lie on a surface, found without a search.

use super::super::pair::ALIKE;
use super::points::Oriented;
use std::collections::HashMap;

/// Distance from the surface within which a point lies on it, over the spacing. No unit. Chosen by
/// hand: poses from two points are off by as much. Doubled, wrong poses score as well.
pub const NEAR: f64 = 0.5;

/// A surface as one point in each cube of a grid.
pub struct Surface {
    spacing: f64,
    cubes: HashMap<[i64; 4], Oriented>,
}

impl Surface {
    pub fn new(points: &[Oriented], spacing: f64) -> Self {
        let mut cubes = HashMap::new();
        for p in points {
            cubes.entry(p.cube(spacing)).or_insert(*p);
        }
        Self { spacing, cubes }
    }

    /// Whether a point lies near the tangent plane in its cube, and faces the same way.
    pub fn holds(&self, p: &Oriented) -> bool {
        self.cubes.get(&p.cube(self.spacing)).is_some_and(|q| {
            let apart = (p.point - q.point).dot(&q.normal).abs();
            apart < NEAR * self.spacing && p.normal.dot(&q.normal) > ALIKE
        })
    }
}
