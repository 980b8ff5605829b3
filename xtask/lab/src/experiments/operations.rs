//! Appendix A: operations of partial modelling, counted in the code of today.
//!
//! The steps run once more with numbers that count ([`Counted`]). Their results must be those of
//! the code, bit for bit: plane range images, labels, codes, and the places of nodes. The example
//! is one corner of the bundled room, without noise.

use super::lab::Lab;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use std::cell::RefCell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Sub};
use transect_device::{Neighbour, Pixel, SensorPlane, View};
use transect_geometry::{PlaneFamily, Point2, Point3, Vector3};
use transect_partial::dissertation::{
    DissertationOptions, JumpTest, Label, PlaneImage, code_image, label_image, partial_model,
};
use transect_partial::one_pass::{Effort, Workspace, contours};
use transect_partial::{BreakRule, SectionAxes};
use transect_scene::SensorParameters;
use transect_sensors::AngularScan;
use transect_workflow::simulation::SensorPlan;

/// No pair is a range jump: its test costs once per pair, whatever the number of planes.
const JOINED: JumpTest =
    JumpTest::ScaleFree { max_incidence_rad: std::f64::consts::FRAC_PI_2, jump_sigmas: 0.0 };

/// Numbers of multiplications, divisions, additions and ifs.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct Operations([u64; 4]);

/// Places of the kinds of operations.
const MULTIPLICATIONS: usize = 0;
const DIVISIONS: usize = 1;
const ADDITIONS: usize = 2;
const IFS: usize = 3;

thread_local! {
    static COUNTS: RefCell<Operations> = RefCell::default();
}

fn count(kind: usize) {
    COUNTS.with_borrow_mut(|counts| counts.0[kind] += 1);
}

/// The operations of a step.
fn counted<T>(step: impl FnOnce() -> T) -> (T, Operations) {
    COUNTS.take();
    let result = step();
    (result, COUNTS.take())
}

/// A decision, which counts as one *if*.
fn asked(condition: bool) -> bool {
    count(IFS);
    condition
}

/// A number whose operations are counted.
#[derive(Debug, Clone, Copy)]
struct Counted(f64);

macro_rules! operation {
    ($name:ident, $method:ident, $kind:ident) => {
        impl $name for Counted {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                count($kind);
                Self(self.0.$method(other.0))
            }
        }
    };
}

operation!(Mul, mul, MULTIPLICATIONS);
operation!(Div, div, DIVISIONS);
operation!(Add, add, ADDITIONS);
operation!(Sub, sub, ADDITIONS);

impl Counted {
    fn exceeds(self, other: f64) -> bool {
        asked(self.0.partial_cmp(&other) == Some(Ordering::Greater))
    }
}

fn dot(a: [f64; 3], b: [Counted; 3]) -> Counted {
    let [x, y, z] = a.map(Counted);
    x * b[0] + y * b[1] + z * b[2]
}

/// A scanner's image, and the angles of its rays.
struct Example {
    view: View,
    axes: SectionAxes,
    planes: PlaneFamily,
    /// Cosine and sine of each row's φ and each column's θ.
    rows: Vec<[f64; 2]>,
    columns: Vec<[f64; 2]>,
}

impl Example {
    fn new() -> Result<Self, Failure> {
        let scene = trial::bundled_without_noise("room")?;
        let plan = SensorPlan { views: Some(1), ..SensorPlan::OWN };
        let view = scene.simulate(&plan)?.views.into_iter().next();
        let view = view.ok_or_else(|| Failure::because("the room has no station"))?;
        let station = scene.description.stations.first();
        let Some(SensorParameters::Spherical { theta0, dtheta, phi0, dphi }) =
            station.map(|s| s.sensor.clone())
        else {
            return Err(Failure::because("the room's first station is no scanner"));
        };
        let angles = |first: f64, step: f64, count: usize| {
            let scan = AngularScan::from_radians(first, step);
            (0..count).map(|k| scan.angle(k).sin_cos()).map(|(sin, cos)| [cos, sin]).collect()
        };
        let size = view.image().size();
        let planes = scene.description.planes.clone();
        let axes = SectionAxes::new(&view, &planes)?;
        let (rows, columns) = (angles(phi0, dphi, size.rows), angles(theta0, dtheta, size.cols));
        Ok(Self { view, axes, planes, rows, columns })
    }

    /// Direction of a pixel's ray: two products of tabulated sines and cosines.
    fn ray(&self, p: Pixel) -> [Counted; 3] {
        let ([cos_phi, sin_phi], [cos, sin]) =
            (self.rows[p.row].map(Counted), self.columns[p.col].map(Counted));
        [cos_phi * cos, cos_phi * sin, sin_phi]
    }

    /// Once per pixel: its point and its level.
    fn level(&self, p: Pixel) -> Option<f64> {
        let range = f64::from(self.view.image().get(p)?);
        let point = self.ray(p).map(|along| along * Counted(range));
        let form = self.axes.level();
        Some((dot(form.gradient.into(), point) + Counted(form.constant)).0)
    }

    /// Step 1 of a plane: its range image, Eq. 4.7.
    fn plane_range(&self, plane: &SensorPlane, p: Pixel) -> f64 {
        let range = Counted(plane.offset) / dot(plane.normal.into(), self.ray(p));
        let met = asked(range.0.is_finite()) && range.exceeds(0.0);
        if met { range.0 } else { f64::INFINITY }
    }

    /// Step 5: where the line between two samples meets the plane, and its place in the plane.
    fn node(&self, plane: &SensorPlane, [p, q]: [Pixel; 2]) -> Option<Point2> {
        let [a, b] = [p, q].map(|p| self.view.point_in_sensor(p));
        let (a, b) = (<[f64; 3]>::from(a?).map(Counted), <[f64; 3]>::from(b?).map(Counted));
        let height = |p| dot(plane.normal.into(), p) - Counted(plane.offset);
        let (first, second) = (height(a), height(b));
        let t = first / (first - second);
        let t = Counted(if asked(t.0.is_nan()) { 0.5 } else { t.0 });
        let t = if t.exceeds(1.0) { Counted(1.0) } else { t };
        asked(t.0 < 0.0);
        asked(t.0 < 0.5);
        let at = [0, 1, 2].map(|k| a[k] + (b[k] - a[k]) * t);
        let origin = self.axes.in_plane(&Point3::origin());
        let gradient = |k: usize| {
            [Vector3::x(), Vector3::y(), Vector3::z()]
                .map(|axis| (self.axes.in_plane(&Point3::from(axis)) - origin)[k])
        };
        let place = |k: usize| (dot(gradient(k), at) + Counted(origin[k])).0;
        Some(Point2::new(place(0), place(1)))
    }
}

/// The operations of each part, over all planes.
#[derive(Default)]
struct Found {
    once: Operations,
    range_images: Operations,
    labels: Operations,
    codes: Operations,
    nodes: Operations,
    node_count: usize,
    sweep: Operations,
    planes: usize,
}

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let example = Example::new()?;
    let mut found = Found::default();
    let (levels, once) = counted(|| levels(&example));
    found.once = once;
    let valid = || levels.iter().flatten().copied();
    let low = valid().fold(f64::INFINITY, f64::min).ceil() as i32;
    let high = valid().fold(f64::NEG_INFINITY, f64::max).ceil() as i32;
    let mut places = Vec::new();
    for level in low..high {
        found.planes += 1;
        plane(&example, &levels, level, &mut found, &mut places)?;
    }
    nodes_are_those_of_the_code(&example, &places)?;
    found.node_count = places.len();
    found.sweep = sweep(&example, &levels)?;
    print(&example, &found, lab)
}

/// The level of every pixel, and their extremes.
fn levels(example: &Example) -> Vec<Option<f64>> {
    let size = example.view.image().size();
    let level = |p: Pixel| {
        let level = example.level(p);
        // Is it missing, the lowest, the highest?
        (0..3).for_each(|_| {
            asked(true);
        });
        level
    };
    size.all_pixels().map(level).collect()
}

/// Steps 1 to 3 and 5 of one plane.
fn plane(
    example: &Example,
    levels: &[Option<f64>],
    level: i32,
    found: &mut Found,
    places: &mut Vec<Point2>,
) -> Result<(), Failure> {
    let size = example.view.image().size();
    let sensor_plane = example.axes.sensor_plane(level);
    let image = PlaneImage::new(example.view.frame(), &sensor_plane);
    let (same, operations) = counted(|| {
        size.all_pixels().all(|p| example.plane_range(&sensor_plane, p) == image.get(p))
    });
    found.range_images.add(&operations);
    agree(same, "plane range image", level)?;

    let in_code = label_image(&example.view, &example.axes, level);
    let label = |l: &Option<f64>| match l {
        Some(l) if asked(true) => Some(Counted(*l).exceeds(f64::from(level))),
        _ => None,
    };
    let (labels, operations) = counted(|| levels.iter().map(label).collect::<Vec<_>>());
    found.labels.add(&operations);
    let is_high = |p| in_code.get(p).map(|label| label == Label::High);
    agree(size.all_pixels().map(is_high).eq(labels.iter().copied()), "label image", level)?;

    let in_code = code_image(&example.view, &example.axes, level, JOINED, 0.0);
    let label = |p: Pixel| labels.get(size.index(p)?).copied().flatten();
    let differs = |p: Pixel, before: Option<Pixel>| {
        let (here, other) = (label(p), before.and_then(label));
        asked(here.is_some()) && asked(other.is_some()) && asked(here != other)
    };
    let code = |p| (differs(p, above(p)), differs(p, left(p)));
    let (codes, operations) = counted(|| size.all_pixels().map(code).collect::<Vec<_>>());
    found.codes.add(&operations);
    let of_code = |p| {
        let code = in_code.get(p);
        (code.crosses(Neighbour::Up), code.crosses(Neighbour::Left))
    };
    agree(size.all_pixels().map(of_code).eq(codes.iter().copied()), "code image", level)?;

    let crossed = size.all_pixels().zip(&codes).flat_map(|(p, (up, is_left))| {
        let up = above(p).filter(|_| *up);
        [up, left(p).filter(|_| *is_left)].into_iter().flatten().map(move |other| [p, other])
    });
    let crossed: Vec<[Pixel; 2]> = crossed.collect();
    let node = |pair: &[Pixel; 2]| example.node(&sensor_plane, *pair);
    let (nodes, operations) = counted(|| crossed.iter().filter_map(node).collect::<Vec<_>>());
    found.nodes.add(&operations);
    places.extend(nodes);
    Ok(())
}

fn above(p: Pixel) -> Option<Pixel> {
    Some(Pixel::new(p.row.checked_sub(1)?, p.col))
}

fn left(p: Pixel) -> Option<Pixel> {
    Some(Pixel::new(p.row, p.col.checked_sub(1)?))
}

fn agree(same: bool, step: &str, level: i32) -> Result<(), Failure> {
    let problem = || format!("plane {level}: the counted {step} differs from that of the code");
    if same { Ok(()) } else { Err(Failure::because(problem())) }
}

/// Every node of the dissertation's method must be one of the counted places.
fn nodes_are_those_of_the_code(example: &Example, places: &[Point2]) -> Result<(), Failure> {
    /// Largest difference, in metres: rounding of coordinates of ten metres.
    const ROUNDING: f64 = 1e-9;
    let mut options = DissertationOptions::default();
    (options.jump, options.smooth, options.gap, options.thickness) = (JOINED, false, 0, 0);
    let model = partial_model(&example.view, &example.planes, &options)?;
    let mut sorted = places.to_vec();
    sorted.sort_by(|a, b| a.x.total_cmp(&b.x));
    let near = |p: &Point2| {
        let first = sorted.partition_point(|q| q.x < p.x - ROUNDING);
        let mut candidates = sorted[first..].iter().take_while(|q| q.x <= p.x + ROUNDING);
        candidates.any(|q| (q.y - p.y).abs() <= ROUNDING)
    };
    let curves = model.planes.iter().flat_map(|plane| &plane.curves);
    let mut nodes = curves.flat_map(|c| c.curve.nodes());
    match nodes.find(|node| !near(&node.position)) {
        None => Ok(()),
        Some(node) => {
            let problem = format!("the node at {} is none of the counted ones", node.position);
            Err(Failure::because(problem))
        }
    }
}

/// The sweep of `one_pass` up to the crossed pairs; the same number of crossings as in the code.
fn sweep(example: &Example, levels: &[Option<f64>]) -> Result<Operations, Failure> {
    let size = example.view.image().size();
    let gradient = example.axes.level().gradient;
    let ceiling = |p: Pixel| levels.get(size.index(p)?).copied().flatten().map(f64::ceil);
    let (crossings, operations) = counted(|| {
        let rows: Vec<_> =
            example.rows.iter().map(|r| Counted(gradient.z) * Counted(r[1])).collect();
        let column = |c: &[f64; 2]| {
            Counted(gradient.x) * Counted(c[0]) + Counted(gradient.y) * Counted(c[1])
        };
        let columns: Vec<_> = example.columns.iter().map(column).collect();
        let mut crossings = 0.0;
        for p in size.all_pixels() {
            let range = Counted(example.view.image().get(p).map_or(f64::NAN, f64::from));
            let [cos_phi, _] = example.rows[p.row];
            let per_range = Counted(cos_phi) * columns[p.col] + rows[p.row];
            let _level = range * per_range + Counted(example.axes.level().constant);
            for other in [above(p), left(p)].into_iter().flatten() {
                if let (Some(a), Some(b)) = (ceiling(p), ceiling(other))
                    && asked(a != b)
                {
                    crossings += (a - b).abs();
                }
            }
        }
        crossings
    });
    let rule = BreakRule::new(std::f64::consts::FRAC_PI_2, 0.0);
    let effort = Effort::default();
    let mut work = Workspace::default();
    let in_code = contours(&example.view, &example.axes, &rule, &effort, &mut work)?.vertex_count();
    // Levels of the code are `f32`: samples on a plane within rounding may be on its other side.
    if (crossings - in_code as f64).abs() > 1e-3 * crossings {
        let problem = format!("{crossings} crossings are counted, the sweep finds {in_code}");
        return Err(Failure::because(problem));
    }
    Ok(operations)
}

impl Operations {
    fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, count)| *sum += count);
    }

    /// A cell for each kind, as a share of a number.
    fn per(&self, number: usize) -> Vec<String> {
        self.0.map(|count| format!("{:.2}", count as f64 / number as f64)).to_vec()
    }

    /// A cell for each kind, in millions; divisions are multiplications, as in the source.
    fn millions(&self) -> Vec<String> {
        let [products, quotients, sums, ifs] = self.0;
        [products + quotients, sums, ifs].map(|n| format!("{:.1}", n as f64 * 1e-6)).to_vec()
    }
}

fn print(example: &Example, found: &Found, lab: &Lab) -> Result<(), Failure> {
    let pixels = example.view.image().size().pixels();
    let (planes, nodes) = (found.planes, found.node_count);
    let line = |name: &str, cells: Vec<String>, printed: &str| {
        [vec![name.to_owned()], cells, vec![printed.to_owned()]].concat()
    };
    let each = planes * pixels;
    let heads = "step | × | ÷ | + | if | as printed";
    lab.table(
        "steps",
        heads,
        [
            line("level of each pixel, once per pixel", found.once.per(pixels), "2 if"),
            line("1. plane range image (3.4.1, Eq. 4.7)", found.range_images.per(each), "4 ×, 2 +"),
            line("2. labels (3.4.2)", found.labels.per(each), "8 if for 2 and 3"),
            line("3. codes (3.4.2)", found.codes.per(each), ""),
            line(
                "meeting point and place, once per node",
                found.nodes.per(nodes),
                "14 ×, 9 +, C_int",
            ),
            line("`one_pass`, once per pixel for all planes", found.sweep.per(pixels), "–"),
        ],
    )?;
    let of = |per_pixel: [usize; 3], per_each: [usize; 3], per_node: [usize; 3]| {
        let sum =
            |k: usize| (per_pixel[k] * pixels + per_each[k] * each + per_node[k] * nodes) as u64;
        Operations([sum(0), 0, sum(1), sum(2)])
    };
    let mut dissertation = found.once;
    for step in [found.range_images, found.labels, found.codes, found.nodes] {
        dissertation.add(&step);
    }
    let mut one_pass = found.sweep;
    one_pass.add(&found.nodes);
    let total = |name: &str, operations: Operations| {
        [vec![name.to_owned()], operations.millions()].concat()
    };
    say(&format!("{pixels} pixels, {planes} planes, {nodes} nodes; in millions:\n"));
    lab.table(
        "methods",
        "method | × and ÷ | + | if",
        [
            total("printed, Cartesian frame", of([14, 9, 6], [12, 12, 8], [0; 3])),
            total("printed, device frame", of([0, 0, 2], [4, 2, 8], [14, 9, 0])),
            total("`dissertation` today", dissertation),
            total("`one_pass` today", one_pass),
        ],
    )?;
    say("Counted with the code's own results: range images, labels and codes are equal bit for \
         bit, nodes within rounding. Range jumps, tracing and smoothing are not counted.");
    Ok(())
}
