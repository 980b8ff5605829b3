//! A survey of a scan before it is modelled: what each view holds, and how much the views overlap.
//!
//! Every view is loaded, measured and dropped, so that memory does not grow with the scan. What is
//! kept of a view are a few thousand points.

use crate::plausible::{Look, looked_numbers};
use crate::samples::{Sample, coarse_samples, pixel_spacing, reach, samples};
use crate::{OpenScan, Plausibility, WorkflowError};
use rayon::prelude::*;
use std::collections::HashMap;
use transect::ReconstructError;
use transect_device::{ImageSize, Isometry3, Note, Pixel, Point3, Vector3, View, median};
use transect_exchange::ScanView;
use transect_image::estimate_sigma;

/// Side of the cells in which views meet, in distances between neighbouring samples. A sample looks
/// for others in its own cell and those around it, so 1 would suffice for a surface seen head-on;
/// 2 covers surfaces seen at 60°. Doubled, views that pass each other at a distance overlap.
const CELL: f64 = 2.0;

/// Smallest cosine between the mean ray of a camera and its optical axis, the sensor's z axis.
/// Chosen by hand: cameras look along it, turning scanners across it. Doubling has no meaning.
const ALONG_AXIS: f64 = 0.8;

/// The content of a view.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ViewSurvey {
    /// The view's name.
    pub name: String,
    /// The kind of its device frame.
    pub frame: &'static str,
    /// The way its sensor looks around.
    pub sensor: SensorClass,
    /// Rows and columns.
    pub size: ImageSize,
    /// Number of valid pixels.
    pub valid: usize,
    /// Nearest, median and farthest distance of a point from the start of its ray.
    pub range: [f64; 3],
    /// Median distances of neighbouring pixels: in the direction in which they are denser, and in
    /// the other one. `None` without three valid neighbours.
    pub spacing: Option<[f64; 2]>,
    /// Range noise: stated by the scan, otherwise estimated from the image.
    pub sigma: f64,
    /// Whether the scan states the noise.
    pub sigma_given: bool,
    /// Where all rays begin, in the world; the place of the pose if they have no common start.
    pub place: Point3,
    /// The mean direction of the rays with a point, in the world; its length is below 1 if they
    /// spread.
    pub sight: Vector3,
    /// Lowest and highest coordinates of the points in the world.
    pub corners: (Point3, Point3),
    /// Share of its sampled points beside which another view has a point, too. `None` for a single
    /// view.
    pub overlap: Option<f64>,
    /// The notes of its reader.
    pub notes: Vec<Note>,
    /// Why a run would refuse the view; `None` where it is plausible, or was not checked.
    pub refusal: Option<String>,
    /// What the checks of a whole scan compare; `None` where nothing was checked.
    pub(crate) look: Option<Look>,
    /// Whether its pose is the identity, as that of a view whose file states none.
    pub(crate) is_unposed: bool,
    /// Direction in the world that is up for the view.
    pub(crate) up: Vector3,
    /// Evenly thinned points and surface normals in the world.
    pub(crate) surface: Vec<(Point3, Vector3)>,
    /// Median distance between neighbouring points of `surface`.
    pub(crate) step: Option<f64>,
}

/// The way in which a sensor looks around.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensorClass {
    /// It turns about its z axis: terrestrial scanners and lidars.
    Turning,
    /// It looks along its z axis: cameras.
    Camera,
    /// It sees light that it sent from another place, or it is carried along: triangulation.
    Triangulation,
}

impl SensorClass {
    /// The words for it in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Turning => "turning",
            Self::Camera => "camera",
            Self::Triangulation => "triangulation",
        }
    }
}

impl OpenScan {
    /// Surveys the views of these numbers, side by side.
    ///
    /// # Errors
    /// For each view that cannot be read, a [`WorkflowError`] in its place.
    pub fn survey(&self, numbers: &[usize]) -> Vec<Result<ViewSurvey, WorkflowError>> {
        let views = numbers.par_iter().filter_map(|&number| self.scan().views.get(number));
        let mut surveyed: Vec<_> = views.map(|view| self.survey_view(view)).collect();
        overlap(&mut surveyed.iter_mut().flatten().collect::<Vec<_>>());
        surveyed
    }

    /// Surveys all views, side by side, with every check of a run. The second value is the reason
    /// for which a run would refuse the scan as a whole.
    ///
    /// # Errors
    /// For each view that cannot be read, a [`WorkflowError`] in its place.
    pub fn survey_all(&self) -> (Vec<Result<ViewSurvey, WorkflowError>>, Option<String>) {
        let scan = self.scan();
        let numbers: Vec<usize> = (0..scan.views.len()).collect();
        let mut surveyed = self.survey(&numbers);
        let mut checks = self.checks();
        let looks = looked_numbers(numbers.len()).into_iter();
        let looks = looks.filter_map(|k| surveyed.get(k)?.as_ref().ok()?.look.clone());
        let whole = checks.check_scan(scan, self.reading, &looks.collect::<Vec<_>>());
        for view in surveyed.iter_mut().flatten().filter(|view| view.refusal.is_none()) {
            view.refusal = checks.check_extent(view.spacing).err().map(|e| e.to_string());
        }
        (surveyed, whole.err().map(|e| e.to_string()))
    }

    /// The checks of a run that accepts nothing.
    fn checks(&self) -> Plausibility {
        let scan = self.scan();
        let mut checks = Plausibility::without_planes(scan.unit, &[]);
        checks.interval = scan.planes.as_ref().map_or(f64::INFINITY, |planes| planes.interval);
        checks
    }

    fn survey_view(&self, view: &ScanView) -> Result<ViewSurvey, WorkflowError> {
        let failed = |source| {
            let view = view.name().to_owned();
            WorkflowError::Reconstruct(ReconstructError::Load { view, source })
        };
        let (loaded, notes) = view.load().map_err(|e| failed(e.into()))?;
        let checks = self.checks();
        let whole = checks.check_valid_pixels(&loaded);
        let reach = reach(&loaded);
        let loaded = self.limits.apply(loaded).map_err(|e| failed(e.into()))?;
        let checked = whole.and_then(|()| checks.check_view(&loaded));
        let refusal = checked.err().map(|error| error.to_string());
        let look = Some(Look::of(&loaded, reach));
        Ok(ViewSurvey { refusal, look, ..ViewSurvey::of(&loaded, notes) })
    }
}

impl ViewSurvey {
    /// Measures a view.
    pub fn of(view: &View, notes: Vec<Note>) -> Self {
        let pose = view.world_from_sensor();
        let Sight { sensor, start, direction } = Sight::of(view);
        let coarse: Vec<_> = coarse_samples(view).collect();
        let place = |s: &Sample| {
            let normal = (pose * s.right).cross(&(pose * s.below)).try_normalize(0.0)?;
            Some((pose * s.point, normal))
        };
        let (range, corners) = extremes(view);
        Self {
            name: view.name().to_owned(),
            frame: view.frame().kind(),
            sensor,
            size: view.image().size(),
            valid: view.image().valid_count(),
            range,
            spacing: pixel_spacing(view),
            sigma: view.sigma().unwrap_or_else(|| estimate_sigma(view)),
            sigma_given: view.sigma().is_some(),
            place: pose * start,
            sight: pose * direction,
            corners,
            overlap: None,
            notes,
            refusal: None,
            look: None,
            is_unposed: *pose == Isometry3::identity(),
            up: pose * up(view, sensor),
            step: median(coarse.iter().map(|s| s.spacings()[1])),
            surface: coarse.iter().filter_map(place).collect(),
        }
    }
}

/// How a sensor looks, in its own frame.
struct Sight {
    sensor: SensorClass,
    /// The common start of its rays; the origin if they have none.
    start: Point3,
    /// Their mean direction.
    direction: Vector3,
}

impl Sight {
    fn of(view: &View) -> Self {
        let (mut sum, mut count, mut first) = (Vector3::zeros(), 0.0, None);
        let (mut moves, mut two_paths) = (false, false);
        for pixel in samples(view).map(|s| s.pixel) {
            let Some(ray) = view.frame().ray(pixel) else { continue };
            let start = *first.get_or_insert(ray.start);
            moves |= ray.start != start;
            two_paths |= view.frame().second_viewpoint(pixel).is_some();
            (sum, count) = (sum + ray.direction, count + 1.0);
        }
        let direction = if count > 0.0 { sum / count } else { Vector3::zeros() };
        let sensor = match () {
            () if moves || two_paths => SensorClass::Triangulation,
            () if direction.z.abs() > ALONG_AXIS => SensorClass::Camera,
            () => SensorClass::Turning,
        };
        let start = first.filter(|_| !moves).unwrap_or_else(Point3::origin);
        Self { sensor, start, direction }
    }
}

/// The sensor axis that is up in the image: z of a turning scanner, otherwise the axis along which
/// rows run. Rows of a camera run down. Those of a triangulation scanner have no common direction;
/// the positive axis is taken.
fn up(view: &View, sensor: SensorClass) -> Vector3 {
    if sensor == SensorClass::Turning {
        return Vector3::z();
    }
    let down: Vector3 = samples(view)
        .filter_map(|s| {
            let ray = view.frame().ray(s.pixel)?.direction;
            (s.below - ray * s.below.dot(&ray)).try_normalize(0.0)
        })
        .sum();
    let mut up = Vector3::zeros();
    let axis = down.iamax();
    up[axis] = if sensor == SensorClass::Camera { -down[axis].signum() } else { 1.0 };
    up
}

/// Nearest, median and farthest distance from the start of the ray, and the box in the world.
fn extremes(view: &View) -> ([f64; 3], (Point3, Point3)) {
    let distance = |pixel: Pixel, point: &Point3| {
        view.frame().ray(pixel).map_or(f64::NAN, |ray| (point - ray.start).norm())
    };
    let (mut ranges, mut corners) = (Vec::new(), None);
    for pixel in view.image().size().all_pixels() {
        let Some(point) = view.point_in_sensor(pixel) else { continue };
        ranges.push(distance(pixel, &point));
        let point = view.world_from_sensor() * point;
        let (low, high) = corners.unwrap_or((point, point));
        corners = Some((low.inf(&point), high.sup(&point)));
    }
    let near = ranges.iter().copied().fold(f64::INFINITY, f64::min);
    let far = ranges.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let middle = median(ranges);
    let corners = corners.unwrap_or((Point3::origin(), Point3::origin()));
    ([near, middle.unwrap_or(f64::NAN), far], corners)
}

/// States for each view the share of its points that others have, too.
fn overlap(views: &mut [&mut ViewSurvey]) {
    let side = CELL * median(views.iter().filter_map(|v| v.step)).unwrap_or(0.0);
    if views.len() < 2 || side <= 0.0 {
        return;
    }
    let cell_of = |p: &Point3| <[f64; 3]>::from(p.coords).map(|c| (c / side).floor() as i64);
    // The first view with a point in a cell, and whether another view has one, too.
    let mut cells: HashMap<[i64; 3], (usize, bool)> = HashMap::new();
    for (number, view) in views.iter().enumerate() {
        for (point, _) in &view.surface {
            let (first, shared) = cells.entry(cell_of(point)).or_insert((number, false));
            *shared |= *first != number;
        }
    }
    let beside = || (0..27).map(|k| [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1]);
    for (number, view) in views.iter_mut().enumerate() {
        let is_shared = |(point, _): &&(Point3, Vector3)| {
            let cell = cell_of(point);
            let mut near = beside().map(|d: [i64; 3]| [0, 1, 2].map(|k| cell[k] + d[k]));
            near.any(|c| cells.get(&c).is_some_and(|(first, shared)| *shared || *first != number))
        };
        let shared = view.surface.iter().filter(is_shared).count();
        view.overlap = Some(shared as f64 / view.surface.len().max(1) as f64);
    }
}

#[cfg(test)]
mod tests {
    use crate::{OpenScan, Settings};
    use std::sync::atomic::{AtomicUsize, Ordering};
    use std::sync::{Arc, Mutex, Weak};
    use transect::Unwatched;
    use transect_device::{ImageSize, Isometry3, RangeImage, View};
    use transect_exchange::{
        FramedImage, LoadView, OpenOptions, ReadError, ScanView, write_file, write_npy_image,
    };
    use transect_sensors::{Intrinsics, Pinhole};

    const SIZE: ImageSize = ImageSize { rows: 40, cols: 50 };
    const CAMERA: Intrinsics = Intrinsics { fx: 40.0, fy: 40.0, cx: 24.5, cy: 19.5 };

    /// Makes views of a wall and notes how many of them were in memory at the same time.
    #[derive(Debug, Default)]
    struct Wall {
        frames: Mutex<Vec<Weak<Pinhole>>>,
        most: AtomicUsize,
    }

    impl LoadView for Wall {
        fn load(&self, _: &mut Vec<String>) -> Result<FramedImage, ReadError> {
            let frame = Arc::new(Pinhole::new(SIZE, CAMERA).unwrap());
            let image = RangeImage::from_values(SIZE, vec![2.0; SIZE.pixels()]).unwrap();
            let mut frames = self.frames.lock().unwrap();
            frames.push(Arc::downgrade(&frame));
            let alive = frames.iter().filter(|frame| frame.strong_count() > 0).count();
            self.most.fetch_max(alive, Ordering::Relaxed);
            Ok(FramedImage { frame, image })
        }
    }

    /// A scan of 30 views of the wall.
    fn scan(folder: &std::path::Path, wall: &Arc<Wall>) -> OpenScan {
        let values = vec![2.0; SIZE.pixels()];
        let image = folder.join("a.npy");
        write_file(&image, |out| write_npy_image(SIZE, &values, out)).unwrap();
        let manifest = r#"{ "unit": "m", "views": [ { "file": "a.npy", "sensor": "pinhole",
            "fx": 40, "fy": 40, "cx": 24.5, "cy": 19.5,
            "pose": [1, 0, 0, 0,  0, 1, 0, 0,  0, 0, 1, 0,  0, 0, 0, 1] } ] }"#;
        std::fs::write(folder.join("scan.json"), manifest).unwrap();
        let mut scan = OpenScan::open(folder, &OpenOptions::default()).unwrap();
        let view = |k: usize| {
            let place = Isometry3::translation(0.01 * k as f64, 0.0, 0.0);
            ScanView::new(format!("view {k}"), image.clone(), place, wall.clone())
        };
        scan.scan.views = (0..30).map(view).collect();
        scan
    }

    #[test]
    fn an_image_of_one_row_has_a_median_distance() {
        let size = ImageSize { rows: 1, cols: 50 };
        let values = (0..50).map(|k| 2.0 + 0.01 * k as f32).collect();
        let image = RangeImage::from_values(size, values).unwrap();
        let frame = Arc::new(Pinhole::new(size, CAMERA).unwrap());
        let view = View::new("row", image, frame, Isometry3::identity(), None).unwrap();
        let ([near, middle, far], _) = super::extremes(&view);
        assert!(near < middle && middle < far, "{near}, {middle}, {far}");
    }

    #[test]
    fn each_thread_holds_one_view() {
        let folder = tempfile::tempdir().unwrap();
        let wall = Arc::new(Wall::default());
        let mut scan = scan(folder.path(), &wall);
        let two = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let numbers: Vec<usize> = (0..30).collect();
        let surveyed = two.install(|| scan.survey(&numbers));
        let most = || wall.most.swap(0, Ordering::Relaxed);
        assert_eq!(surveyed.len(), 30);
        assert!((1..=2).contains(&most()));
        // All views see the same wall, up to the strip by which they are shifted.
        let overlaps = surveyed.iter().flatten().map(|view| view.overlap.unwrap());
        assert!(overlaps.clone().all(|share| share > 0.98), "{:?}", overlaps.collect::<Vec<_>>());
        let mut settings = Settings::default();
        settings.planes.normal = Some([1.0, 0.0, 0.1]);
        two.install(|| scan.suggest_planes(&settings).unwrap());
        // A thread that waits for a part of its view may begin another one.
        assert!(most() <= 6, "views are dropped once they are surveyed");
        // The copies of views that judge the poses keep the frames, which are counted here, so the
        // views of a run cannot be told from their copies.
        let loads = || wall.frames.lock().unwrap().len();
        let before = loads();
        two.install(|| scan.reconstruct(&settings, &Unwatched).unwrap());
        assert_eq!(loads() - before, 30, "each view is loaded once");
    }
}
