//! Planes nearly tangent to noisy surfaces: no confetti, and nothing true is lost.

use crate::surfaces::{Distance, camera, look, pixels, shared_noise};
use transect_device::{Isometry3, Pixel, RangeImage, Vector3, View};
use transect_geometry::{PlaneFamily, StraightGuide};
use transect_partial::PartialModel;
use transect_partial::one_pass::{OnePassOptions, partial_model};

/// A wall across the line of sight.
const WALL: Distance = |p| 3.0 - p.z;

/// One plane at a distance from the origin along its normal.
fn plane(normal: Vector3, offset: f64) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), offset, 50.0).unwrap()
}

/// The plane through the middle of the wall, turned from it by an angle.
fn turned(degrees: f64) -> PlaneFamily {
    let (sin, cos) = degrees.to_radians().sin_cos();
    plane(Vector3::new(sin, 0.0, cos), 3.0 * cos)
}

fn wall(sigma: f64) -> View {
    look(&camera(), WALL, sigma, Some(sigma))
}

fn with(view: &View, planes: &PlaneFamily, smooth: bool, excursion_sigmas: f64) -> PartialModel {
    let mut options = OnePassOptions::default();
    options.smooth = smooth;
    options.excursion_sigmas = excursion_sigmas;
    partial_model(view, planes, &options).unwrap()
}

fn pieces(model: &PartialModel) -> usize {
    model.planes.iter().map(|p| p.curves.len()).sum()
}

#[test]
fn a_plane_nearly_tangent_to_a_noisy_wall_gives_one_curve_and_no_confetti() {
    let sigmas = OnePassOptions::default().excursion_sigmas;
    // The wall leaves the plane by 8 deviations at the sides of the image.
    for (sigma, smooth, degrees) in [(0.003, false, 1.0), (0.015, false, 5.0), (0.015, true, 2.0)] {
        let (view, planes) = (wall(sigma), turned(degrees));
        let before = with(&view, &planes, smooth, 0.0);
        let after = with(&view, &planes, smooth, sigmas);
        println!(
            "noise {sigma}, smoothing {smooth}, {degrees} degrees: {} pieces before, {} after",
            pieces(&before),
            pieces(&after)
        );
        assert!(smooth || pieces(&before) > 20, "{}", pieces(&before));
        assert_eq!(pieces(&after), 1);
        let curve = &after.planes[0].curves[0];
        let (first, last) = (curve.pixels[0].row, curve.pixels[curve.pixels.len() - 1].row);
        assert_eq!(first.abs_diff(last), 95, "from the upper border to the lower one");
    }
}

#[test]
fn a_plane_within_the_noise_of_a_wall_gives_nothing() {
    for smooth in [false, true] {
        let view = wall(0.015);
        let before = pieces(&with(&view, &turned(0.0), smooth, 0.0));
        // The largest of 12288 errors may be over four deviations, not over five.
        let after = pieces(&with(&view, &turned(0.0), smooth, 5.0));
        println!("smoothing {smooth}: {before} pieces before, {after} after");
        assert!(before > 10, "{before}");
        assert_eq!(after, 0);
    }
}

/// The wall as a depth camera sees it: pixels share most of their noise.
fn wall_in_groups(own: f64, of_group: f64) -> View {
    let clean = look(&camera(), WALL, 0.0, None);
    let size = clean.image().size();
    let (own_noise, shared) = (shared_noise(size, 1, 5), shared_noise(size, 4, 9));
    let noise = own_noise.iter().zip(&shared).map(|(a, b)| own * a + of_group * b);
    let values = pixels(size).map(|p| clean.image().get(p).unwrap()).zip(noise);
    let values = values.map(|(z, noise)| z + noise as f32).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    View::new("wall", image, clean.shared_frame(), Isometry3::identity(), None).unwrap()
}

#[test]
fn noise_that_neighbours_share_makes_no_curves() {
    let view = wall_in_groups(0.004, 0.012);
    let found = |shared_noise: bool| {
        let mut options = OnePassOptions::default();
        options.smoothing.shared_noise = shared_noise;
        pieces(&partial_model(&view, &turned(0.0), &options).unwrap())
    };
    let (without, with) = (found(false), found(true));
    println!("{without} pieces by the noise of single pixels, {with} by that of groups, too");
    assert!(without > 10, "{without}");
    assert_eq!(with, 0);
}

#[test]
fn views_whose_pixels_share_their_noise_are_read_at_half_their_resolution() {
    let step = |view: &View, change: fn(&mut OnePassOptions)| {
        let mut options = OnePassOptions::default();
        change(&mut options);
        options.resolved(view).step()
    };
    let in_groups = wall_in_groups(0.004, 0.012);
    assert_eq!(step(&in_groups, |_| ()), 2);
    assert_eq!(step(&in_groups, |options| options.smooth = false), 1);
    assert_eq!(step(&in_groups, |options| options.smoothing.half_resolution = false), 1);
    assert_eq!(step(&wall_in_groups(0.012, 0.0), |_| ()), 1);
    assert_eq!(step(&wall(0.012), |_| ()), 1);
}

#[test]
fn nodes_of_a_halved_view_name_the_pixels_of_the_whole_one() {
    let view = wall_in_groups(0.004, 0.012);
    let places = |half_resolution: bool| {
        let mut options = OnePassOptions::default();
        options.smoothing.half_resolution = half_resolution;
        let model = partial_model(&view, &turned(60.0), &options).unwrap();
        let curves = model.planes.iter().flat_map(|p| &p.curves);
        let mut places: Vec<_> = curves.flat_map(|c| c.pixels.clone()).collect();
        places.sort();
        places
    };
    let (half, whole) = (places(true), places(false));
    println!("{} nodes at half the resolution, {} of all pixels", half.len(), whole.len());
    assert!((0.4..0.6).contains(&(half.len() as f64 / whole.len() as f64)));
    let beside =
        |p: &Pixel| whole.iter().any(|w| w.row.abs_diff(p.row) < 3 && w.col.abs_diff(p.col) < 3);
    assert!(half.iter().all(beside));
}

#[test]
fn without_noise_nothing_is_left_out() {
    let view = look(&camera(), WALL, 0.0, Some(0.0));
    for degrees in [0.01, 1.0] {
        let [all, kept] = [0.0, 4.0].map(|sigmas| with(&view, &turned(degrees), true, sigmas));
        assert_eq!((pieces(&all), pieces(&kept)), (1, 1));
    }
}

#[test]
fn a_plane_along_the_rays_loses_nothing_however_noisy_the_floor() {
    // Noise along the rays does not move samples over or under a plane that holds the rays.
    let view = wall(0.1);
    let planes = plane(Vector3::y(), 0.0);
    for smooth in [false, true] {
        let [all, kept] = [0.0, 4.0].map(|sigmas| with(&view, &planes, smooth, sigmas));
        assert_eq!((pieces(&all), pieces(&kept)), (1, 1), "smoothing {smooth}");
    }
}

/// Small things of a size of three to five pixels, and the number of curves they must give.
#[test]
fn small_true_features_stay() {
    let bump: Distance = |p| {
        let ball = (p.x - 0.2).hypot(p.y).hypot(p.z - 3.0) - 0.06;
        ball.min(3.0 - p.z)
    };
    let hole: Distance = |p| {
        let pit = (p.x - 0.2).hypot(p.y).hypot(p.z - 3.0) - 0.08;
        (3.0 - p.z).max(-pit).min(4.0 - p.z)
    };
    let leg: Distance = |p| (p.x.hypot(p.z - 3.0) - 0.04).min(5.0 - p.z);
    let ball: Distance = |p| p.x.hypot(p.y).hypot(p.z - 4.0) - 1.0;
    let sigma = 0.002;
    let cases = [
        ("bump", bump, plane(Vector3::z(), 2.97)),
        ("hole", hole, plane(Vector3::z(), 3.03)),
        ("leg", leg, plane(Vector3::y(), 0.003)),
        // Caps of 15 and of 8 deviations.
        ("ball", ball, plane(Vector3::z(), 3.03)),
        ("ball", ball, plane(Vector3::z(), 3.016)),
    ];
    for (name, surface, planes) in cases {
        for smooth in [false, true] {
            let view = look(&camera(), surface, sigma, Some(sigma));
            let before = pieces(&with(&view, &planes, smooth, 0.0));
            let after = pieces(&with(&view, &planes, smooth, 4.0));
            println!("{name}, smoothing {smooth}: {before} pieces before, {after} after");
            assert_eq!(before, after, "{name}, smoothing {smooth}");
            assert!(after > 0, "{name}");
        }
    }
}
