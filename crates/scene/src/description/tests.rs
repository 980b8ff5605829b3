use super::*;
use crate::{BUNDLED_ROOM, Shape};
use transect_device::{ImageSize, Pixel, SensorPlane};
use transect_geometry::Point3;
use transect_sensors::LightStripeParameters;

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
fn a_solid_may_be_there_for_some_stations_alone() {
    let ball = |x: i32, more: &str| {
        format!("[[solid]]\nshape = 'ball'\nradius = 1\nat = [{x}, 0, 0]\n{more}\n")
    };
    let stations = "[[station]]\nsensor = 'pinhole'\nrows = 4\ncols = 4\nfield_of_view = 60\n\
                    at = [0, 0, 9]\nlook_at = [0, 0, 0]\n"
        .repeat(3);
    let solids = ball(0, "") + &ball(5, "stations = [0, 2]") + &ball(9, "stations = [2]");
    let described = with(&(solids + &stations)).unwrap();
    assert_eq!((described.solids.len(), described.visitors.len()), (1, 2));
    let there = |x: f64| {
        let seen = |scene: Scene| scene.contains(&Point3::new(x, 0.0, 0.0));
        [0, 1, 2].map(|k| seen(described.visited_scene(k).unwrap_or_else(|| described.scene())))
    };
    assert_eq!(there(0.0), [true; 3]);
    assert_eq!(there(5.0), [true, false, true]);
    assert_eq!(there(9.0), [false, false, true]);
    assert!(!described.scene().contains(&Point3::new(5.0, 0.0, 0.0)));
    let missing = problem(&(ball(0, "stations = [3]") + &stations));
    assert!(missing.contains("solid 1, key stations: there is no station 3"), "{missing}");
}

#[test]
fn bad_values_name_entry_and_key() {
    let cases = [
        ("[[solid]]\nshape='ball'\nradius=0\nat=[0,0,0]", "solid 1, key radius: 0.0 is not"),
        ("[[solid]]\nshape='ball'\nat=[0,0,0]", "key radius: it is missing, a ball needs it"),
        ("[[solid]]\nshape='ball'\nradius=1\nsize=[1,1,1]\nat=[0,0,0]", "key size: it means"),
        ("[[solid]]\nname='b'\nshape='box'\nsize=[1,nan,1]\nat=[0,0,0]", "solid 1 \"b\", key size"),
        (
            "[[solid]]\nshape='ball'\nradius=1\nat=[0,inf,0]",
            "key at: inf is not a number of at most 1e13",
        ),
        (
            "[[solid]]\nshape='ball'\nradius=1\nat=[0,0,0]\nrotate={axis=[0,0,0],degrees=1}",
            "key rotate.axis: it has no direction",
        ),
        (
            "[[solid]]\nshape='torus'\nradius=1\ntube=1\nat=[0,0,0]",
            "key tube: 1 is not less than the radius",
        ),
        (
            "[[solid]]\nshape='prism'\nbottom=[[0,0],[1,0]]\nheight=1\nat=[0,0,0]",
            "key bottom: a polygon has",
        ),
        (
            "[[solid]]\nshape='prism'\nbottom=[[0,0],[1,0],[0,1]]\ntop=[]\nheight=1\nat=[0,0,0]",
            "key top: it must have as many corners",
        ),
        ("[[solid]]\nshape='mesh'\nat=[0,0,0]", "key mesh: it is missing, a mesh needs it"),
        ("[noise]\ndropout = 1.5", "noise, key dropout: 1.5 is not a share"),
        ("[noise]\nsigma = nan", "noise, key sigma: NaN"),
        ("[noise]\nmax_incidence = 91", "key max_incidence: 91"),
        ("[noise]\ncorrelation = -1", "key correlation: -1 is not from 0 to 100 pixels"),
        (
            "[noise]\ndepth_camera = { distortion = 2 }",
            "key depth_camera.distortion: 2 is not a share",
        ),
        (
            "[noise]\ndepth_camera = { disparity_step = 0.1 }",
            "key depth_camera.disparity_step: disparities need a base_line",
        ),
    ];
    for (text, expected) in cases {
        let found = problem(text);
        assert!(found.contains(expected), "{found}\nshould contain {expected}");
    }
    let guide = "guide = { kind = 'spline', points = [[0, 0, 0], [1, 0, 0]] }\nnormal =";
    let both = Description::parse(&HEAD.replace("normal =", guide)).unwrap_err().to_string();
    assert_eq!(
        both,
        "planes, key normal: it means nothing beside a guide; leave out one of the two"
    );
    let planes = Description::parse(&HEAD.replace("interval = 1", "interval = 0")).unwrap_err();
    assert_eq!(
        planes.to_string(),
        "planes, key interval: the plane interval must be a positive length, got 0"
    );
}

#[test]
fn absurd_numbers_are_refused_with_solid_and_key() {
    let ball = |keys: &str| format!("[[solid]]\nname='far'\nshape='ball'\n{keys}");
    let prism = "[[solid]]\nname='far'\nshape='prism'\nheight=1\nat=[0,0,0]\n";
    for (text, key) in [
        (ball("radius=1\nat=[0,1e300,0]"), "at: 1e300"),
        (ball("radius=1e300\nat=[0,0,0]"), "radius: 1e300"),
        (ball("radius=inf\nat=[0,0,0]"), "radius: inf"),
        (
            ball("radius=1\nat=[0,0,0]\nrotate={axis=[0,0,1],degrees=1e300}"),
            "rotate.degrees: 1e300",
        ),
        (ball("radius=1\nat=[0,0,0]\nrotate={axis=[0,1e300,1],degrees=1}"), "rotate.axis: 1e300"),
        (format!("{prism}bottom=[[0,0],[1e300,0],[0,1]]"), "bottom: a corner is not finite"),
    ] {
        let (found, expected) = (problem(&text), format!("solid 1 \"far\", key {key}"));
        assert!(found.starts_with(&expected), "{found}\nshould start with {expected}");
    }
    for (key, line) in [("offset", "offset = 0"), ("interval", "interval = 1")] {
        let text = HEAD.replace(line, &format!("{key} = 1e300"));
        let found = Description::parse(&text).unwrap_err().to_string();
        assert_eq!(found, format!("planes, key {key}: 1e300 is not a number of at most 1e13"));
    }
}

#[test]
fn every_shape_has_its_keys() {
    let shapes = [
        ("box", "size=[2,2,2]"),
        ("pyramid", "size=[2,2,2]"),
        ("cylinder", "radius=1\nheight=2"),
        ("cone", "radius=1\nheight=2"),
        ("frustum", "radius=1\ntop_radius=0.5\nheight=2"),
        ("ball", "radius=1"),
        ("prism", "bottom=[[-1,-1],[1,-1],[1,1],[-1,1]]\nheight=2"),
        ("prism", "bottom=[[-1,-1],[1,-1],[0,1]]\ntop=[[-1,0],[1,0],[0,1]]\nheight=2"),
        ("mesh", "mesh='cube.stl'"),
    ];
    let cube = Shape::cuboid(Vector3::repeat(2.0)).unwrap().mesh_of(1.0);
    let meshes = BTreeMap::from([("cube.stl".to_owned(), cube)]);
    for (shape, keys) in shapes {
        let text = format!("{HEAD}[[solid]]\nshape='{shape}'\n{keys}\nat=[5,0,0]");
        let d = Description::parse_with_meshes(&text, &meshes).unwrap();
        assert!(d.scene().contains(&Point3::new(5.0, 0.01, 0.02)), "{shape}");
        let odd = text.replace("\nat=", "\ntube=0.1\nat=");
        let odd = Description::parse_with_meshes(&odd, &meshes).unwrap_err().to_string();
        assert!(odd.contains(&format!("key tube: it means nothing for a {shape}")), "{odd}");
    }
    let ring = with("[[solid]]\nshape='torus'\nradius=2\ntube=0.5\nat=[5,0,0]").unwrap().scene();
    assert!(ring.contains(&Point3::new(7.0, 0.0, 0.4)));
    assert!(!ring.contains(&Point3::new(5.0, 0.0, 0.0)));
}

#[test]
fn meshes_are_asked_for_by_name() {
    let text = format!(
        "{HEAD}[[solid]]\nshape='mesh'\nmesh='b.ply'\nat=[0,0,0]\n\
         [[solid]]\nname='part'\nshape='mesh'\nmesh='a.stl'\nat=[0,0,0]\n\
         [[solid]]\nshape='mesh'\nmesh='b.ply'\nat=[0,0,0]\n\
         [[solid]]\nshape='mesh'\nmesh='builtin:flange'\nat=[0,0,0]"
    );
    assert_eq!(Description::mesh_names(&text).unwrap(), ["a.stl", "b.ply"]);
    let mut open = Shape::cuboid(Vector3::repeat(2.0)).unwrap().mesh_of(1.0);
    open.faces.pop();
    let meshes = BTreeMap::from([("b.ply".to_owned(), open)]);
    let found = Description::parse_with_meshes(&text, &meshes).unwrap_err().to_string();
    assert!(found.contains("solid 2 \"part\", key mesh: no mesh is called \"a.stl\""), "{found}");
    assert!(found.contains("solid 1, key mesh: \"b.ply\": edge"), "{found}");
    assert!(!found.contains("solid 4"), "{found}");
    let unknown = text.replace("builtin:flange", "builtin:teapot");
    let found = Description::parse(&unknown).unwrap_err().to_string();
    assert!(found.contains("solid 4, key mesh: no mesh is called \"builtin:teapot\""), "{found}");
}

#[test]
fn materials_are_named_once_and_used_by_name() {
    let ball = "[[solid]]\nshape='ball'\nradius=1\nat=[0,0,0]\n";
    let head = "[materials]\nfelt = { reflectivity = 0.05 }\n";
    let d = with(&format!("{head}{ball}material='felt'\n{ball}")).unwrap();
    assert_eq!((d.solids[0].reflectivity(), d.solids[1].reflectivity()), (0.05, 1.0));
    let found = problem(&format!("{head}{ball}material='silk'"));
    assert_eq!(found, "solid 1, key material: no material is called \"silk\"");
    let found = problem(&format!("[materials]\nfelt={{reflectivity=1.2}}\n{ball}material='felt'"));
    assert_eq!(found, "materials, \"felt\", key reflectivity: 1.2 is not a share above 0, up to 1");
}

#[test]
fn all_noise_is_read() {
    let text = "[noise]\nsigma_growth=0.001\nquantum=0.5\nfull_return=0.2\nmixed=0.3\n\
                pose={degrees=0.1,shift=2}";
    let noise = with(text).unwrap().noise;
    let pose = PoseNoise { degrees: 0.1, shift: 2.0 };
    let expected = Noise {
        sigma_growth: 0.001,
        quantum: 0.5,
        full_return: 0.2,
        mixed: 0.3,
        pose,
        ..Noise::NONE
    };
    assert_eq!(noise, expected);
    for (text, key) in [
        ("sigma_growth = -1", "sigma_growth"),
        ("quantum = inf", "quantum"),
        ("full_return = 2", "full_return"),
        ("mixed = 1.5", "mixed"),
        ("pose = { shift = -1 }", "pose.shift"),
        ("pose = { degrees = nan }", "pose.degrees"),
    ] {
        let found = problem(&format!("[noise]\n{text}"));
        assert!(found.starts_with(&format!("noise, key {key}: ")), "{found}");
    }
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
fn scanners_keep_their_true_size_in_any_unit() {
    let text = "[[station]]\nsensor='light_stripe'\nat=[0,0,0]\n\
                [[station]]\nsensor='lookup_table'\nat=[0,0,0]";
    for (unit, millimetre) in [("mm", 1.0), ("m", 1e-3), ("in", 1.0 / 25.4)] {
        let head = HEAD.replace("'mm'", &format!("'{unit}'"));
        let stations = Description::parse(&format!("{head}{text}")).unwrap().stations;
        let SensorParameters::LightStripe(found) = &stations[0].sensor else { panic!("{unit}") };
        let smart_eye = LightStripeParameters::smart_eye().scaled(millimetre);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs();
        assert!(near(found.baseline, smart_eye.baseline), "{unit}: {found:?}");
        assert!(near(found.cell_height, smart_eye.cell_height), "{unit}: {found:?}");
        assert!(near(found.farthest, smart_eye.farthest), "{unit}: {found:?}");
        let angles = found.theta_laser.as_radians().iter().zip(smart_eye.theta_laser.as_radians());
        assert!(angles.len() == 200 && angles.into_iter().all(|(a, b)| near(*a, *b)));
        assert_eq!(stations[0].size, smart_eye_size());
        // 4.7.1: 90 mm deep from 110 mm on, 100 mm wide at 200 mm. The field leans 1°.
        let SensorParameters::LookupTable(found) = stations[1].sensor else { panic!("{unit}") };
        assert!(
            near(found.depths[0], 110.0 * millimetre) && near(found.depths[1], 200.0 * millimetre)
        );
        let frame = stations[1].frame().unwrap();
        let far = SensorPlane { normal: Vector3::z(), offset: 190.0 * millimetre };
        let end = |col| {
            let pixel = Pixel::new(128, col);
            frame.point(pixel, frame.plane_value(pixel, &far).unwrap()).unwrap()
        };
        assert!(near(end(255).x - end(0).x, 95.0 * millimetre), "{unit}: {}", end(0));
    }
}

fn smart_eye_size() -> ImageSize {
    ImageSize { rows: 494, cols: 200 }
}

#[test]
fn a_scanners_table_changes_it_for_all_its_stations() {
    let text = "[light_stripe]\nbaseline=250\ntheta=[60,70]\n\
                [lookup_table]\nstep=0.5\ndepth=[120,180]\n\
                [[station]]\nsensor='light_stripe'\nrows=100\ncols=5\nat=[0,0,0]\n\
                [[station]]\nsensor='lookup_table'\nrows=11\ncols=64\nat=[0,0,0]";
    let stations = with(text).unwrap().stations;
    let SensorParameters::LightStripe(stripe) = &stations[0].sensor else { panic!() };
    let usual = LightStripeParameters::smart_eye();
    assert_eq!((stripe.baseline, stripe.focal_length), (250.0, usual.focal_length));
    assert_eq!(stations[0].frame().unwrap().size(), ImageSize { rows: 100, cols: 5 });
    let height = |p: &LightStripeParameters| p.cell_height * p.camera_rows as f64;
    assert!((height(stripe) - height(&usual)).abs() < 1e-12, "the same field in fewer rows");
    let first = stripe.theta_laser.as_radians()[0].to_degrees();
    assert!((first - 61.0).abs() < 1e-12, "pixel centres share the range: {first}");
    let SensorParameters::LookupTable(table) = stations[1].sensor else { panic!() };
    assert_eq!((table.rows.place(0.0), table.rows.place(10.0)), (-2.5, 2.5));
    assert_eq!((table.depths, table.columns.count()), ([120.0, 180.0], 64));
}

#[test]
fn bad_scanners_name_their_table_key_and_value() {
    let station = |sensor: &str| format!("[[station]]\nsensor='{sensor}'\nat=[0,0,0]\n");
    for (sensor, keys, expected) in [
        ("light_stripe", "baseline=-5", "key baseline: -5 is not a length of at least 0"),
        ("light_stripe", "cell_width=-1", "key cell_width: -1 is not a length of at least 0"),
        ("light_stripe", "focal_length=0", "key focal_length: 0 is not a positive length"),
        ("light_stripe", "fan_angle=200", "key fan_angle: 200 is not between 0 and 180 degrees"),
        ("light_stripe", "theta=[58,190]", "key theta: 190 is not between 0 and 180 degrees"),
        ("light_stripe", "farthest=3", "key farthest: 3 is not a depth beyond the focal length"),
        ("lookup_table", "depth=[200,110]", "key depth: 110 is not a farthest depth beyond"),
        ("lookup_table", "step=nan", "key step: NaN is not a length of at least 0"),
        ("lookup_table", "step=0", "key step: 0 is not"),
        ("lookup_table", "baseline=0", "key baseline: 0 is not a positive length"),
        ("lookup_table", "theta=[20,-5]", "key theta"),
    ] {
        let twice = station(sensor).repeat(2);
        let found = problem(&format!("{twice}[{sensor}]\n{keys}"));
        assert!(found.starts_with(&format!("{sensor}, {expected}")), "{keys}: {found}");
        assert_eq!(found.lines().count(), 1, "two stations, one instrument: {found}");
    }
    let unknown = with("[lookup_table]\nbase=3").unwrap_err().to_string();
    assert!(unknown.contains("base") && unknown.contains("expected one of"), "{unknown}");
    let found = problem(&format!("{}field_of_view=9", station("lookup_table")));
    assert!(found.contains("key field_of_view") && found.contains("[lookup_table]"), "{found}");
    let found = problem("[[station]]\nsensor='pinhole'\ncols=4\nfield_of_view=9\nat=[0,0,0]");
    assert!(found.contains("station 1, key rows: it is missing"), "{found}");
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
