use super::*;
use crate::BUNDLED_ROOM;
use transect_geometry::Point3;

const HEAD: &str = "name = 'n'\nunit = 'mm'\n[planes]\nnormal = [0, 0, 1]\noffset = 0\n\
                    interval = 1\n";

fn with(more: &str) -> Result<Description, DescriptionError> {
    Description::parse(&format!("{HEAD}{more}"))
}

fn problem(more: &str) -> String {
    with(more).unwrap_err().to_string()
}

#[test]
fn what_is_written_is_what_stands_there() {
    let text = "[noise]\nsigma = 0.5\nseed = 4\n[[solid]]\nname = 'post'\nshape = 'cylinder'\n\
        radius = 1\nheight = 10\nat = [20, 0, 0]\nrotate = { axis = [0, 2, 0], degrees = 90 }\n";
    let d = with(text).unwrap();
    assert_eq!((d.unit, d.noise.sigma, d.noise.seed), (LengthUnit::Millimetre, 0.5, 4));
    assert_eq!((d.noise.dropout, d.noise.max_incidence), (0.0, FRAC_PI_2));
    assert_eq!(d.solids[0].name(), Some("post"));
    let scene = d.scene();
    // The axis has been turned from z to x.
    assert!(scene.contains(&Point3::new(24.9, 0.0, 0.9)));
    assert!(!scene.contains(&Point3::new(20.0, 0.0, 1.1)));
}

#[test]
fn bad_values_name_entry_and_key() {
    let cases = [
        ("[[solid]]\nshape='ball'\nradius=0\nat=[0,0,0]", "solid 1, key radius: 0 is not"),
        ("[[solid]]\nshape='ball'\nat=[0,0,0]", "key radius: it is missing, a ball needs it"),
        ("[[solid]]\nshape='ball'\nradius=1\nsize=[1,1,1]\nat=[0,0,0]", "key size: it means"),
        ("[[solid]]\nname='b'\nshape='box'\nsize=[1,nan,1]\nat=[0,0,0]", "solid 1 \"b\", key size"),
        ("[[solid]]\nshape='ball'\nradius=1\nat=[0,inf,0]", "key at: inf is not a finite"),
        (
            "[[solid]]\nshape='ball'\nradius=1\nat=[0,0,0]\nrotate={axis=[0,0,0],degrees=1}",
            "key rotate.axis: it has no direction",
        ),
        ("[noise]\ndropout = 1.5", "noise, key dropout: 1.5 is not a share"),
        ("[noise]\nsigma = nan", "noise, key sigma: NaN"),
        ("[noise]\nmax_incidence = 91", "key max_incidence: 91"),
    ];
    for (text, expected) in cases {
        let found = problem(text);
        assert!(found.contains(expected), "{found}\nshould contain {expected}");
    }
    let planes = Description::parse(&HEAD.replace("interval = 1", "interval = 0")).unwrap_err();
    assert_eq!(
        planes.to_string(),
        "planes, key interval: the plane interval must be a positive length, got 0"
    );
}

#[test]
fn unknown_keys_and_primitives_are_named() {
    for (text, expected) in [
        ("[[solid]]\nshape='teapot'\nat=[0,0,0]", "teapot"),
        ("[[solid]]\nshape='ball'\nradius=1\ncentre=[0,0,0]", "centre"),
        ("[[solid]]\nshape='ball'\nradius=1", "at"),
        ("[noise]\nsigma_mm = 1", "sigma_mm"),
        ("[[station]]\nsensor='sonar'\nrows=1\ncols=1\nat=[0,0,0]", "sonar"),
    ] {
        let error = with(text).unwrap_err();
        assert!(matches!(error, DescriptionError::Syntax(_)));
        assert!(error.to_string().contains(expected), "{error}");
    }
    let furlongs = Description::parse(&HEAD.replace("mm", "furlong")).unwrap_err().to_string();
    assert!(furlongs.contains("furlong"), "{furlongs}");
}

#[test]
fn all_faulty_entries_are_reported_at_once() {
    let ball = "[[solid]]\nshape='ball'\nradius=-1\nat=[0,0,0]\n";
    let Err(DescriptionError::Invalid(problems)) =
        with(&format!("[noise]\nsigma=-1\n{ball}{ball}"))
    else {
        panic!("three problems expected")
    };
    let places: Vec<_> = problems.iter().map(|p| p.place.as_str()).collect();
    assert_eq!(places, ["noise", "solid 1", "solid 2"]);
}

fn station(sensor: &str, more: &str) -> Result<Station, DescriptionError> {
    let head = format!("[[station]]\nsensor='{sensor}'\nrows=4\ncols=8\nat=[1,2,3]\n");
    with(&format!("{head}{more}")).map(|d| d.stations[0].clone())
}

#[test]
fn angles_are_those_of_pixel_centres() {
    let full = station("spherical", "theta=[180,-180]\nphi=[60,-60]").unwrap();
    let SensorParameters::Spherical { theta0, dtheta, phi0, dphi } = full.sensor else {
        panic!("spherical expected")
    };
    let degrees = [theta0, dtheta, phi0, dphi].map(f64::to_degrees);
    for (found, expected) in degrees.iter().zip([157.5, -45.0, 45.0, -30.0]) {
        assert!((found - expected).abs() < 1e-12, "{degrees:?}");
    }
    assert_eq!(full.name, "station 1");
}

#[test]
fn a_pinhole_looks_where_it_is_told() {
    let text = "field_of_view=90\nlook_at=[1,7,3]";
    let s = station("pinhole", text).unwrap();
    let SensorParameters::Pinhole { fx, fy, cx, cy } = s.sensor else { panic!("pinhole expected") };
    assert!((fx - 4.0).abs() < 1e-12 && fx == fy);
    assert_eq!((cx, cy), (3.5, 1.5));
    let turned = |v: Vector3| s.world_from_sensor * v;
    assert!((turned(Vector3::z()) - Vector3::y()).norm() < 1e-12, "forward");
    assert!((turned(Vector3::x()) - Vector3::x()).norm() < 1e-12, "right");
    assert!((turned(Vector3::y()) + Vector3::z()).norm() < 1e-12, "down");
    let down = station("pinhole", "field_of_view=90\nheading=90\ntilt=-90").unwrap();
    assert!((down.world_from_sensor * Vector3::z() + Vector3::z()).norm() < 1e-12);
}

#[test]
fn a_scanner_stays_upright_unless_tilted() {
    let s = station("spherical", "theta=[50,-50]\nphi=[50,-50]\nlook_at=[1,9,0]").unwrap();
    assert!((s.world_from_sensor * Vector3::z() - Vector3::z()).norm() < 1e-12);
    assert!((s.world_from_sensor * Vector3::x() - Vector3::y()).norm() < 1e-12);
    let tilted = station("spherical", "theta=[50,-50]\nphi=[50,-50]\ntilt=30").unwrap();
    let forward = tilted.world_from_sensor * Vector3::x();
    assert!((forward.z - 0.5).abs() < 1e-12, "tilt lifts the view");
}

#[test]
fn bad_stations_name_their_key() {
    for (sensor, more, key) in [
        ("spherical", "theta=[0,0]\nphi=[1,-1]", "theta"),
        ("spherical", "theta=[0,400]\nphi=[1,-1]", "theta"),
        ("spherical", "theta=[0,90]\nphi=[95,-1]", "phi"),
        ("spherical", "theta=[0,90]", "phi"),
        ("spherical", "theta=[0,90]\nphi=[1,-1]\nfield_of_view=3", "field_of_view"),
        ("pinhole", "field_of_view=180", "field_of_view"),
        ("pinhole", "field_of_view=90\ntheta=[0,1]", "theta"),
        ("pinhole", "field_of_view=90\nheading=nan", "heading"),
        ("pinhole", "field_of_view=90\nlook_at=[1,2,3]", "look_at"),
        ("pinhole", "field_of_view=90\nlook_at=[1,2,4]\ntilt=3", "tilt"),
    ] {
        let error = station(sensor, more).unwrap_err().to_string();
        assert!(error.contains(&format!("station 1, key {key}: ")), "{more}: {error}");
    }
    for (rows, cols, key) in [(0, 5, "rows"), (5, 0, "cols"), (1 << 20, 1 << 20, "rows")] {
        let text = format!(
            "[[station]]\nsensor='pinhole'\nrows={rows}\ncols={cols}\nat=[0,0,0]\nfield_of_view=9"
        );
        assert!(problem(&text).contains(&format!("key {key}: an image has")), "{rows} {cols}");
    }
}

#[test]
fn the_bundled_room_is_right() {
    let room = Description::parse(BUNDLED_ROOM).unwrap();
    assert_eq!((room.name.as_str(), room.unit), ("room", LengthUnit::Metre));
    assert_eq!(room.stations.len(), 4);
    let scene = room.scene();
    for station in &room.stations {
        let place = Point3::from(station.world_from_sensor.translation.vector);
        assert!(!scene.contains(&place), "{}", station.name);
    }
}
