//! Poses and images that were written by another convention are explained by it; sound ones are
//! not.

use crate::common::{
    Stored, coarse, described, real, real_files, simulated, simulated_files, turned,
};
use proptest::prelude::*;
use std::sync::Arc;
use transect_device::{ImageOrder, Isometry3, PinholeScale, RangeImage, Vector3, View};
use transect_register::{CoarseView, FoundReading, PoseReading, Reading, find_reading};
use transect_sensors::RayTable;

/// What explains views whose images have one order only.
fn explained(views: &[View]) -> Option<FoundReading> {
    find_reading(&coarse(views), None, |_| None)
}

/// What explains files that are read as they are.
fn explained_files(files: &[Stored]) -> Option<FoundReading> {
    let copies = |files: Vec<Stored>| -> Option<Vec<CoarseView>> {
        let copy = |file: &Stored| Some(CoarseView::new(&file.read()?));
        files.iter().map(copy).collect()
    };
    let reread = |reading| match reading {
        Reading::Image(order) => copies(files.iter().map(|file| file.in_order(order)).collect()),
        _ => None,
    };
    find_reading(&copies(files.to_vec()).unwrap(), None, reread)
}

/// Files that hold their pixels in another order are explained by it.
fn every_wrong_order_is_named(name: &str, files: &[Stored], orders: &[ImageOrder]) {
    assert_eq!(explained_files(files), None, "{name}");
    for order in orders.iter().filter(|order| files[0].differs(**order)) {
        let wrong: Vec<_> = files.iter().map(|file| file.in_order(*order)).collect();
        let found = explained_files(&wrong);
        let reading = found.map(|found| found.reading);
        assert_eq!(reading, Some(Reading::Image(*order)), "{name}, {order}: {found:?}");
    }
}

#[test]
fn wrong_orders_of_simulated_images_are_named() {
    use ImageOrder::{Mirrored, Transposed, UpsideDown};
    for name in ["face_mask", "kitchen"] {
        every_wrong_order_is_named(name, &simulated_files(name), &ImageOrder::ALL);
    }
    // The part is symmetric: most cameras see its mirror image, too.
    let part = simulated_files("machined_part");
    every_wrong_order_is_named("machined_part", &part, &[Transposed, UpsideDown]);
    // A full circle of columns makes no rows. Upside down, level scanners at one height see a room
    // that stands on its head, and agree about it.
    every_wrong_order_is_named("room", &simulated_files("room"), &[Mirrored]);
}

#[test]
fn wrong_orders_of_real_images_are_named() {
    if let Some(files) = real_files("rgbd_redkitchen") {
        every_wrong_order_is_named("rgbd_redkitchen", &files, &ImageOrder::ALL);
    }
}

/// What explains views whose pixels may hold another length.
fn explained_by_pixels(views: &[View]) -> Option<FoundReading> {
    find_reading(&coarse(views), None, |reading| match reading {
        Reading::PixelsHold(scale) => {
            views.iter().map(|view| Some(CoarseView::new(&view.reread(scale)?))).collect()
        }
        _ => None,
    })
}

/// The view of a camera that is read by `stated`, and whose image holds `held`.
fn read_by(stated: PinholeScale, held: PinholeScale, view: &View) -> View {
    let (camera, image) = (view.frame(), view.image());
    let size = image.size();
    let rays = size.all_pixels().map(|p| camera.ray(p).unwrap().direction).collect();
    let frame = RayTable::new(size, rays, stated).unwrap();
    let value = |p| Some(held.value(&camera.point(p, f64::from(image.get(p)?))?) as f32);
    let values = size.all_pixels().map(|p| value(p).unwrap_or(f32::NAN)).collect();
    let image = RangeImage::from_values(size, values).unwrap();
    let (pose, sigma) = (*view.world_from_sensor(), view.sigma());
    View::new(view.name(), image, Arc::new(frame), pose, sigma).unwrap()
}

fn the_wrong_length_is_named(name: &str, views: &[View], [stated, held]: [PinholeScale; 2]) {
    let read = |held| views.iter().map(|v| read_by(stated, held, v)).collect::<Vec<_>>();
    assert_eq!(explained_by_pixels(&read(stated)), None, "{name}, {stated}");
    let found = explained_by_pixels(&read(held));
    let reading = found.map(|found| found.reading);
    assert_eq!(reading, Some(Reading::PixelsHold(held)), "{name}: {found:?}");
}

#[test]
fn lengths_of_rays_that_are_read_as_depths_are_named() {
    use PinholeScale::{Depth, RayLength};
    for name in ["face_mask", "kitchen"] {
        let views = simulated(name, "");
        the_wrong_length_is_named(name, &views, [Depth, RayLength]);
        the_wrong_length_is_named(name, &views, [RayLength, Depth]);
    }
    if let Some(views) = real("rgbd_redkitchen") {
        let some: Vec<View> = views.into_iter().step_by(5).collect();
        the_wrong_length_is_named("rgbd_redkitchen", &some, [Depth, RayLength]);
    }
}

/// The pose that was written by a convention, as a program reads it that does not know it.
fn misread(written: PoseReading, pose: &Isometry3) -> Isometry3 {
    match written {
        PoseReading::Wxyz => PoseReading::Xyzw.apply(pose),
        PoseReading::Xyzw => PoseReading::Wxyz.apply(pose),
        PoseReading::Millimetres => PoseReading::Metres.apply(pose),
        PoseReading::Metres => PoseReading::Millimetres.apply(pose),
        PoseReading::Radians => {
            let degrees = pose.rotation.scaled_axis() * 1f64.to_radians();
            Isometry3::new(pose.translation.vector, degrees)
        }
        other => other.apply(pose),
    }
}

fn every_wrong_reading_is_named(name: &str, views: &[View]) {
    assert_eq!(explained(views), None, "{name}");
    let is_camera = |view: &View| view.frame().kind().contains("Pinhole");
    // The axes of scanners have one convention.
    let none = (!views.iter().all(is_camera)).then_some(PoseReading::CameraYUp);
    for written in PoseReading::ALL.into_iter().filter(|written| Some(*written) != none) {
        let misread = |v: &View| v.with_pose(misread(written, v.world_from_sensor())).unwrap();
        let found = explained(&views.iter().map(misread).collect::<Vec<_>>());
        let reading = found.map(|found| found.reading);
        assert_eq!(reading, Some(Reading::Pose(written)), "{name}: {found:?}");
    }
}

#[test]
fn wrong_readings_of_simulated_scans_are_named() {
    // The scanners of the tunnel are not turned at all: there, several readings are one.
    for name in ["room", "face_mask", "machined_part", "kitchen"] {
        every_wrong_reading_is_named(name, &simulated(name, ""));
    }
}

#[test]
fn wrong_readings_of_real_scans_are_named() {
    for name in ["rgbd_redkitchen", "stanford_bunny"] {
        if let Some(views) = real(name) {
            every_wrong_reading_is_named(name, &views);
        }
    }
}

/// Stations of a tunnel agree in one place, too: a thousandth of their distances explains nothing.
#[test]
fn inverse_poses_of_a_tunnel_are_named() {
    let views = simulated("tunnel", "");
    let inverse = |v: &View| v.with_pose(v.world_from_sensor().inverse()).unwrap();
    let found = explained(&views.iter().map(inverse).collect::<Vec<_>>());
    let reading = found.map(|found| found.reading);
    assert_eq!(reading, Some(Reading::Pose(PoseReading::Inverse)), "{found:?}");
}

/// Read as inverse, all cameras stand in one place, where a ball agrees with itself.
#[test]
fn few_views_of_a_ball_need_no_other_reading() {
    for count in [4, 5, 6] {
        let station = |k: usize| {
            let angle = std::f64::consts::TAU * k as f64 / count as f64;
            let at = [4.0 * angle.cos(), 4.0 * angle.sin(), [-0.8, 0.4, 1.2][k % 3]];
            format!(
                "[[station]]\nname = 'view {k}'\nsensor = 'pinhole'\nrows = 120\ncols = 160\n\
                 field_of_view = 44\nat = {at:?}\nlook_at = [0, 0, 0]\n"
            )
        };
        let stations: String = (0..count).map(station).collect();
        let views = described(&format!(
            "name = 'ball'\nunit = 'm'\n[planes]\nnormal = [0, 0, 1]\noffset = 0\ninterval = 0.1\n\
             [noise]\nsigma = 0.001\n[[solid]]\nname = 'ball'\nshape = 'ball'\nradius = 1\n\
             at = [0, 0, 0]\n{stations}"
        ));
        assert_eq!(explained(&views), None, "{count} views");
    }
}

/// What explains views whose positions are `factor` times too large: distances that are as much
/// larger.
fn explained_at(views: &[View], factor: f64) -> Option<FoundReading> {
    let spread = |v: &View| {
        let mut pose = *v.world_from_sensor();
        pose.translation.vector *= factor;
        v.with_pose(pose).unwrap()
    };
    explained(&views.iter().map(spread).collect::<Vec<_>>())
}

#[test]
fn wrong_distances_of_all_images_are_named() {
    let of = |name| (name, simulated(name, ""));
    let mut scans = ["face_mask", "kitchen"].map(of).to_vec();
    scans.extend(real("rgbd_redkitchen").map(|views| ("rgbd_redkitchen", views)));
    for (name, views) in &scans {
        for factor in [0.01, 1.0 / 25.4, 0.2, 0.8, 1.25, 5.0, 10.0, 304.8] {
            let found = explained_at(views, factor);
            let Some(Reading::Distances(told)) = found.map(|found| found.reading) else {
                panic!("{name}, {factor}: {found:?}");
            };
            // Depth cameras err by themselves, and 4/5 is no ratio of units.
            let is_exact = *name == "face_mask" && ![0.8, 1.25].contains(&factor);
            let limit = if is_exact { 1e-6 } else { 0.02 };
            assert!((told / factor - 1.0).abs() < limit, "{name}, {factor}: {told}");
        }
    }
}

/// Stations that stand close together in a room agree nearly as well at larger distances.
#[test]
fn distances_that_only_grow_better_are_not_named() {
    let views = simulated("room", "");
    for factor in [0.2, 1.25, 5.0] {
        let found = explained_at(&views, factor).map(|found| found.reading);
        assert!(!matches!(found, Some(Reading::Distances(_))), "{factor}: {found:?}");
    }
}

#[test]
fn one_wrong_view_is_no_convention() {
    for scene in ["room", "face_mask", "tunnel"] {
        for degrees in [3.0, 10.0, 30.0, 180.0] {
            let mut views = simulated(scene, "");
            views[1] = turned(&views[1], 1, degrees);
            assert_eq!(explained(&views), None, "{scene} by {degrees}");
        }
    }
}

proptest! {
    /// Each reading is undone by its counterpart.
    #[test]
    fn readings_are_undone(
        turn in prop::array::uniform3(-1.7..1.7),
        shift in prop::array::uniform3(-5.0..5.0),
    ) {
        let pose = Isometry3::new(Vector3::from(shift), Vector3::from(turn));
        for written in PoseReading::ALL {
            let back = written.apply(&misread(written, &pose));
            prop_assert!(back.rotation.angle_to(&pose.rotation) < 1e-6, "{}", written);
            prop_assert!((back.translation.vector - pose.translation.vector).norm() < 1e-9);
        }
    }
}
