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
//! **Steps.**
//! 1. Views with the same rays share a camera.
//! 2. The poses settle first. Then samples and patches are looked up with the offsets known so
//!    far.
//! 3. The offsets have a prior: `own` holds them at zero, and `step` holds neighbouring nodes
//!    together. Both follow from the evidence (MacKay, 1992), so the offsets of a sound camera
//!    vanish.

use crate::CoarseView;
use crate::tuning::{CAMERA_GRID, EXACT, FIRST_CAMERA_ERROR};
use nalgebra::{DMatrix, DVector, DVectorView};
use std::sync::Arc;
use transect_device::{DepthOffsets, ImageSize, Nodes, Point3};

const ROWS: usize = CAMERA_GRID.0;
const COLS: usize = CAMERA_GRID.1;
/// Nodes of the grid of one camera.
pub const NODES: usize = ROWS * COLS;

/// A depth camera with several views.
#[derive(Debug, Clone)]
pub struct Camera {
    /// The offsets at the nodes, in 1 / length.
    pub offsets: DVector<f64>,
    /// Precision of each offset, and of the steps between neighbouring nodes.
    own: f64,
    step: f64,
    /// The precision that it has at first, and the one above which it is sound.
    first: f64,
    sound: f64,
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
        let offsets = DVector::zeros(NODES);
        let sound = first / EXACT.powi(2);
        let camera = Camera { offsets, own: sound, step: sound, first, sound };
        Self { of_view, around, list: vec![camera; shared.len()] }
    }

    /// The cameras as if they did not err.
    pub fn without_errors(&self) -> Self {
        let mut sound = self.clone();
        for camera in &mut sound.list {
            (camera.offsets, camera.own) = (DVector::zeros(NODES), camera.sound);
        }
        sound
    }

    /// The number of unknowns.
    pub fn unknowns(&self) -> usize {
        NODES * self.list.len()
    }

    /// The nodes around a cell of a view, numbered over all cameras; `None` for other sensors.
    pub fn nodes(&self, view: usize, cell: usize) -> Option<Nodes> {
        self.around.get((*self.of_view.get(view)?)?)?.get(cell).copied()
    }

    /// A point of a view without the error of its camera.
    pub fn corrected(&self, nodes: &Nodes, p: &Point3) -> Point3 {
        Point3::from(p.coords / (1.0 + self.offset(nodes) * p.z))
    }

    /// A point as the camera would measure it.
    pub fn measured(&self, nodes: &Nodes, p: &Point3) -> Point3 {
        Point3::from(p.coords / (1.0 - self.offset(nodes) * p.z))
    }

    fn offset(&self, nodes: &Nodes) -> f64 {
        let of = |(node, weight): &(usize, f64)| {
            Some(self.list.get(node / NODES)?.offsets.get(node % NODES)? * weight)
        };
        nodes.iter().filter_map(of).sum()
    }

    /// Lets the cameras err, after the poses have settled.
    pub fn release(&mut self) {
        for camera in &mut self.list {
            (camera.own, camera.step) = (camera.first, camera.first);
        }
    }

    /// Adds the changes of a round.
    pub fn change(&mut self, changes: &DVectorView<'_, f64>) {
        for (k, camera) in self.list.iter_mut().enumerate() {
            camera.offsets += changes.rows(NODES * k, NODES);
        }
    }

    /// Learns how large the offsets are, from the changes of all unknowns and the
    /// [`Solution::root`](super::solve::Solution::root); the offsets are the last unknowns.
    pub fn learn(&mut self, changes: &DVector<f64>, root: &DMatrix<f64>) {
        let first = changes.len() - self.unknowns();
        for (k, camera) in self.list.iter_mut().enumerate() {
            let at = first + NODES * k;
            let offsets = &camera.offsets + changes.rows(at, NODES);
            let columns = root.view((at, at), (changes.len() - at, NODES));
            camera.learn(&offsets, &columns.tr_mul(&columns));
        }
    }

    /// The offsets of a view's camera that the images tell from zero; `None` for a sound camera.
    pub fn of_view(&self, view: usize) -> Option<DepthOffsets> {
        let camera = (*self.of_view.get(view)?)?;
        let camera = self.list.get(camera).filter(|camera| camera.own < camera.sound)?;
        DepthOffsets::new(ROWS, COLS, camera.offsets.iter().copied().collect()).ok()
    }
}

/// The nodes around every cell of the images of a camera, numbered over all cameras.
fn around(camera: usize, size: ImageSize) -> Vec<Nodes> {
    let share = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let of_cell = |cell: usize| {
        let (row, col) = (share(cell / size.cols, size.rows), share(cell % size.cols, size.cols));
        let nodes = DepthOffsets::nodes(ROWS, COLS, row, col);
        nodes.map(|(node, weight)| (camera * NODES + node, weight))
    };
    (0..size.pixels()).map(of_cell).collect()
}

impl Camera {
    /// The precision of the offsets before anything is seen.
    pub fn precision(&self) -> DMatrix<f64> {
        DMatrix::identity(NODES, NODES) * self.own + steps() * self.step
    }

    /// The larger the offsets and their steps, for what is known of them, the weaker the prior.
    fn learn(&mut self, offsets: &DVector<f64>, covariance: &DMatrix<f64>) {
        let Some(prior) = self.precision().cholesky().map(|c| c.inverse()) else { return };
        let (steps, spare) = (steps(), prior - covariance);
        // Half an offset at least, so that offsets that explain nothing vanish step by step.
        let factor = |precision: f64, known: f64, square: f64| {
            precision * (known.max(0.5 / precision) / square).clamp(1e-3, 1e3)
        };
        let square_of_steps = offsets.dot(&(&steps * offsets));
        self.own = factor(self.own, spare.trace(), offsets.norm_squared()).min(self.sound);
        self.step = factor(self.step, (spare * steps).trace(), square_of_steps);
        self.step = self.step.min(self.sound);
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
