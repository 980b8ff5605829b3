//! The pose of a scanner from scans of the machine table and of spheres.

use super::common::Folder;
use transect_geometry::{Isometry3, Point3, Vector3};

const CENTRE: [f64; 3] = [310.0, -40.0, 30.0];
const RADIUS: f64 = 12.7;

/// Looks down on the table with a tilt of 20°; the linear axis y stays y.
fn pose() -> Isometry3 {
    let turn = std::f64::consts::PI - 20_f64.to_radians();
    Isometry3::new(Vector3::new(310.0, -45.0, 170.0), Vector3::y() * turn)
}

/// Points as a file has them, in the sensor frame.
fn file(points: impl Iterator<Item = Point3>) -> String {
    let line = |p: Point3| {
        let p = pose().inverse() * p;
        format!("{},{} {}\n", p.x, p.y, p.z)
    };
    "# x, y, z\n\n".to_owned() + &points.map(line).collect::<String>()
}

fn scans() -> Folder {
    let folder = Folder::empty();
    let places = (0..30).flat_map(|i| (0..30).map(move |j| (f64::from(i), f64::from(j))));
    folder.write("table.csv", file(places.map(|(i, j)| Point3::new(280.0 + i, -45.0 + j, 0.0))));
    let rings = (1..20).flat_map(|i| (0..40).map(move |j| (f64::from(i), f64::from(j))));
    let on_sphere = rings.map(|(i, j)| {
        let ((sin, cos), turn) = ((0.055 * i).sin_cos(), 0.157 * j);
        Point3::from(CENTRE) + RADIUS * Vector3::new(sin * turn.cos(), sin * turn.sin(), cos)
    });
    folder.write("sphere.csv", file(on_sphere));
    folder
}

#[test]
fn a_table_and_a_sphere_give_the_pose_that_made_their_points() {
    let folder = scans();
    let line = "align --table table.csv --sphere sphere.csv,310,-40,30,12.7 --axis 0,1,0,0,1,0 \
                --unit mm";
    let run = folder.run(line).succeeded();
    assert!(run.number("residual, root mean square") < 1e-9, "{}", run.stdout);
    assert_eq!((run.number("points used"), run.number("outliers")), (1660.0, 0.0));
    let printed = run.value("pose");
    let numbers: Vec<f64> =
        printed.trim_matches(['[', ']']).split(", ").map(|n| n.parse().unwrap()).collect();
    let expected = pose().to_homogeneous().transpose();
    for (found, expected) in numbers.iter().zip(expected.iter()) {
        assert!((found - expected).abs() < 1e-6, "{printed}");
    }
    assert_eq!(numbers.len(), 16);
    // The place of the sensor is a length, and in the unit that the table states.
    let inches = folder.run(&format!("{line} --output-unit in")).succeeded();
    let pose = inches.table().into_iter().find(|row| row.metric == "pose").unwrap();
    let x: f64 = pose.value.split(", ").nth(3).unwrap().parse().unwrap();
    assert!((25.4 * x - numbers[3]).abs() < 1e-6 && pose.unit == "in", "{}", inches.stdout);
}

#[test]
fn scans_that_leave_a_motion_free_and_wrong_lines_are_refused() {
    let folder = scans();
    let line = "align --table table.csv --sphere sphere.csv,310,-40,30,12.7 --unit mm";
    folder.run(line).failed_with(1, &["a second sphere, or a known axis"]);
    folder
        .run(&line.replace(",12.7", ""))
        .failed_with(2, &["--sphere", "\"sphere.csv,310,-40,30\"", "FILE,X,Y,Z,RADIUS"]);
    for (option, found) in [("--table-normal 0,0,0", "0,0,0"), ("--axis 0,1,0,nan,1,0", "NaN,1,0")]
    {
        let name = option.split(' ').next().unwrap();
        folder.run(&format!("{line} {option}")).failed_with(2, &[name, found, "no direction"]);
    }
    folder.write("table.csv", "1,2,3\n4,5\n");
    folder.run(line).failed_with(1, &["table.csv", "line 2", "\"4,5\"", "three numbers"]);
}
