//! A real image beside its simulation (6.4): the noise on flat patches.
//!
//! 1. Windows of a real image that are flat are fitted by planes. The residuals along the rays are
//!    the measured noise.
//! 2. The planes are seen once more by the same sensor, with its noise model, and fitted again.
//! 3. Both go through the same windows and the same test for flatness, so they share its bias.

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::statistics::{median, quantile};
use crate::table::{cells, digits, say};
use nalgebra::{Matrix3, Rotation3, SMatrix, SVector, SymmetricEigen, UnitQuaternion};
use transect_device::{Pixel, View};
use transect_geometry::{Isometry3, Point3, Vector3};
use transect_scene::{Noise, PoseNoise, Scene, Shape, Solid};

/// Rows and columns of a window. Chosen by hand: enough pixels for a spread within 5 %. Doubled,
/// few windows of a cluttered room are flat.
const SIDE: usize = 24;

/// Least share of a window's pixels that are valid.
const LEAST_VALID: f64 = 0.75;

/// Largest share of a flat window's spread that bending explains. Chosen by hand: noise alone
/// gives 0.01 to 0.05. Doubled, bent surfaces count as noise.
const LARGEST_BEND: f64 = 0.1;

/// Largest angle between ray and normal, in degrees: beyond, errors across the rays show.
const LARGEST_INCIDENCE: f64 = 50.0;

/// Limits of the classes of ranges, in metres.
const RANGES: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 3.0, 8.0];

/// Fewer patches than these say nothing of a class.
const ENOUGH: usize = 8;

/// A window with the plane that fits it, in the sensor's frame.
#[derive(Debug, Clone)]
struct Patch {
    corner: Pixel,
    centre: Point3,
    normal: Vector3,
    /// Largest distance of its points from the centre.
    radius: f64,
    /// Standard deviation of the residuals along the rays.
    spread: f64,
    /// Correlation of residuals of neighbours in a row.
    correlation: f64,
}

/// A patch as measured and as simulated.
type Pair = (Patch, Patch);

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let views = trial::red_kitchen(lab.scans()?)?.views;
    let noise = camera_noise()?;
    let mut pairs: Vec<Pair> = Vec::new();
    for view in &views {
        pairs.extend(both(view, &noise)?);
    }
    let heads = "range, m | patches | measured, mm: quarter | half | simulated, mm: quarter | half | neighbours measured | simulated";
    let lines: Vec<_> = RANGES.windows(2).filter_map(|limits| line(&pairs, limits)).collect();
    lab.table("table", heads, lines)?;
    say(
        "Spread along the rays on flat patches: that of the flattest quarter and of half of them; \
         correlation of neighbours in a row.",
    );
    Ok(())
}

/// The noise of the bundled kitchen's depth camera, without errors that a patch does not show.
fn camera_noise() -> Result<Noise, Failure> {
    let mut noise = trial::bundled("kitchen")?.description.noise;
    (noise.dropout, noise.mixed, noise.full_return) = (0.0, 0.0, 0.0);
    noise.pose = PoseNoise::default();
    Ok(noise)
}

/// The table's line of a class of ranges; `None` with too few patches.
fn line(pairs: &[Pair], limits: &[f64]) -> Option<Vec<String>> {
    let within = |p: &&Pair| (limits[0]..limits[1]).contains(&p.0.centre.coords.norm());
    let class: Vec<&Pair> = pairs.iter().filter(within).collect();
    let spread = |share: f64, of: fn(&Pair) -> f64| {
        digits(1e3 * quantile(class.iter().map(|p| of(p)).collect(), share))
    };
    let correlation = |of: fn(&Pair) -> f64| {
        format!("{:.2}", median(&class.iter().map(|p| of(p)).collect::<Vec<_>>()))
    };
    let (measured, simulated) = (|p: &Pair| p.0.spread, |p: &Pair| p.1.spread);
    (class.len() >= ENOUGH).then(|| {
        let spreads = [spread(0.25, measured), spread(0.5, measured)];
        let simulated = [spread(0.25, simulated), spread(0.5, simulated)];
        let correlations = [correlation(|p| p.0.correlation), correlation(|p| p.1.correlation)];
        let all = [spreads, simulated, correlations].concat().join(" | ");
        cells(&format!("{} to {} | {} | {all}", limits[0], limits[1], class.len()))
    })
}

/// The flat patches of a view, and the same patches of its simulation.
fn both(view: &View, noise: &Noise) -> Result<Vec<Pair>, Failure> {
    let size = view.image().size();
    let corners = (0..size.rows / SIDE)
        .flat_map(|r| (0..size.cols / SIDE).map(move |c| Pixel::new(r * SIDE, c * SIDE)));
    let measured: Vec<Patch> = corners.filter_map(|corner| patch(view, corner)).collect();
    if measured.is_empty() {
        return Ok(Vec::new());
    }
    let solids: Result<Vec<Solid>, Failure> = measured.iter().map(plate).collect();
    let simulated = Scene::new(solids?).view(
        view.name(),
        view.shared_frame(),
        Isometry3::identity(),
        noise,
        0,
    )?;
    let again = |real: Patch| patch(&simulated, real.corner).map(|again| (real, again));
    Ok(measured.into_iter().filter_map(again).collect())
}

/// A thin plate whose front is the patch.
fn plate(patch: &Patch) -> Result<Solid, Failure> {
    let thickness = 0.1 * patch.radius;
    let side = 2.0 * patch.radius;
    let away = -patch.normal;
    let across = if away.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::face_towards(&away, &across));
    let middle = patch.centre + away * (0.5 * thickness);
    let pose = Isometry3::from_parts(middle.coords.into(), rotation);
    Ok(Solid::new(Shape::cuboid(Vector3::new(side, side, thickness))?, pose)?)
}

/// The plane that fits a window; `None` where it is bent or too oblique, or many pixels are
/// missing.
fn patch(view: &View, corner: Pixel) -> Option<Patch> {
    let pixels = (0..SIDE * SIDE).map(|k| Pixel::new(corner.row + k / SIDE, corner.col + k % SIDE));
    let sampled: Vec<Option<Point3>> = pixels.clone().map(|p| view.point_in_sensor(p)).collect();
    let points: Vec<Point3> = sampled.iter().flatten().copied().collect();
    let count = points.len() as f64;
    if count < LEAST_VALID * (SIDE * SIDE) as f64 {
        return None;
    }
    let centre = Point3::from(points.iter().map(|p| p.coords).sum::<Vector3>() / count);
    let products = points.iter().map(|p| (p - centre) * (p - centre).transpose());
    let eigen = SymmetricEigen::new(products.sum::<Matrix3<f64>>());
    let normal: Vector3 = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into_owned();
    // Towards the sensor.
    let normal = if normal.dot(&centre.coords) > 0.0 { -normal } else { normal };
    let least = LARGEST_INCIDENCE.to_radians().cos();
    let residual = |(pixel, point): (Pixel, &Option<Point3>)| -> Option<f64> {
        let off = normal.dot(&((*point)? - centre));
        let along = -normal.dot(&view.frame().ray(pixel)?.direction.normalize());
        (along > least).then(|| -off / along)
    };
    let residuals: Vec<Option<f64>> = pixels.zip(&sampled).map(residual).collect();
    let known = || residuals.iter().flatten();
    let square: f64 = known().map(|e| e * e).sum();
    if (known().count() as f64) < count || bend(&residuals) > LARGEST_BEND * square {
        return None;
    }
    let pairs = residuals.chunks(SIDE).flat_map(|row| row.windows(2));
    let products: Vec<f64> = pairs.filter_map(|e| Some(e[0]? * e[1]?)).collect();
    let covariance = products.iter().sum::<f64>() / products.len() as f64;
    let radius = points.iter().map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let variance = square / (count - 3.0);
    let (spread, correlation) = (variance.sqrt(), covariance / variance);
    Some(Patch { corner, centre, normal, radius, spread, correlation })
}

/// The part of the sum of squares that a surface of second order explains.
fn bend(residuals: &[Option<f64>]) -> f64 {
    let place = |k: usize| 2.0 * k as f64 / (SIDE - 1) as f64 - 1.0;
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    let mut right = SVector::<f64, 6>::zeros();
    for (k, residual) in residuals.iter().enumerate() {
        let Some(residual) = residual else { continue };
        let (u, v) = (place(k % SIDE), place(k / SIDE));
        let terms = SVector::<f64, 6>::from([1.0, u, v, u * u, u * v, v * v]);
        normal += terms * terms.transpose();
        right += terms * *residual;
    }
    normal.cholesky().map_or(0.0, |c| c.solve(&right).dot(&right))
}
