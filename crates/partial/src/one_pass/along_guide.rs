//! Curved guides: a view in coordinates in which its guide is straight.
//!
//! **Problem.** Along a curved guide the level of a point is no affine function of its coordinates,
//! on which the sweep rests.
//!
//! **Idea.** Give every sample the coordinates (x, y, station) of the plane through it: in these
//! the guide is a straight line and its planes are parallel. The sweep runs there unchanged, and
//! finds which planes pass between which samples, and how their crossings are linked. Where a
//! crossing is, is then solved again in space, exactly on its own plane.
//!
//! **Steps.**
//! 1. The station of every sample: its nearest place on the guide, looked for near that of its left
//!    neighbour. Samples beyond the guide's ends or too far from it have none; they count as
//!    missing, and are counted.
//! 2. The sweep, with rays and range jumps as the sensor has them. Neighbours whose stations differ
//!    by more than their distance allows are broken, too: the guide comes near them twice.
//! 3. Of each crossing, the point where the line between its two samples meets the plane. The
//!    plane's frame gives its coordinates, and the directions that the node's errors come from.
//!
//! **Limits.** Within the guide's reach, stations of neighbouring samples are on the sides of a
//! plane on which the samples are. Heights over a plane, for noise that is nearly tangent to it,
//! are differences of stations. Near the reach such a height is too large by up to ten times; on
//! the guide it is exact. Crossings are solved linearly, whatever
//! [`Subpixel`] says. Samples a little beyond an end of the guide keep their neighbours joined, as
//! on any other plane.
//!
//! **Cost.** 24 bytes and the search for a station per sample.
//!
//! [`Subpixel`]: crate::subpixel::Subpixel

use super::crossing::{Crossing, direction, sample};
use super::vertex::Kind;
use crate::PartialError;
use crate::pixel_grid::Grid;
use crate::subpixel::parameter;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, DevicePoint, Handedness, ImageSize, Isometry3, LinearForm, MISSING_POINT,
    Neighbour, Note, PairGeometry, Pixel, Point3, RangeImage, Ray, RayProducts, SensorPlane,
    Vector3, View,
};
use transect_geometry::{
    CurvedGuide, NoStation, PlaneFamily, PlaneFrame, PlaneIndex, StraightGuide,
};

/// Samples of a view that a curved guide has no station for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct OffGuide {
    pub beyond_ends: usize,
    pub beyond_reach: usize,
}

/// A view and a curved guide.
#[derive(Debug)]
pub(super) struct AlongGuide {
    /// The view in guide coordinates; its world has the guide along z.
    pub view: View,
    /// The planes in that world.
    pub planes: PlaneFamily,
    pub off_guide: OffGuide,
    /// The problem of the guide, if pairs are torn.
    pub note: Option<Note>,
    given: View,
    family: PlaneFamily,
}

/// A view along a guide, if any of it has a station.
#[derive(Debug)]
pub(super) enum Straightening {
    Along(Box<AlongGuide>),
    /// No sample has a station between the guide's ends.
    Off(OffGuide),
}

impl Straightening {
    /// The view along the guide.
    pub fn of(
        view: &View,
        family: &PlaneFamily,
        guide: &Arc<CurvedGuide>,
    ) -> Result<Self, PartialError> {
        let (points, off_guide) = points_along(view, family, guide);
        let values = |row: usize| view.image().row(row).iter().copied();
        let all = (0..view.image().size().rows).flat_map(values);
        let kept = all.zip(&points).map(|(v, p)| if p.x.is_nan() { f32::NAN } else { v });
        let Ok(image) = RangeImage::from_values(view.image().size(), kept.collect()) else {
            return Ok(Self::Off(off_guide));
        };
        let (given, guide) = (view.clone(), Arc::clone(guide));
        let mut frame = Straightened { given, guide, points, torn: 0 };
        frame.torn = frame.count_torn();
        let note = frame.note();
        let (name, at) = (view.name(), Isometry3::identity());
        let Ok(straight) = View::new(name, image, Arc::new(frame), at, view.sigma()) else {
            return Ok(Self::Off(off_guide));
        };
        let planes = StraightGuide::along(Vector3::z())
            .and_then(|z| PlaneFamily::new(z, family.offset(), family.interval()))
            .map_err(|_| PartialError::CurvedGuide)?;
        let (given, family) = (view.clone(), family.clone());
        let along = AlongGuide { view: straight, planes, off_guide, note, given, family };
        Ok(Self::Along(Box::new(along)))
    }
}

impl AlongGuide {
    /// The frame of a plane of the curved guide.
    pub fn frame(&self, plane: PlaneIndex) -> PlaneFrame {
        self.family.frame(plane)
    }

    /// Solves the crossing of a pair with a plane, given by its frame, exactly.
    pub fn solve(&self, kind: Kind, pair: [Pixel; 2], plane: &PlaneFrame) -> Crossing {
        let pose = self.given.world_from_sensor();
        let samples = pair.map(|pixel| (pixel, pose * sample(&self.given, pixel)));
        let [a, b] = samples.map(|(_, p)| plane.height(&p));
        let direction = |pixel| pose.rotation * direction(&self.given, pixel);
        let turn = |v: &Vector3| in_plane(plane, v);
        let place = |p: &Point3| plane.plane_from_world(p);
        Crossing::new(kind, samples, parameter(a, b), direction, turn, place)
    }

    /// A direction of the sensor's frame in a plane's coordinates, with the height third.
    pub fn turn(&self, in_sensor: &Vector3, plane: &PlaneFrame) -> Vector3 {
        in_plane(plane, &(self.given.world_from_sensor().rotation * in_sensor))
    }
}

/// A direction in a plane's coordinates, its height third.
fn in_plane(plane: &PlaneFrame, v: &Vector3) -> Vector3 {
    Vector3::new(plane.x_axis().dot(v), plane.y_axis().dot(v), plane.normal().dot(v))
}

/// Guide coordinates of every sample, row by row; NaN where there is no sample or no station.
fn points_along(view: &View, family: &PlaneFamily, guide: &CurvedGuide) -> (Vec<Point3>, OffGuide) {
    let size = view.image().size();
    let mut points = vec![MISSING_POINT; size.pixels()];
    let mut off_guide = OffGuide::default();
    // Half an interval beyond the last plane there is no plane, however far beyond the end a sample
    // is.
    let (first, last) = family.ends().unwrap_or((PlaneIndex(1), PlaneIndex(0)));
    if last < first {
        return (points, off_guide);
    }
    let half = 0.5 * family.interval();
    let (low, high) = (family.station(first) - half, family.station(last) + half);
    let mut hint = None;
    for (pixel, out) in size.all_pixels().zip(&mut points) {
        let Some(in_sensor) = view.point_in_sensor(pixel) else { continue };
        let p = view.world_from_sensor() * in_sensor;
        match guide.extended_station(&p, hint) {
            Ok(station) => {
                let in_plane = guide.frame(station).plane_from_world(&p);
                *out = Point3::new(in_plane.x, in_plane.y, station.clamp(low, high));
                hint = Some(station);
            }
            Err(NoStation::BeyondEnds) => off_guide.beyond_ends += 1,
            Err(NoStation::TooFar) => off_guide.beyond_reach += 1,
        }
    }
    (points, off_guide)
}

/// The device frame of one view's samples in guide coordinates.
///
/// It knows only the points of that view's image, not the points of other values.
#[derive(Debug)]
struct Straightened {
    given: View,
    guide: Arc<CurvedGuide>,
    points: Vec<Point3>,
    /// Pairs of neighbours that [`Straightened::is_torn`] breaks.
    torn: usize,
}

/// Tolerance of the largest difference of two stations, relative to it. Source: rounding, far below
/// any bend. Doubled, nothing changes.
const ROUNDING: f64 = 1e-6;

impl Straightened {
    fn at(&self, pixel: Pixel) -> Option<Point3> {
        let ImageSize { rows, cols } = self.size();
        let inside = pixel.row < rows && pixel.col < cols;
        let point = *self.points.get(pixel.row * cols + pixel.col).filter(|_| inside)?;
        (!point.x.is_nan()).then_some(point)
    }

    /// Whether the stations of two samples differ by more than their distance allows.
    ///
    /// Theory: the bend radius of the guide is at least R. At a distance r from the guide, planes
    /// lie closer than on it by the factor 1 - r / R. The station changes by at most the way over
    /// that factor. A larger change means that the guide passes the samples at both stations, and
    /// that its reach was stated too large.
    fn is_torn(&self, a: Pixel, b: Pixel) -> bool {
        let (Some(p), Some(q)) = (self.at(a), self.at(b)) else { return false };
        let (Some(start), Some(end)) =
            (self.given.point_in_sensor(a), self.given.point_in_sensor(b))
        else {
            return false;
        };
        let (way, aside) = ((end - start).norm(), p.xy().coords.norm().max(q.xy().coords.norm()));
        let stretch = (1.0 - (aside + way) / self.guide.reach()).max(0.1);
        (p.z - q.z).abs() > (1.0 + ROUNDING) * way / stretch
    }

    /// The number of torn pairs of neighbours.
    fn count_torn(&self) -> usize {
        let before = |pixel| {
            let both = [Neighbour::Left, Neighbour::Up];
            both.into_iter().filter_map(move |neighbour| self.neighbour(pixel, neighbour))
        };
        let torn = |pixel| before(pixel).filter(|other| self.is_torn(pixel, *other)).count();
        Grid::new(self).pixels().map(torn).sum()
    }

    /// Names the guide's point that is farthest from the first sample, if pairs are torn.
    fn note(&self) -> Option<Note> {
        if self.torn == 0 {
            return None;
        }
        let sample = Grid::new(self).pixels().find(|pixel| self.at(*pixel).is_some())?;
        let sample = self.given.world_from_sensor() * self.given.point_in_sensor(sample)?;
        let points = self.guide.points().iter().enumerate();
        let far = points.map(|(k, p)| (k, p, (p - sample).norm()));
        let (k, point, distance) = far.max_by(|a, b| a.2.total_cmp(&b.2))?;
        let text = format!(
            "the guide passes its samples more than once: the stations of {} pairs of \
             neighbouring samples differ by more than the samples are apart, and curves end \
             there; point {k} of the guide, ({}, {}, {}), is {distance:.4} from the first sample, \
             farther than all others: check its coordinates",
            self.torn, point.x, point.y, point.z
        );
        Some(Note::about(format_args!("view {}", self.given.name()), text))
    }
}

impl DeviceFrame for Straightened {
    fn size(&self) -> ImageSize {
        self.given.frame().size()
    }

    fn kind(&self) -> &'static str {
        self.given.frame().kind()
    }

    fn handedness(&self) -> Handedness {
        self.given.frame().handedness()
    }

    fn columns_wrap(&self) -> bool {
        self.given.frame().columns_wrap()
    }

    /// The direction in which the sample is seen, in the frame of the plane through it.
    fn ray(&self, pixel: Pixel) -> Option<Ray> {
        let (point, ray) = (self.at(pixel)?, self.given.frame().ray(pixel)?);
        let in_world = self.given.world_from_sensor().rotation * ray.direction;
        let direction = in_plane(&self.guide.frame(point.z), &in_world);
        let way = (self.given.point_in_sensor(pixel)? - ray.start).norm();
        Some(Ray { start: point - direction * way, direction })
    }

    fn point(&self, pixel: Pixel, _d3: f64) -> Option<Point3> {
        self.at(pixel)
    }

    /// A straight line is not straight in guide coordinates.
    fn device_point(&self, _in_sensor: &Point3) -> Option<DevicePoint> {
        None
    }

    fn plane_value(&self, _pixel: Pixel, _plane: &SensorPlane) -> Option<f64> {
        None
    }

    fn extent(&self, direction: &Vector3, _nearest: f64, _farthest: f64) -> (f64, f64) {
        let along = self.points.iter().map(|p| direction.dot(&p.coords));
        let bounds = along.filter(|v| !v.is_nan()).fold(None, |bounds: Option<(f64, f64)>, v| {
            Some(bounds.map_or((v, v), |(low, high)| (low.min(v), high.max(v))))
        });
        bounds.unwrap_or((0.0, 0.0))
    }

    fn form_row(&self, image: &RangeImage, row: usize, form: &LinearForm, out: &mut [f32]) {
        for (col, (value, d3)) in out.iter_mut().zip(image.row(row)).enumerate() {
            let point = self.at(Pixel::new(row, col)).filter(|_| !d3.is_nan());
            *value = point.map_or(f32::NAN, |p| form.at(&p) as f32);
        }
    }

    fn pair_row(
        &self,
        image: &RangeImage,
        row: usize,
        neighbour: Neighbour,
        out: &mut [PairGeometry],
    ) {
        self.given.frame().pair_row(image, row, neighbour, out);
        for (col, pair) in out.iter_mut().enumerate().filter(|_| self.torn > 0) {
            let pixel = Pixel::new(row, col);
            if self.neighbour(pixel, neighbour).is_some_and(|other| self.is_torn(pixel, other)) {
                *pair = PairGeometry::MISSING;
            }
        }
    }

    fn ray_products(&self, neighbour: Neighbour) -> Option<RayProducts> {
        self.given.frame().ray_products(neighbour).filter(|_| self.torn == 0)
    }

    fn pair(&self, image: &RangeImage, pixel: Pixel, other: Pixel) -> Option<PairGeometry> {
        self.given.frame().pair(image, pixel, other).filter(|_| !self.is_torn(pixel, other))
    }
}
