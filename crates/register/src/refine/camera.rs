//! The error that a depth camera makes alike in all its images, found together with the poses.
//!
//! **Problem.** Uncalibrated depth cameras err by several millimetres per metre, alike in every
//! image. Poses alone can only bend to that error; surfaces stay doubled.
//!
//! **Idea.** Two views see a surface through different parts of the image, so their contradictions
//! show the error (Zhou and Koltun, 2014). A camera that measures disparities errs by an offset
//! of 1 / depth at each pixel. Offsets on a grid over the image are unknowns beside the motions
//! ([`DepthOffsets`]).
//!
//! A wrong clock, or a wrong baseline, errs by a factor on all depths. Poses can hide it: they move
//! apart, as if the scene were larger. How far they may be wrong tells whether they do.
//!
//! Wrong focal lengths make every image too wide or too narrow. Offsets and a scale bend to that,
//! and poses with them, so they are looked for at the same time.
//!
//! **Steps.**
//! 1. Views with the same rays share a camera.
//! 2. The poses settle first. Then samples and patches are looked up with the offsets known so
//!    far.
//! 3. The offsets have a prior: `step` holds neighbouring nodes together. It follows from the
//!    evidence (MacKay, 1992), so the offsets of a sound camera vanish. Their mean, the level, is
//!    one number, which evidence of that kind fits to itself. So its prior does not follow from the
//!    level. It is that of the first guess, and narrower only where the other offsets vanish.
//! 4. After the rounds, level, scale and focal lengths are tested: `wrong_cameras.rs`.

use super::odds::{Odds, odds};
use crate::CoarseView;
use crate::tuning::{CAMERA_GRID, CAMERA_SIGMAS, EXACT, FIRST_CAMERA_ERROR, LEVEL_OVER_OTHERS};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::sync::Arc;
use transect_device::{DepthOffsets, ImageSize, Nodes, Point3};

const ROWS: usize = CAMERA_GRID.0;
const COLS: usize = CAMERA_GRID.1;
/// Precisions of the relative change of 1 / depth and of the relative errors of the focal lengths:
/// of a camera that may err in them, and of a right one.
const FREE_SCALE: f64 = 1.0 / (FIRST_CAMERA_ERROR * FIRST_CAMERA_ERROR);
const SOUND_SCALE: f64 = FREE_SCALE / (EXACT * EXACT);
/// Nodes of the grid of one camera.
const NODES: usize = ROWS * COLS;
/// Unknowns of one camera: the offsets at its nodes, the relative change of 1 / depth, and by how
/// much `fx` and `fy` are too large.
pub const UNKNOWNS: usize = NODES + 3;
/// The places of the last two.
const FOCAL: [usize; 2] = [NODES + 1, NODES + 2];

/// A depth camera with several views.
#[derive(Debug, Clone)]
pub struct Camera {
    /// The offsets at the nodes, in 1 / length, the relative change of 1 / depth, and the relative
    /// errors of the focal lengths.
    pub errors: DVector<f64>,
    /// Precision of the level of the offsets, which is their mean, and of the steps between
    /// neighbouring nodes.
    level: f64,
    step: f64,
    /// Prior standard deviation of the level, over that of the offsets about their level.
    level_over_others: f64,
    /// Precision of the relative change, and of the errors of the focal lengths.
    scale: f64,
    focal: f64,
    /// The precision that offsets have at first, and the one above which they are none.
    first: f64,
    sound: f64,
}

/// Parts of a camera that become unknowns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Freed {
    Scale,
    ScaleAndFocal,
}

/// The errors of a camera at a cell.
struct CellErrors {
    /// The relative change of 1 / depth, and what is added to it.
    change: f64,
    offset: f64,
    /// By how much `fx` and `fy` are too large.
    focal: [f64; 2],
}

/// The cameras of all views.
#[derive(Debug, Clone)]
pub struct Cameras {
    pub list: Vec<Camera>,
    /// The number of each view's camera.
    of_view: Vec<Option<usize>>,
    /// For each camera, the nodes around every cell of its images.
    around: Arc<Vec<Vec<Nodes>>>,
}

impl Cameras {
    /// The cameras of views, as they are before anything is known of them. `distance` is a typical
    /// one of their samples.
    pub fn of(views: &[&CoarseView], distance: f64) -> Self {
        let keys: Vec<_> =
            views.iter().map(|v| v.camera().map(|rays| (rays, v.image_size()))).collect();
        let mut shared = Vec::new();
        for (k, key) in keys.iter().enumerate().filter(|(_, key)| key.is_some()) {
            let others = keys.iter().enumerate().filter(|(j, other)| *j != k && *other == key);
            if others.count() > 0 && !shared.contains(key) {
                shared.push(*key);
            }
        }
        let number = |key: &Option<_>| shared.iter().position(|shared| shared == key);
        let of_view: Vec<Option<usize>> = keys.iter().map(number).collect();
        let sizes = (0..shared.len()).map(|camera| {
            let view = of_view.iter().position(|of_view| *of_view == Some(camera));
            view.and_then(|k| views.get(k)).map(|view| view.size())
        });
        let around =
            sizes.enumerate().map(|(k, size)| size.map_or_else(Vec::new, |s| around(k, s)));
        let around = Arc::new(around.collect());
        let first = (distance / FIRST_CAMERA_ERROR).powi(2);
        let errors = DVector::zeros(UNKNOWNS);
        let sound = first / EXACT.powi(2);
        let (scale, focal) = (SOUND_SCALE, SOUND_SCALE);
        let (level, step, level_over_others) = (sound, sound, LEVEL_OVER_OTHERS);
        let camera = Camera { errors, level, step, level_over_others, scale, focal, first, sound };
        Self { of_view, around, list: vec![camera; shared.len()] }
    }

    /// The cameras as if they did not err.
    pub fn without_errors(&self) -> Self {
        let mut sound = self.clone();
        for camera in &mut sound.list {
            camera.errors = DVector::zeros(UNKNOWNS);
            (camera.level, camera.step) = (camera.sound, camera.sound);
            (camera.scale, camera.focal) = (SOUND_SCALE, SOUND_SCALE);
        }
        sound
    }

    /// The cameras, without offsets that move a point at this distance by less than `least` (root
    /// mean square).
    pub fn with_errors_from(&self, least: f64, distance: f64) -> Self {
        let (mut cameras, sound) = (self.clone(), self.without_errors());
        for (camera, sound) in cameras.list.iter_mut().zip(sound.list) {
            let square = camera.errors.rows(0, NODES).norm_squared() / NODES as f64;
            if !camera.scale_is_free() && square.sqrt() * distance * distance < least {
                *camera = sound;
            }
        }
        cameras
    }

    /// The number of unknowns.
    pub fn unknowns(&self) -> usize {
        UNKNOWNS * self.list.len()
    }

    /// The nodes around a cell of a view, numbered over all cameras; `None` for other sensors.
    pub fn nodes(&self, view: usize, cell: usize) -> Option<Nodes> {
        self.around.get((*self.of_view.get(view)?)?)?.get(cell).copied()
    }

    /// The number of the first unknown of a camera, from the nodes around one of its cells.
    fn first_of(nodes: &Nodes) -> usize {
        nodes[0].0 / UNKNOWNS * UNKNOWNS
    }

    /// The number of the relative change of a camera if its scale is free.
    pub fn free_scale(&self, nodes: &Nodes) -> Option<usize> {
        let first = Self::first_of(nodes);
        self.list.get(first / UNKNOWNS).filter(|c| c.scale_is_free()).map(|_| first + NODES)
    }

    /// The numbers of the errors of its focal lengths if they are free.
    pub fn free_focal(&self, nodes: &Nodes) -> Option<[usize; 2]> {
        let first = Self::first_of(nodes);
        let camera = self.list.get(first / UNKNOWNS).filter(|c| c.focal_is_free());
        camera.map(|_| FOCAL.map(|at| first + at))
    }

    /// A point of a view without the errors of its camera.
    pub fn corrected(&self, nodes: &Nodes, p: &Point3) -> Point3 {
        let CellErrors { change, offset, focal: [x, y] } = self.errors(nodes);
        let sound = p.coords / (1.0 + change + offset * p.z);
        Point3::new(sound.x * (1.0 + x), sound.y * (1.0 + y), sound.z)
    }

    /// A point where the camera of a view sees it, at its true depth.
    pub fn projected(&self, view: usize, p: &Point3) -> Point3 {
        let camera = self.of_view.get(view).copied().flatten().and_then(|k| self.list.get(k));
        match camera.map(|camera| FOCAL.map(|at| camera.errors[at])) {
            // No focal length is free in nearly all rounds.
            None | Some([0.0, 0.0]) => *p,
            Some([x, y]) => Point3::new(p.x / (1.0 + x), p.y / (1.0 + y), p.z),
        }
    }

    /// A [`Cameras::projected`] point at the depth that the camera would measure.
    pub fn measured(&self, nodes: &Nodes, p: &Point3) -> Point3 {
        let CellErrors { change, offset, .. } = self.errors(nodes);
        Point3::from(p.coords * ((1.0 + change) / (1.0 - offset * p.z)))
    }

    fn errors(&self, nodes: &Nodes) -> CellErrors {
        let at = |unknown: usize| {
            let camera = self.list.get(unknown / UNKNOWNS);
            camera.and_then(|c| c.errors.get(unknown % UNKNOWNS)).copied().unwrap_or(0.0)
        };
        let first = Self::first_of(nodes);
        CellErrors {
            change: at(first + NODES),
            offset: nodes.iter().map(|(node, weight)| at(*node) * weight).sum(),
            focal: FOCAL.map(|focal| at(first + focal)),
        }
    }

    /// Lets the cameras err, after the poses have settled.
    pub fn release(&mut self) {
        for camera in &mut self.list {
            (camera.level, camera.step) = (camera.first, camera.first);
        }
    }

    /// Narrows the prior of the levels of those cameras that are chosen by number. Levels are then
    /// as large as the other offsets. The prior is narrower still by [`CAMERA_SIGMAS`], as what
    /// images tell is less certain than stated by that factor.
    pub fn hold_levels(&mut self, is_held: impl Fn(usize) -> bool) {
        for (_, camera) in self.list.iter_mut().enumerate().filter(|(k, _)| is_held(*k)) {
            camera.level_over_others = CAMERA_SIGMAS.recip();
            camera.level = camera.level_beside(&camera.errors);
        }
    }

    /// The same cameras, with free parts of those that are chosen by number.
    pub fn freed(&self, parts: Freed, is_free: impl Fn(usize) -> bool) -> Self {
        let mut cameras = self.clone();
        for (_, camera) in cameras.list.iter_mut().enumerate().filter(|(k, _)| is_free(*k)) {
            camera.scale = FREE_SCALE;
            if parts == Freed::ScaleAndFocal {
                camera.focal = FREE_SCALE;
            }
        }
        cameras
    }

    /// `fx` and `fy` of a camera over the true ones.
    pub fn focal_over_true(&self, camera: usize) -> Option<[f64; 2]> {
        self.list.get(camera).map(|camera| FOCAL.map(|at| 1.0 + camera.errors[at]))
    }

    /// The odds that the free parts of each camera are wrong, from the changes of all unknowns and
    /// their [`Solution::root`](super::solve::Solution::root): the probability of the right scale
    /// before the images are seen over that after it (Dickey, 1971). `sigmas` is how many times as
    /// large as stated the standard deviations of levels and focal lengths are taken.
    pub fn odds(&self, changes: &DVector<f64>, root: &DMatrix<f64>, sigmas: f64) -> Vec<Odds> {
        let first = changes.len() - self.unknowns();
        let of_camera = |(k, camera): (usize, &Camera)| {
            let at = first + UNKNOWNS * k;
            let errors = &camera.errors + changes.rows(at, UNKNOWNS);
            let root = root.columns(at, UNKNOWNS);
            let of_scale = |part: usize, sigmas: f64| {
                odds(errors[part], root.column(part).norm_squared(), FREE_SCALE, sigmas)
            };
            let (mean, root_of_mean) =
                (errors.rows(0, NODES).mean(), root.columns(0, NODES).column_mean());
            let [x, y] = FOCAL.map(|part| of_scale(part, sigmas));
            Odds {
                level: odds(mean, root_of_mean.norm_squared(), camera.level, sigmas),
                scale: of_scale(NODES, 1.0),
                focal: x.max(y),
            }
        };
        self.list.iter().enumerate().map(of_camera).collect()
    }

    /// The changes of free scales and focal lengths, in their standard deviations.
    pub fn steps(&self, changes: &DVector<f64>, root: &DMatrix<f64>) -> impl Iterator<Item = f64> {
        let first = changes.len() - self.unknowns();
        let free = self.list.iter().enumerate().flat_map(move |(k, camera)| {
            let scale = camera.scale_is_free().then_some(NODES);
            let focal = camera.focal_is_free().then_some(FOCAL).into_iter().flatten();
            scale.into_iter().chain(focal).map(move |part| first + UNKNOWNS * k + part)
        });
        free.map(|at| changes[at].abs() / root.column(at).norm())
    }

    /// The relative changes of 1 / depth and the relative errors of `fx` and `fy`, of all cameras.
    pub fn scales(&self) -> DVector<f64> {
        let all = self.list.iter().flat_map(|camera| camera.errors.iter().skip(NODES).copied());
        DVector::from_iterator(self.list.len() * (UNKNOWNS - NODES), all)
    }

    /// Adds the changes of a round.
    pub fn change(&mut self, changes: &DVectorView<'_, f64>) {
        for (k, camera) in self.list.iter_mut().enumerate() {
            camera.errors += changes.rows(UNKNOWNS * k, UNKNOWNS);
        }
    }

    /// Learns how large the offsets are, from the changes of all unknowns and the
    /// [`Solution::root`](super::solve::Solution::root); the offsets are the last unknowns.
    pub fn learn(&mut self, changes: &DVector<f64>, root: &DMatrix<f64>) {
        let first = changes.len() - self.unknowns();
        for (k, camera) in self.list.iter_mut().enumerate() {
            let at = first + UNKNOWNS * k;
            let errors = &camera.errors + changes.rows(at, UNKNOWNS);
            let columns = root.view((at, at), (changes.len() - at, UNKNOWNS));
            camera.learn(&errors, &columns.tr_mul(&columns));
        }
    }

    /// The offsets of a view's camera that the images tell from zero; `None` for a sound camera.
    pub fn of_view(&self, view: usize) -> Option<DepthOffsets> {
        let camera = (*self.of_view.get(view)?)?;
        let errs = |c: &&Camera| c.step < c.sound || c.level < c.sound || c.scale_is_free();
        let camera = self.list.get(camera).filter(errs)?;
        let values = camera.errors.iter().copied().take(NODES).collect();
        let offsets = DepthOffsets::new(ROWS, COLS, values).ok()?;
        if camera.scale_is_free() {
            return offsets.after_scale(1.0 / (1.0 + camera.errors[NODES])).ok();
        }
        Some(offsets)
    }
}

/// The nodes around every cell of the images of a camera, numbered over all cameras.
fn around(camera: usize, size: ImageSize) -> Vec<Nodes> {
    let share = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let of_cell = |cell: usize| {
        let (row, col) = (share(cell / size.cols, size.rows), share(cell % size.cols, size.cols));
        let nodes = DepthOffsets::nodes(ROWS, COLS, row, col);
        nodes.map(|(node, weight)| (camera * UNKNOWNS + node, weight))
    };
    (0..size.pixels()).map(of_cell).collect()
}

impl Camera {
    fn scale_is_free(&self) -> bool {
        self.scale < SOUND_SCALE
    }

    fn focal_is_free(&self) -> bool {
        self.focal < SOUND_SCALE
    }

    /// The precision of the errors before anything is seen.
    pub fn precision(&self) -> DMatrix<f64> {
        let mut precision = DMatrix::zeros(UNKNOWNS, UNKNOWNS);
        precision.view_mut((0, 0), (NODES, NODES)).copy_from(&self.of_offsets());
        precision[(NODES, NODES)] = self.scale;
        FOCAL.into_iter().for_each(|at| precision[(at, at)] = self.focal);
        precision
    }

    fn of_offsets(&self) -> DMatrix<f64> {
        let of_level = DMatrix::repeat(NODES, NODES, self.level / (NODES * NODES) as f64);
        steps() * self.step + of_level
    }

    /// The larger the steps of offsets, for what is known of them, the weaker the prior.
    fn learn(&mut self, errors: &DVector<f64>, covariance: &DMatrix<f64>) {
        let Some(prior) = self.of_offsets().cholesky().map(|c| c.inverse()) else { return };
        let (steps, spare) = (steps(), prior - covariance.view((0, 0), (NODES, NODES)));
        let offsets = errors.rows(0, NODES);
        let square = offsets.dot(&(&steps * offsets));
        // Half an error at least, so that errors that explain nothing vanish step by step.
        let known = (spare * steps).trace().max(0.5 / self.step);
        self.step = (self.step * (known / square).clamp(1e-3, 1e3)).min(self.sound);
        self.level = self.level_beside(errors);
    }

    /// The precision of the level beside these errors.
    fn level_beside(&self, errors: &DVector<f64>) -> f64 {
        let variance = self.level_over_others.powi(2) * errors.rows(0, NODES).variance();
        variance.recip().clamp(self.first, self.sound)
    }
}

/// The matrix of the sum of squared steps between neighbouring nodes.
fn steps() -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(NODES, NODES);
    for node in 0..NODES {
        let right = (node % COLS + 1 < COLS).then_some(node + 1);
        let below = (node + COLS < NODES).then_some(node + COLS);
        for next in right.into_iter().chain(below) {
            for (i, j, v) in
                [(node, node, 1.0), (next, next, 1.0), (node, next, -1.0), (next, node, -1.0)]
            {
                matrix[(i, j)] += v;
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(errors: DVector<f64>, (scale, focal): (f64, f64)) -> Camera {
        let (level, step, level_over_others, first, sound) = (1.0, 1.0, 1.0, 1.0, 2.0);
        Camera { errors, level, step, level_over_others, scale, focal, first, sound }
    }

    #[test]
    fn what_a_camera_measures_is_corrected_to_what_was_there() {
        let errors =
            DVector::from_fn(UNKNOWNS, |k, _| if k < NODES { 1e-3 * k as f64 } else { 0.02 });
        let camera = camera(errors, (1.0, 1.0));
        let cameras =
            Cameras { list: vec![camera], of_view: vec![Some(0)], around: Arc::new(Vec::new()) };
        let p = Point3::new(0.4, -0.7, 2.5);
        for nodes in around(0, ImageSize { rows: 5, cols: 7 }) {
            let measured = cameras.measured(&nodes, &cameras.projected(0, &p));
            assert!((measured - p).norm() > 0.01);
            assert!((cameras.corrected(&nodes, &measured) - p).norm() < 1e-12);
        }
    }

    #[test]
    fn a_level_vanishes_with_the_other_offsets_alone() {
        let of = |level: f64, others: f64, over_others: f64| {
            let sign = |k: usize| [1.0, -1.0][k % 2];
            let errors = DVector::from_fn(UNKNOWNS, |k, _| level + others * sign(k));
            let bounds = Camera { sound: 1e6, ..camera(errors.clone(), (1.0, 1.0)) };
            Camera { level_over_others: over_others, ..bounds }.level_beside(&errors)
        };
        for level in [0.0, 0.1, 10.0] {
            assert_eq!(of(level, 0.0, 30.0), 1e6, "no other offset, a level of {level}");
            assert_eq!(of(level, 1.0, 30.0), 1.0, "as wide as at first");
            let found = of(level, 0.01, 30.0);
            assert!((found * 0.09 - 1.0).abs() < 0.01, "30 times 0.01: {found}");
            let held = of(level, 0.01, 0.5);
            assert!((held * 2.5e-5 - 1.0).abs() < 0.01, "half of 0.01: {held}");
        }
    }

    #[test]
    fn offsets_that_move_points_by_next_to_nothing_are_none() {
        let errors = DVector::from_fn(UNKNOWNS, |k, _| if k < NODES { 1e-3 } else { 0.0 });
        let list = [SOUND_SCALE, FREE_SCALE].map(|scale| camera(errors.clone(), (scale, 1.0)));
        let list = list.to_vec();
        let cameras = Cameras { list, of_view: vec![], around: Arc::default() };
        // At a distance of 2 the offsets move a point by 4e-3.
        for (least, kept) in [(3.9e-3, [true, true]), (4.1e-3, [false, true])] {
            let left = cameras.with_errors_from(least, 2.0).list;
            assert_eq!([0, 1].map(|k| left[k].errors[0] != 0.0), kept, "{least}");
        }
    }

    /// A measured scale, right or wrong by a prior: its evidence for both, by a sum.
    #[test]
    fn odds_are_those_of_the_evidence() {
        let normal = |x: f64, sigma: f64| (-0.5 * (x / sigma).powi(2)).exp() / sigma;
        let prior = FREE_SCALE.powf(-0.5);
        for (measured, sigma) in [(0.001, 0.002), (0.006, 0.002), (0.012, 0.004)] {
            let step = 1e-5;
            let free = (-10_000..=10_000).map(|k| step * f64::from(k));
            let wrong = free.map(|s| normal(measured - s, sigma) * normal(s, prior)).sum::<f64>();
            // The first normal density is over both evidences; the second one lacks its factor.
            let expected = step * wrong / std::f64::consts::TAU.sqrt() / normal(measured, sigma);
            let variance = 1.0 / (FREE_SCALE + sigma.powi(-2));
            let errors = DVector::zeros(UNKNOWNS);
            let camera = camera(errors, (FREE_SCALE, 1.0));
            let cameras = Cameras { list: vec![camera], of_view: vec![], around: Arc::default() };
            let (mut changes, mut root) =
                (DVector::zeros(UNKNOWNS), DMatrix::identity(UNKNOWNS, UNKNOWNS));
            changes[NODES] = measured * variance / sigma.powi(2);
            root[(NODES, NODES)] = variance.sqrt();
            let odds = cameras.odds(&changes, &root, 1.0)[0].scale;
            assert!((odds / expected - 1.0).abs() < 1e-3, "{odds} {expected}");
        }
    }
}
