//! Gaps and range jumps of the one-pass method.

use crate::dissertation_scene::*;
use crate::gaps::{Step, bridged};
use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{ImageSize, Isometry3, RangeImage, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_partial::PartialModel;
use transect_partial::one_pass::{OnePassOptions, partial_model};
use transect_sensors::{AngularScan, ImagingRadar};

fn model(view: &View, planes: &PlaneFamily) -> PartialModel {
    let mut options = OnePassOptions::default();
    options.gap = 4;
    partial_model(view, planes, &options).unwrap()
}

gap_laws!(model);

/// A round room seen by a scanner of a full circle in its middle; some pixels are missing.
fn round_room(missing: impl Fn(usize, usize) -> bool) -> PartialModel {
    let size = ImageSize { rows: 9, cols: 72 };
    let value = |k: usize| if missing(k / 72, k % 72) { f32::NAN } else { 3.0 };
    let image = RangeImage::from_values(size, (0..size.pixels()).map(value).collect()).unwrap();
    let step = std::f64::consts::TAU / 72.0;
    let (theta, phi) =
        (AngularScan::from_radians(0.0, step), AngularScan::from_radians(-0.1, 0.025));
    let radar = Arc::new(ImagingRadar::new(size, theta, phi).unwrap());
    let view = View::new("room", image, radar, Isometry3::identity(), Some(0.0)).unwrap();
    let planes = PlaneFamily::new(StraightGuide::along(Vector3::z()).unwrap(), 0.04, 10.0).unwrap();
    model(&view, &planes)
}

#[test]
fn rings_with_one_gap_are_closed_again_at_the_seam_and_elsewhere() {
    for at in [0, 1, 20, 69, 70, 71] {
        for width in 0..=5 {
            let room = round_room(|_, col| (col + 72 - at) % 72 < width);
            let [plane] = room.planes.as_slice() else { panic!() };
            let [curve] = plane.curves.as_slice() else { panic!() };
            assert_eq!(curve.curve.is_closed(), width <= 4, "{width} from column {at}");
            assert_eq!(curve.curve.ends() == [None; 2], width <= 4);
            assert_eq!(bridged(curve).len(), usize::from((1..=4).contains(&width)));
            let unit = |k: usize| {
                let units = curve.curve.units();
                units.map(|u| u.vector().norm()).nth(k).unwrap()
            };
            let chord = 6.0 * (0.5 * (width + 1) as f64 * std::f64::consts::TAU / 72.0).sin();
            for length in bridged(curve).into_iter().map(unit) {
                assert!((length / chord - 1.0).abs() < 0.02, "{length} of {chord}");
            }
        }
    }
}

#[test]
fn several_gaps_of_a_ring_are_bridged_and_marked() {
    let room = round_room(|_, col| col % 12 < 3);
    let curve = &room.planes[0].curves[0];
    assert_eq!(room.planes[0].curves.len(), 1);
    assert!(curve.curve.is_closed());
    assert_eq!(bridged(curve).len(), 6);
}

#[test]
fn nothing_is_bridged_without_leave() {
    let mut options = OnePassOptions::default();
    options.gap = 0;
    let step = Step { step: 0.0, tilt: 0.1, slant: 0.1, missing: vec![2; 48], upright: true };
    let planes = planes_through(&transect_device::Point3::new(5.0, 0.0, 0.0), Vector3::z(), 0.2);
    let cut = partial_model(&step.view(), &planes, &options).unwrap();
    let whole = model(&step.view(), &planes);
    let curves = |m: &PartialModel| m.planes.iter().map(|p| p.curves.len()).sum::<usize>();
    let bridged = |m: &PartialModel| -> usize {
        m.planes.iter().flat_map(|p| &p.curves).map(|c| bridged(c).len()).sum()
    };
    assert_eq!(bridged(&cut), 0);
    assert!(bridged(&whole) > 10);
    assert_eq!(curves(&cut), curves(&whole) + bridged(&whole));
}
