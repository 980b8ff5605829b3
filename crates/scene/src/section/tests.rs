use super::*;
use crate::{Scene, Shape, Solid};
use proptest::prelude::*;
use std::f64::consts::PI;
use transect_geometry::{Isometry3, StraightGuide, Vector3};

fn planes(normal: Vector3, offset: f64, interval: f64) -> PlaneFamily {
    PlaneFamily::new(StraightGuide::along(normal).unwrap(), offset, interval).unwrap()
}

fn mesh(shape: Shape, pose: Isometry3) -> Mesh {
    Scene::new(vec![Solid::new(shape, pose).unwrap()]).mesh(1e-4).unwrap()
}

fn cube() -> Mesh {
    mesh(Shape::cuboid(Vector3::repeat(2.0)).unwrap(), Isometry3::identity())
}

fn area(curves: &[Curve]) -> f64 {
    curves.iter().filter_map(Curve::signed_area).sum()
}

#[test]
fn a_cube_gives_counter_clockwise_squares() {
    let all = sections(&cube(), &planes(Vector3::z(), 0.05, 0.1)).unwrap();
    assert_eq!(all.len(), 20);
    assert_eq!(all.keys().next(), Some(&PlaneIndex(-10)));
    for (plane, curves) in &all {
        assert_eq!(curves.len(), 1, "{plane}");
        assert!(curves[0].is_closed());
        assert!((area(curves) - 4.0).abs() < 1e-12);
    }
}

#[test]
fn planes_through_faces_and_vertices_follow_the_tie_rule() {
    // Planes at -1, 0 and 1: on the plane is low, so the bottom face is cut and the top is not.
    let all = sections(&cube(), &planes(Vector3::z(), 0.0, 1.0)).unwrap();
    let cut: Vec<_> = all.iter().map(|(k, c)| (k.0, area(c))).collect();
    assert_eq!(cut, [(-1, 4.0), (0, 4.0)]);
    // A diagonal plane through six edges' ends: a hexagon through vertices stays one curve.
    let diagonal = planes(Vector3::new(1.0, 1.0, 0.0), 0.0, 1.0);
    let curves = &sections(&cube(), &diagonal).unwrap()[&PlaneIndex(0)];
    assert_eq!(curves.len(), 1);
    assert!((area(curves) - 4.0 * 2f64.sqrt()).abs() < 1e-12);
}

#[test]
fn a_fine_ball_gives_circles() {
    let ball = mesh(Shape::ball(1.0).unwrap(), Isometry3::translation(3.0, -2.0, 1.0));
    for normal in [Vector3::x(), Vector3::new(1.0, 2.0, -0.5)] {
        let family = planes(normal, 0.013, 0.1);
        let center = family.level(&Point3::new(3.0, -2.0, 1.0)) * 0.1;
        for (plane, curves) in sections(&ball, &family).unwrap() {
            let height = 0.1 * plane.0 as f64 - center;
            let circle = PI * (1.0 - height * height);
            // Inscribed: smaller than the circle by a chord error of 1e-4 of a unit radius.
            let lost = circle - area(&curves);
            assert_eq!(curves.len(), 1);
            assert!((-1e-12..2.0 * PI * 1.01e-4).contains(&lost), "{plane}: {lost}");
        }
    }
}

#[test]
fn reversed_winding_flips_the_curve() {
    let mut inward = cube();
    inward.faces.iter_mut().for_each(|f| f.swap(0, 1));
    let family = planes(Vector3::y(), 0.05, 0.1);
    let curves = &sections(&inward, &family).unwrap()[&PlaneIndex(3)];
    assert!((area(curves) + 4.0).abs() < 1e-12);
}

#[test]
fn a_hole_in_the_mesh_leaves_an_open_curve() {
    let mut open = cube();
    // Without the two faces at x = -1.
    open.faces.drain(0..2);
    let family = planes(Vector3::z(), 0.05, 0.1);
    let curves = &sections(&open, &family).unwrap()[&PlaneIndex(0)];
    assert_eq!(curves.len(), 1);
    assert!(!curves[0].is_closed());
    assert!((curves[0].length() - 6.0).abs() < 1e-12);
    // Solid on the left: from the top left corner around the right is clockwise, so it starts low.
    let (first, last) = (curves[0].nodes()[0], curves[0].nodes()[curves[0].nodes().len() - 1]);
    assert_eq!((first.position.x, first.position.y), (-1.0, -1.0));
    assert_eq!((last.position.x, last.position.y), (-1.0, 1.0));
}

#[test]
fn bad_meshes_and_absurd_planes_are_errors() {
    let mut bad = cube();
    let dense = planes(Vector3::z(), 0.0, 1e-12);
    assert!(matches!(sections(&bad, &dense), Err(MeshError::TooManyPlanes { .. })));
    bad.faces[3][1] = 99;
    let family = planes(Vector3::z(), 0.0, 1.0);
    assert!(matches!(sections(&bad, &family), Err(MeshError::BadIndex { face: 3, .. })));
    assert_eq!(sections(&Mesh::default(), &family), Ok(BTreeMap::new()));
}

#[test]
fn overlapping_boxes_merge_into_one_ring_of_the_exact_area() {
    let block = |x: f64| {
        let shape = Shape::cuboid(Vector3::new(2.0, 1.0, 1.0)).unwrap();
        Solid::new(shape, Isometry3::translation(x, 0.25 * x, 0.0)).unwrap()
    };
    let scene = Scene::new(vec![block(0.0), block(1.0), block(2.0)]);
    let all = scene.sections(&planes(Vector3::z(), 0.05, 0.1), 1e-3).unwrap();
    assert_eq!(all.len(), 10);
    for curves in all.values() {
        assert_eq!(curves.len(), 1);
        assert!((area(curves) - (3.0 * 2.0 - 2.0 * 0.75)).abs() < 1e-8);
    }
}

proptest! {
    #[test]
    fn sections_of_a_solid_are_closed_and_their_areas_add_up_to_its_volume(
        tilt in prop::array::uniform3(-1.0..1.0f64), offset in -0.1..0.1f64,
    ) {
        let can = mesh(Shape::cylinder(0.6, 1.7).unwrap(), Isometry3::rotation(tilt.into()));
        let family = planes(Vector3::new(0.1, 0.2, 1.0), offset, 0.01);
        let all = sections(&can, &family).unwrap();
        prop_assert!(all.values().flatten().all(Curve::is_closed));
        let volume: f64 = all.values().map(|c| area(c) * 0.01).sum();
        prop_assert!((volume - can.signed_volume()).abs() < 1e-2, "{volume}");
    }
}
