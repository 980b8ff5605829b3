//! The viewpoint of a rotating scanner, read from its grid of points.
//!
//! **Idea.** Such a scanner turns about an axis and takes one column at each step. A column lies in
//! a plane that holds the axis, and a row in a cone about it. All cones have their tip in the
//! viewpoint. Both families can be read off the points.
//!
//! **Steps.**
//! 1. The plane of each column: the eigenvector of its points' smallest variance. Columns whose
//!    points lie on a line determine none.
//! 2. The axis is across all normals, and its place is where the planes meet: least squares.
//! 3. On the cone of row `i`, `height − h = t_i · radius`, so `height / radius = h / radius + t_i`.
//!    The common `h` follows from the deviations from the mean of each row.
//!
//! Cost: two passes over the points.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use transect_device::{ImageSize, Point3, median};

/// Fewest points of a column or row that counts. Chosen by hand: fewer determine no plane. Doubled,
/// nothing changes but for very small grids.
const FEWEST_POINTS: usize = 8;
/// Least ratio of the second to the largest variance of a column's points. Theory: below, the
/// points lie on a line, which noise of 1/30 of its length turns. Doubled, rooms with low ceilings
/// lose columns.
const LEAST_WIDTH: f64 = 1e-3;
/// Least ratio of the second to the largest eigenvalue of the columns' normals: columns over 12°.
/// Theory: the uncertainty of the viewpoint grows with its inverse root, here to ten times that of
/// a full turn. Doubled, columns must cover 17°.
const LEAST_TURN: f64 = 1e-2;
/// Steps between rays that are this many times the median are uneven. Theory: a panorama of the
/// widest lens in use varies by 4. Doubled, viewpoints that are off by a metre pass.
const UNEVEN: f32 = 5.0;
/// Neighbours that are compared. Theory: a share of 0.2 % of so many is known to a tenth of it.
/// Doubled, the estimate takes twice the time.
const COMPARED: usize = 100_000;

/// The share of neighbouring points whose directions from a viewpoint differ by over five times the
/// median. From the true viewpoint of a scanner it is 0. From another place, range jumps and
/// slanted surfaces show; a room without jumps looks even from any place inside. 0 if there are no
/// neighbours.
pub fn uneven_rays(size: ImageSize, points: &[Point3], viewpoint: &Point3) -> f64 {
    let every = (size.pixels() / COMPARED).max(1);
    let (mut uneven, mut all) = (0, 0);
    for step in [1, size.cols] {
        let steps = angles(size, points, viewpoint, every, step);
        let Some(usual) = median(steps.iter().map(|angle| f64::from(*angle))) else { continue };
        let limit = UNEVEN * usual as f32;
        uneven += steps.iter().filter(|angle| **angle > limit).count();
        all += steps.len();
    }
    if all == 0 { 0.0 } else { uneven as f64 / all as f64 }
}

/// How much the steps between neighbouring rays from a viewpoint vary: the median deviation from
/// the median step, over it; down the columns or along the rows, whichever varies less. A rotating
/// scanner turns by equal steps, so from its true place that is near 0. Infinite without
/// neighbours.
pub fn step_variation(size: ImageSize, points: &[Point3], viewpoint: &Point3) -> f64 {
    let every = (size.pixels() / COMPARED).max(1);
    let variation = |step| {
        let steps = angles(size, points, viewpoint, every, step);
        let steps = || steps.iter().map(|angle| f64::from(*angle));
        let usual = median(steps())?;
        Some(median(steps().map(|step| (step - usual).abs()))? / usual)
    };
    [1, size.cols].into_iter().filter_map(variation).fold(f64::INFINITY, f64::min)
}

/// The chords between the directions of points that are `step` apart, in every so many rows.
fn angles(
    size: ImageSize,
    points: &[Point3],
    viewpoint: &Point3,
    every: usize,
    step: usize,
) -> Vec<f32> {
    let direction = |p: &Point3| (p - viewpoint).normalize();
    let starts = (0..points.len()).filter(|k| {
        let (row, col) = (k / size.cols, k % size.cols);
        row % every == 0 && (step > 1 || col + 1 < size.cols)
    });
    let pairs = starts.filter_map(|k| Some((points.get(k)?, points.get(k + step)?)));
    let chords = pairs.map(|(a, b)| (direction(a) - direction(b)).norm() as f32);
    chords.filter(|chord| chord.is_finite()).collect()
}

/// The viewpoint of a rotating scanner from row-major points; NaN where missing. `None` if the
/// points do not determine it.
pub fn fit_viewpoint(size: ImageSize, points: &[Point3]) -> Option<Point3> {
    // Coordinates may be large, so everything is measured from the points' middle.
    let (count, sum) = seen(points).fold((0, Vector3::zeros()), |(n, s), p| (n + 1, s + p.coords));
    let middle = sum / f64::from(count.max(1));
    let (mut normals, mut offsets) = (Matrix3::zeros(), Vector3::zeros());
    for col in 0..size.cols {
        let column = points.iter().skip(col).step_by(size.cols);
        let column: Vec<_> = seen(column).map(|p| p.coords - middle).collect();
        let Some((normal, offset)) = plane(&column) else { continue };
        normals += normal * normal.transpose();
        offsets += normal * offset;
    }
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(normals);
    let [first, second, third] = ascending(&eigenvalues);
    if eigenvalues[second] <= LEAST_TURN * eigenvalues[third] {
        return None;
    }
    let axis = eigenvectors.column(first).into_owned();
    let along = |k: usize| {
        let direction = eigenvectors.column(k).into_owned();
        direction * (direction.dot(&offsets) / eigenvalues[k])
    };
    let foot = along(second) + along(third);
    let height = tip(size, points, &(middle + foot), &axis)?;
    let viewpoint = Point3::from(middle + foot + axis * height);
    viewpoint.iter().all(|c| c.is_finite()).then_some(viewpoint)
}

fn seen<'a>(points: impl IntoIterator<Item = &'a Point3>) -> impl Iterator<Item = &'a Point3> {
    points.into_iter().filter(|p| p.coords.sum().is_finite())
}

/// The places of the least, the middle and the largest eigenvalue.
fn ascending(values: &Vector3<f64>) -> [usize; 3] {
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    order
}

/// The normal of a column's plane and its distance from the origin.
fn plane(column: &[Vector3<f64>]) -> Option<(Vector3<f64>, f64)> {
    if column.len() < FEWEST_POINTS {
        return None;
    }
    let mean = column.iter().sum::<Vector3<f64>>() / column.len() as f64;
    let spread: Matrix3<f64> = column.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
    let SymmetricEigen { eigenvectors, eigenvalues } = SymmetricEigen::new(spread);
    let [first, second, third] = ascending(&eigenvalues);
    let normal = eigenvectors.column(first).into_owned();
    let wide = eigenvalues[second] > LEAST_WIDTH * eigenvalues[third];
    wide.then(|| (normal, normal.dot(&mean)))
}

/// The height of the cones' tip over a foot on their axis.
fn tip(
    size: ImageSize,
    points: &[Point3],
    foot: &Vector3<f64>,
    axis: &Vector3<f64>,
) -> Option<f64> {
    let (mut products, mut squares) = (0.0, 0.0);
    for row in points.chunks(size.cols) {
        let place = |p: &Point3| {
            let from_foot = p.coords - foot;
            let height = axis.dot(&from_foot);
            let radius = (from_foot - axis * height).norm();
            (1.0 / radius, height / radius)
        };
        let row: Vec<(f64, f64)> = seen(row).map(place).filter(|(u, _)| u.is_finite()).collect();
        if row.len() < FEWEST_POINTS {
            continue;
        }
        let mean = |f: fn(&(f64, f64)) -> f64| row.iter().map(f).sum::<f64>() / row.len() as f64;
        let (u, v) = (mean(|r| r.0), mean(|r| r.1));
        products += row.iter().map(|r| (r.0 - u) * (r.1 - v)).sum::<f64>();
        squares += row.iter().map(|r| (r.0 - u).powi(2)).sum::<f64>();
    }
    (squares > 0.0).then(|| products / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize { rows: 60, cols: 90 };

    /// A box-shaped room with a pillar, as a scanner at `at` with a leaning axis sees it.
    fn room(at: &Point3) -> Vec<Point3> {
        let lean = nalgebra::Rotation3::from_euler_angles(0.1, -0.05, 0.3);
        let ray = |row: usize, col: usize| {
            let (theta, phi) = (0.07 * col as f64, -1.0 + 0.03 * row as f64);
            let (cos, z) = (phi.cos(), phi.sin());
            lean * Vector3::new(cos * theta.cos(), cos * theta.sin(), z)
        };
        let reach = |d: &Vector3<f64>| {
            let walls = Vector3::new(5.0, 4.0, 1.5).zip_map(d, |half, d| half / d.abs()).min();
            let pillar = d.normalize().dot(&Vector3::x()) > 0.95;
            if pillar { 0.6 * walls } else { walls }
        };
        let all = (0..SIZE.rows).flat_map(|row| (0..SIZE.cols).map(move |col| ray(row, col)));
        all.map(|d| at + d * reach(&d)).collect()
    }

    #[test]
    fn the_viewpoint_is_found_in_world_coordinates() {
        for at in [Point3::origin(), Point3::new(420_000.0, 5_300_000.0, 310.0)] {
            let mut points = room(&at);
            points[100..140].fill(Point3::new(f64::NAN, 0.0, 0.0));
            let found = fit_viewpoint(SIZE, &points).unwrap();
            assert!((found - at).norm() < 1e-6 * at.coords.norm().max(1.0), "{found}");
            assert!((found - at).norm() < 1e-3, "{found}");
        }
    }

    #[test]
    fn rays_are_even_from_the_viewpoint_alone() {
        let points = room(&Point3::origin());
        assert_eq!(uneven_rays(SIZE, &points, &Point3::origin()), 0.0);
        for other in [Point3::new(12.0, -7.0, 0.0), Point3::new(-300.0, 200.0, 0.0)] {
            let uneven = uneven_rays(SIZE, &points, &other);
            assert!(uneven > 0.002, "{other}: {uneven}");
        }
    }

    #[test]
    fn rays_turn_by_equal_steps_from_the_viewpoint_alone() {
        let points = room(&Point3::origin());
        assert!(step_variation(SIZE, &points, &Point3::origin()) < 1e-5);
        for other in [Point3::new(0.3, 0.2, 0.0), Point3::new(-300.0, 200.0, 0.0)] {
            let variation = step_variation(SIZE, &points, &other);
            assert!(variation > 0.02, "{other}: {variation}");
        }
    }

    #[test]
    fn points_on_one_wall_determine_no_viewpoint() {
        let wall = |k: usize| Point3::new(3.0, (k % 90) as f64, (k / 90) as f64);
        let points: Vec<Point3> = (0..SIZE.pixels()).map(wall).collect();
        assert_eq!(fit_viewpoint(SIZE, &points), None);
        let missing = vec![Point3::new(f64::NAN, 0.0, 0.0); SIZE.pixels()];
        let any = &Point3::origin();
        assert_eq!(fit_viewpoint(SIZE, &missing), None);
        assert_eq!(uneven_rays(SIZE, &missing, any), 0.0);
        assert_eq!(step_variation(SIZE, &missing, any), f64::INFINITY);
    }
}
