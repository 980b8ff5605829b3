//! Single pixels as pieces of surface, in cells that are no smooth surface.
//!
//! **Problem.** Only the jambs of its windows tell where a view belongs along a wall, and only its
//! ribs tell it along a tunnel. They are two or three pixels wide, and cells that hold them are no
//! smooth surface.
//!
//! **Idea.** Point to plane over single samples (Chen and Medioni, 1992), in such cells alone.
//! Those with the patch of a part have facets, too: the patch says nothing of the other parts.
//!
//! **Steps.**
//! 1. A pixel has a facet: the plane of those of its eight neighbours that lie no farther away than
//!    neighbours on one surface do. Noise must explain what these depart from it.
//! 2. A point lies over the nearest facet of its cell, if it is beside that by no more than half
//!    the diagonal between pixels. Otherwise facets at the rim of what a view sees would draw all
//!    points beyond it.
//! 3. The distance runs along the mean of both views' normals (Rusinkiewicz, 2019): on curved
//!    surfaces what both err by cancels.
//! 4. Samples are taken in turn from all directions of facets, as most are of the wall around.
//!
//! **Departures.** All facets of a cell count as one patch. Views whose neighbouring pixels share
//! most of their noise have none: steps of that noise would pass for relief.
//!
//! **Gain.** Errors of refined poses in mm, without and with facets, of simulated scans that are
//! not bundled:
//! * three ribbed tunnels: 18, 18 and 6.6 without, 0.3, 0.9 and 0.4 with;
//! * three walls with windows: 19, 14 and 15 without, 1.5, 2.9 and 2.4 with;
//! * the first tunnel and the first wall as grids of points: 18 and 19 without, 1.2 and 1.3 with;
//! * a lattice: 5.7 without, 0.3 with; stairs: 7.3 without, 5.0 with.
//!
//! Sections of rooms and of parts from twelve views change by less than 2 %. Where few views
//! overlap, they change either way. Medians of the machined part, poses 0.5° off: four views
//! 0.64 mm without, 0.25 with; six views 0.04 without, 0.11 with (`cargo xtask experiments poses`).
//!
//! **Limit.** Facets err by more than their noise tells: two exact views of the room would move by
//! 5 % of their noise, if the observations that were left out had not to agree clearly. The walls
//! keep 1.5 to 3 mm. Comparing all points took the walls to 0.4 to 0.8 mm, and displaced a gear by
//! 11 mm.

use super::patch::{axes, largest_rough};
use super::sampled::Sampling;
use crate::scrambled::scrambled;
use crate::tuning::{
    ALIKE_DEGREES, FACET_NOISE, FACET_REACH, LEAST_IN_FACET, MAX_INCIDENCE_DEGREES, SAMPLING_ROUGH,
};
use nalgebra::{Matrix3, Vector2};
use std::collections::BTreeMap;
use transect_device::{ImageSize, Pixel, Point3, Vector3};

/// The plane through a pixel and its neighbours, in the sensor frame.
#[derive(Debug, Clone, Copy)]
struct Facet {
    /// On the sensor's side.
    normal: [f32; 3],
    /// Distance between neighbouring samples.
    spacing: f32,
    /// Standard deviation along the normal.
    sigma: f32,
}

/// The facets of a view.
#[derive(Debug, Clone, Default)]
pub(crate) struct Facets {
    /// A place among the samples: far from them, single precision is coarse.
    origin: Point3,
    /// The pixels' samples from there: x, y and z, by cell.
    at: [Vec<f32>; 3],
    facets: Vec<Facet>,
    /// Number of the first facet of each cell, and at last that of all facets.
    first: Vec<u32>,
}

/// A facet that a point lies over.
pub(crate) struct FacetMeeting {
    /// Signed distance of the point along the normal, positive on the sensor's side.
    pub distance: f64,
    /// The mean of the facet's normal and the point's own.
    pub normal: Vector3,
    /// Standard deviation of the facet along its normal.
    pub sigma: f64,
    /// Distance between neighbouring samples.
    pub spacing: f64,
}

impl Facets {
    /// The facets of the rough cells; `size` is that of all cells.
    pub(super) fn new(
        sampling: &Sampling<'_>,
        size: ImageSize,
        origin: Point3,
        rough: &[bool],
    ) -> Self {
        let mut facets = Self { origin, first: vec![0], ..Self::default() };
        for (k, is_rough) in rough.iter().enumerate() {
            if *is_rough {
                let (row, col) = (k / size.cols * sampling.step, k % size.cols * sampling.step);
                facets.add(sampling, Pixel::new(row, col));
            }
            facets.first.push(facets.facets.len() as u32);
        }
        facets
    }

    fn add(&mut self, sampling: &Sampling<'_>, corner: Pixel) {
        // With the pixels around the cell.
        let side = sampling.step + 2;
        let point = |k: usize| sampling.point_beside(corner, [k / side, k % side]);
        let points: Vec<Option<Point3>> = (0..side * side).map(point).collect();
        let size = sampling.view.image().size();
        let in_cell = (0..sampling.step.pow(2)).map(|k| (k / sampling.step, k % sampling.step));
        for (row, col) in in_cell {
            let pixel = Pixel::new(corner.row + row, corner.col + col);
            if size.index(pixel).is_none() {
                continue;
            }
            let first = row * side + col;
            let rows = [0, 1, 2].map(|row| &points[first + row * side..][..3]);
            if let Some((at, facet)) = facet(sampling, pixel, rows) {
                let from_origin = (at - self.origin).map(|c| c as f32);
                let to = self.at.iter_mut().zip(&from_origin);
                to.for_each(|(all, c)| all.push(*c));
                self.facets.push(facet);
            }
        }
    }

    /// The sample of one facet of a cell, about in its middle.
    pub fn middle(&self, cell: usize) -> Option<Point3> {
        let (from, to) = self.first.get(cell).zip(self.first.get(cell + 1))?;
        (from < to).then(|| self.point((from + to) as usize / 2)).flatten()
    }

    /// The facet of a cell whose sample is nearest to a point.
    fn nearest(&self, cell: usize, in_sensor: &Point3) -> Option<usize> {
        let (from, to) = self.first.get(cell).zip(self.first.get(cell + 1))?;
        let [x, y, z] = self.at.each_ref().map(|all| all.get(*from as usize..*to as usize));
        let point: [f32; 3] = (in_sensor - self.origin).map(|c| c as f32).into();
        // Several at once: the compiler makes vectors of such lanes.
        let mut nearest = [(f32::INFINITY, 0); LANES];
        let lanes = x?.chunks(LANES).zip(y?.chunks(LANES)).zip(z?.chunks(LANES)).enumerate();
        for (k, ((x, y), z)) in lanes {
            for (lane, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
                let square =
                    (x - point[0]).powi(2) + (y - point[1]).powi(2) + (z - point[2]).powi(2);
                if square < nearest[lane].0 {
                    nearest[lane] = (square, k * LANES + lane);
                }
            }
        }
        let nearest = nearest.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        nearest.0.is_finite().then_some(*from as usize + nearest.1)
    }

    /// The facet of a cell that a point of the sensor frame lies over. `normal` is the point's own.
    pub fn meeting(
        &self,
        cell: usize,
        in_sensor: &Point3,
        normal: &Vector3,
    ) -> Option<FacetMeeting> {
        let k = self.nearest(cell, in_sensor)?;
        let nearest = self.facets.get(k)?;
        if nearest.normal().dot(normal) < ALIKE_DEGREES.to_radians().cos() {
            return None;
        }
        let normal = (nearest.normal() + normal).normalize();
        let off = in_sensor - self.point(k)?;
        let (distance, spacing) = (off.dot(&normal), f64::from(nearest.spacing));
        let beside = off - normal * distance;
        let sigma = f64::from(nearest.sigma);
        let over = beside.norm_squared() <= 0.5 * spacing.powi(2);
        over.then_some(FacetMeeting { distance, normal, sigma, spacing })
    }

    /// Facets by turns from all directions: of each its cell, sample, normal, and standard
    /// deviation along the normal.
    pub fn samples(&self, most: usize) -> Vec<(usize, Point3, Vector3, f64)> {
        let mut by_direction: BTreeMap<[i8; 3], Vec<(u32, usize)>> = BTreeMap::new();
        for (k, facet) in self.facets.iter().enumerate() {
            let direction = facet.normal.map(|c| (c * DIRECTIONS).round() as i8);
            by_direction.entry(direction).or_default().push((scrambled(k as u32), k));
        }
        by_direction.values_mut().for_each(|of_direction| of_direction.sort_unstable());
        let mut taken = Vec::new();
        for turn in 0.. {
            let before = taken.len();
            taken.extend(by_direction.values().filter_map(|all| all.get(turn)).map(|(_, k)| *k));
            if taken.len() == before || taken.len() >= most {
                break;
            }
        }
        let sample = |k: usize| {
            let facet = self.facets.get(k)?;
            let cell = self.first.partition_point(|first| *first as usize <= k).checked_sub(1)?;
            Some((cell, self.point(k)?, facet.normal(), f64::from(facet.sigma)))
        };
        taken.into_iter().take(most).filter_map(sample).collect()
    }

    fn point(&self, k: usize) -> Option<Point3> {
        let [x, y, z] = self.at.each_ref().map(|all| all.get(k).copied().map(f64::from));
        Some(self.origin + Vector3::new(x?, y?, z?))
    }
}

impl Facet {
    fn normal(&self) -> Vector3 {
        Vector3::from(self.normal.map(f64::from))
    }
}

/// Samples that are compared at once. Chosen by hand. Doubled, cells leave more lanes empty.
const LANES: usize = 8;

/// Steps of a normal's coordinate from 0 to 1 that tell directions apart. Chosen by hand: about 20
/// degrees. Doubled, single directions of noisy facets take the turns of others.
const DIRECTIONS: f32 = 3.0;

/// The facet in the middle of three rows of three pixels, with its sample.
fn facet(
    sampling: &Sampling<'_>,
    pixel: Pixel,
    [above, here, below]: [&[Option<Point3>]; 3],
) -> Option<(Point3, Facet)> {
    let middle = here[1]?;
    let ray = sampling.view.frame().ray(pixel)?;
    let noise = sampling.noise.length_at(sampling.view, pixel);
    let to = |p: Option<Point3>| p.map(|p| p - middle);
    let beside = [here[0], here[2], above[1], below[1]].map(to);
    let across = beside.iter().flatten().map(|d| d.cross(&ray.direction).norm());
    if noise > FACET_NOISE * across.fold(f64::INFINITY, f64::min) {
        return None;
    }
    let [left, right, up, down] = beside.map(|d| d.map_or(f64::INFINITY, |d| d.norm()));
    let spacing = left.min(right).max(up.min(down));
    let axes = axes(&ray.direction)?;
    let near = |d: &Vector3| d.norm() <= FACET_REACH * spacing;
    let all = || above.iter().chain(here).chain(below).filter_map(|p| to(*p)).filter(near);
    let count = all().count();
    if !spacing.is_finite() || count < LEAST_IN_FACET {
        return None;
    }
    let ([along_a, along_b], square) = plane(all().map(|d| axes.map(|axis| d.dot(&axis))))?;
    let [first, second, along_ray] = axes;
    let normal = (first * along_a + second * along_b - along_ray).normalize();
    let incidence = -normal.dot(&along_ray);
    if incidence < MAX_INCIDENCE_DEGREES.to_radians().cos() {
        return None;
    }
    let spare = (count - 3) as f64;
    let rough = (square / spare).sqrt();
    if rough > largest_rough(spare) * noise + SAMPLING_ROUGH * spacing {
        return None;
    }
    let facet = Facet {
        normal: normal.map(|c| c as f32).into(),
        spacing: spacing as f32,
        sigma: (rough.max(noise) * incidence) as f32,
    };
    Some((middle, facet))
}

/// The slopes of the plane `w` over `a` and `b` that fits points best, and the sum of the squares
/// of what they depart from it.
fn plane(points: impl Iterator<Item = [f64; 3]> + Clone) -> Option<([f64; 2], f64)> {
    let points = points.map(Vector3::from);
    let (count, sum) =
        points.clone().fold((0.0, Vector3::zeros()), |(n, sum), p| (n + 1.0, sum + p));
    let spread =
        points.map(|p| p - sum / count).fold(Matrix3::zeros(), |s, d| s + d * d.transpose());
    let (over, [of_a, of_b]) = (spread.fixed_view::<2, 2>(0, 0), [spread[(0, 2)], spread[(1, 2)]]);
    let slopes = over.try_inverse()? * Vector2::new(of_a, of_b);
    let square = spread[(2, 2)] - slopes.dot(&Vector2::new(of_a, of_b));
    Some((slopes.into(), square.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::super::CoarseView;
    use super::*;
    use std::sync::Arc;
    use transect_device::{Isometry3, RangeImage, View};
    use transect_sensors::{Intrinsics, Pinhole};

    /// A wall 2 m away with a step of 0.1 m from column 30 on, seen straight on. Rays are 10 mm
    /// apart.
    fn step(noise: f64) -> CoarseView {
        let size = ImageSize { rows: 48, cols: 64 };
        let camera = Pinhole::new(size, Intrinsics { fx: 200.0, fy: 200.0, cx: 31.5, cy: 23.5 });
        let depth = |p: Pixel| if p.col < 30 { 2.0 } else { 2.1 };
        let values = size.all_pixels().map(|p| depth(p) as f32).collect();
        let image = RangeImage::from_values(size, values).unwrap();
        let frame = Arc::new(camera.unwrap());
        let view = View::new("v", image, frame, Isometry3::identity(), Some(noise)).unwrap();
        CoarseView::new(&view)
    }

    #[test]
    fn cells_across_a_step_have_facets_of_both_sides() {
        let view = step(1e-4);
        let samples = view.facets().samples(usize::MAX);
        assert!(!samples.is_empty());
        for (cell, point, normal, sigma) in samples {
            assert_eq!(view.cell_of(&point), Some(cell));
            assert!(view.patches().all(|(k, _)| k != cell), "cell {cell} has a patch");
            assert!((normal + Vector3::z()).norm() < 1e-6, "{normal}");
            assert!([2.0, 2.1].iter().any(|depth| (point.z - depth).abs() < 1e-6), "{point}");
            assert!((0.9e-4..=1e-4).contains(&sigma), "{sigma}");
            let lifted = point - Vector3::z() * 0.01;
            let met = view.facets().meeting(cell, &lifted, &normal).unwrap();
            assert!((met.distance - 0.01).abs() < 1e-6, "{}", met.distance);
        }
    }

    #[test]
    fn a_point_beside_the_last_facet_lies_over_none() {
        let view = step(1e-4);
        let samples = view.facets().samples(usize::MAX);
        let near = samples.iter().filter(|(_, point, ..)| point.z < 2.05);
        let (cell, last, normal, _) = near.max_by(|a, b| a.1.x.total_cmp(&b.1.x)).unwrap();
        let met = |beside: f64| {
            let point = last + Vector3::x() * beside;
            view.facets().meeting(*cell, &point, normal).is_some()
        };
        assert!(met(0.004) && !met(0.009));
        let turned = Vector3::new(1.0, 0.0, -1.0).normalize();
        assert!(view.facets().meeting(*cell, last, &turned).is_none(), "a turned normal");
    }

    #[test]
    fn noise_of_the_size_of_the_spacing_has_no_facets() {
        assert!(!step(0.008).facets().samples(usize::MAX).is_empty());
        assert!(step(0.010).facets().samples(usize::MAX).is_empty());
    }

    #[test]
    fn the_first_samples_are_of_all_directions() {
        let at = |k: usize| Vector3::new(k as f64, 0.0, 0.0);
        let mut facets = Facets::default();
        for k in 0..100 {
            let normal = if k % 20 == 7 { [1.0, 0.0, 0.0] } else { [0.0, 0.0, -1.0] };
            at(k).iter().zip(&mut facets.at).for_each(|(c, all)| all.push(*c as f32));
            facets.facets.push(Facet { normal, spacing: 1.0, sigma: 0.1 });
        }
        facets.first = vec![0, 60, 60, 100];
        let samples = facets.samples(10);
        assert_eq!(samples.iter().filter(|(_, _, normal, _)| normal.x > 0.9).count(), 5);
        for (cell, point, ..) in samples {
            assert_eq!(cell, if point.x < 60.0 { 0 } else { 2 });
        }
    }
}
