//! Curves cut by missing pixels, and walls with a step, for whatever method is to find them.

use crate::dissertation_scene::*;
use std::sync::Arc;
use transect_device::{DeviceFrame, Isometry3, Pixel, Point3, Vector3, View};
use transect_geometry::{PlaneFamily, PlaneIndex};
use transect_partial::{EndReason, PartialCurve, PartialModel};
use transect_sensors::{AngularScan, ImagingRadar};

/// The laws of gaps and jumps, as tests of a file that has a [`Modeler`] by this name.
macro_rules! gap_laws {
    ($model:ident) => {
        proptest! {
            #![proptest_config(ProptestConfig::with_cases(20))]

            #[test]
            fn a_curve_cut_by_one_to_four_missing_pixels_is_one_again_and_by_five_it_is_two(
                rig in rigs(), setting in settings(), axis in directions(), angle in 0.0..3.1_f64,
                normal in directions(),
            ) {
                let pose = rig.pose(axis * angle);
                let solids = setting.solids(&rig.line_of_sight(&pose), rig.scale);
                let whole = look(rig.frame.clone(), pose, &solids, |_| false);
                prop_assume!(whole.is_some());
                let seen = Seen { rig: rig.clone(), view: whole.unwrap(), solids };
                prop_assume!(crate::gaps::check_cuts(&rig, &seen, normal, $model).is_some());
            }
        }

        proptest! {
            #![proptest_config(ProptestConfig::with_cases(30))]

            #[test]
            fn a_jump_is_never_bridged(
                step in 1.0..2.0_f64, tilt in -0.4..0.4_f64, slant in -0.4..0.4_f64,
                normal in directions(), missing in prop::collection::vec(0..=4_usize, 48),
                upright in any::<bool>(),
            ) {
                crate::gaps::Step { step, tilt, slant, missing, upright }.check(normal, $model);
            }
        }
    };
}

/// A way to find curves.
pub type Modeler = fn(&View, &PlaneFamily) -> PartialModel;

pub fn curves_on(model: &PartialModel, plane: PlaneIndex) -> &[PartialCurve] {
    let found = model.planes.iter().find(|p| p.plane == plane);
    found.map_or(&[], |p| p.curves.as_slice())
}

/// A way to cut a curve: pixels that lie in a strip across it, and that are not far from it.
#[derive(Debug, Clone, Copy)]
pub struct Cut {
    pub at: Pixel,
    pub along_columns: bool,
    pub width: usize,
}

impl Cut {
    pub fn takes(&self, p: Pixel) -> bool {
        self.is_within(p, 11)
    }

    /// Whether the cut changes the curve at one of its pixels: its border is that to the pixel
    /// above or left, which may lie in the strip alone.
    fn touches(&self, p: Pixel) -> bool {
        self.is_within(p, 12)
    }

    fn is_within(&self, p: Pixel, reach: usize) -> bool {
        let (along, across, from, beside) = if self.along_columns {
            (p.col, p.row, self.at.col, self.at.row)
        } else {
            (p.row, p.col, self.at.row, self.at.col)
        };
        (from..from + self.width).contains(&along) && across.abs_diff(beside) <= reach
    }
}

/// Whether all pixels up to three away are valid and close in space, too, and the surface there is
/// seen at 50° at most: across a gap, pixels are compared diagonally as well, where a surface is
/// steeper than along rows and columns.
fn is_surrounded(seen: &Seen, p: Pixel) -> bool {
    let Some(here) = seen.view.point_in_sensor(p) else { return false };
    let near = |row: usize, col: usize| {
        let q = Pixel::new(row, col);
        let pair = seen.view.frame().pair(seen.view.image(), p, q);
        let gentle = p == q || pair.is_some_and(|pair| pair.range_step <= 1.2 * pair.lateral);
        let there = seen.view.point_in_sensor(q);
        gentle && there.is_some_and(|there| (there - here).norm() < 10.0 * seen.rig.pixel())
    };
    let around = |at: usize| at.saturating_sub(3)..=at + 3;
    around(p.row).all(|row| around(p.col).all(|col| near(row, col)))
}

/// The first place from which a curve runs on for 24 pixels, more along the rows than along the
/// columns or the other way round. It is away from its ends, from rims and from other curves. Where
/// it turns within a gap, nobody can say how it continues.
pub fn cuttable(seen: &Seen, model: &PartialModel) -> Option<(PlaneIndex, Cut)> {
    for plane in &model.planes {
        let [curve] = plane.curves.as_slice() else { continue };
        for (start, run) in curve.pixels.windows(60).enumerate().step_by(7) {
            let (first, at, last) = (run[0], run[28], run[59]);
            let (rows, cols) = (first.row.abs_diff(last.row), first.col.abs_diff(last.col));
            // Four pixels along a steeper curve are more than four across.
            let gentle = |a: Pixel, b: Pixel| {
                let (rows, cols) = (a.row.abs_diff(b.row), a.col.abs_diff(b.col));
                10 * rows.min(cols) <= 7 * rows.max(cols)
            };
            let cut = Cut { at, along_columns: cols > rows, width: 7 };
            let node = |k: usize| curve.curve.nodes()[start + k].position;
            let turn = (node(28) - node(16)).angle(&(node(48) - node(36)));
            let gentle = run[12..48].windows(13).all(|w| gentle(w[0], w[12]));
            let straight = rows.max(cols) >= 24 && gentle && turn < 0.5;
            // The strip must not meet the curve a second time, be it soon after.
            let inside = curve.pixels.iter().filter(|p| cut.touches(**p)).count();
            let once = inside == run[14..43].iter().filter(|p| cut.touches(**p)).count();
            if straight && once && run[12..52].iter().all(|p| is_surrounded(seen, *p)) {
                return Some((plane.plane, cut));
            }
        }
    }
    None
}

/// Cuts a curve of a view by 1 to 5 missing pixels: up to 4 it is one curve again, by 5 it is two.
/// `None` if no curve can be cut.
pub fn check_cuts(rig: &Rig, seen: &Seen, normal: Vector3, model: Modeler) -> Option<()> {
    let planes = family(seen, normal, 0.1, 1);
    let before = model(&seen.view, &planes);
    let (plane, cut) = cuttable(seen, &before)?;
    let curve = curves_on(&before, plane).first()?;
    // A curve along the border of what the sensor sees has gaps of its own.
    if !bridged(curve).is_empty() {
        return None;
    }
    for width in 1..=5 {
        let cut = Cut { width, ..cut };
        let pose = *seen.view.world_from_sensor();
        let view = look(rig.frame.clone(), pose, &seen.solids, |p| cut.takes(p)).unwrap();
        let after = model(&view, &planes);
        let curves = curves_on(&after, plane);
        let bridged: usize = curves.iter().map(|c| bridged(c).len()).sum();
        if width > 4 {
            let two = if curve.curve.is_closed() { 1 } else { 2 };
            assert_eq!((curves.len(), bridged), (two, 0), "{width} missing");
            let reasons = curves.iter().flat_map(|c| c.curve.ends());
            let missing = reasons.filter(|r| *r == Some(EndReason::MissingPixel)).count();
            assert!(missing >= 2);
            continue;
        }
        assert_eq!((curves.len(), bridged), (1, 1), "{width} missing");
        assert_eq!(curves[0].curve.is_closed(), curve.curve.is_closed());
        check_bridge(&curves[0], &cut);
    }
    Some(())
}

/// The numbers of the units (node k to k + 1) that bridge missing pixels.
pub fn bridged(curve: &PartialCurve) -> Vec<usize> {
    let nodes = curve.curve.nodes().iter().enumerate();
    nodes.filter(|(_, node)| node.bridged).map(|(k, _)| k).collect()
}

/// The bridged unit spans the cut.
fn check_bridge(curve: &PartialCurve, cut: &Cut) {
    let pixels = &curve.pixels;
    let a = bridged(curve)[0];
    let (a, b) = (pixels[a], pixels[(a + 1) % pixels.len()]);
    let apart = a.row.abs_diff(b.row).max(a.col.abs_diff(b.col));
    assert!(apart >= cut.width, "{a} to {b}");
    let near = |p: Pixel| {
        let (along, from) =
            if cut.along_columns { (p.col, cut.at.col) } else { (p.row, cut.at.row) };
        along + 2 >= from && along <= from + cut.width + 2
    };
    assert!(near(a) && near(b), "{a} to {b} for {cut:?}");
}

pub fn radar(columns: usize) -> Arc<dyn DeviceFrame> {
    let size = transect_device::ImageSize { rows: 48, cols: columns };
    let scan = |count: usize| AngularScan::from_radians(-0.0078 * (count - 1) as f64, 0.0156);
    Arc::new(ImagingRadar::new(size, scan(columns), scan(48)).unwrap())
}

/// Two walls side by side, one a step behind the other; up to four columns (or rows) at the jump
/// between them are missing, more or less in each row.
#[derive(Debug, Clone)]
pub struct Step {
    pub step: f64,
    pub tilt: f64,
    pub slant: f64,
    pub missing: Vec<usize>,
    pub upright: bool,
}

impl Step {
    pub fn behind(&self, p: Pixel) -> bool {
        if self.upright { p.col >= 24 } else { p.row >= 24 }
    }

    /// The sensor looks along +x, its columns along y and its rows along z.
    pub fn view(&self) -> View {
        let wall = Vector3::new(-1.0, self.tilt, self.slant).normalize();
        let (far, near) = (Point3::new(5.0 + self.step, 0.0, 0.0), Point3::new(5.0, 0.0, 0.0));
        let frame = radar(48);
        let ground = |on_plane| [Solid::Ground { on_plane, normal: wall }];
        let gap = |p: Pixel| {
            let (along, across) = if self.upright { (p.row, p.col) } else { (p.col, p.row) };
            let missing = self.missing[along];
            (24 - missing / 2..24 - missing / 2 + missing).contains(&across)
        };
        let pose = Isometry3::identity();
        let both = [far, near].map(|p| look(frame.clone(), pose, &ground(p), gap).unwrap());
        let value = |k: usize| {
            let p = Pixel::new(k / 48, k % 48);
            both[usize::from(!self.behind(p))].image().get(p).unwrap_or(f32::NAN)
        };
        let values = (0..48 * 48).map(value).collect();
        let image = transect_device::RangeImage::from_values(frame.size(), values).unwrap();
        View::new("step", image, frame, pose, Some(0.0)).unwrap()
    }

    /// No curve is on both walls.
    pub fn check(&self, normal: Vector3, model: Modeler) {
        let planes = planes_through(&Point3::new(5.0, 0.01, 0.02), normal, 0.2);
        let model = model(&self.view(), &planes);
        for curve in model.planes.iter().flat_map(|p| &p.curves) {
            let sides = curve.pixels.iter().filter(|p| self.behind(**p)).count();
            assert!(sides == 0 || sides == curve.pixels.len(), "{sides}");
        }
    }
}
