use super::*;
use std::error::Error as _;
use transect_fusion::PairwiseOptions;
use transect_geometry::{CurvedGuide, LengthUnit, PlaneFamily, Point3, StraightGuide, Vector3};
use transect_partial::dissertation::DissertationOptions;
use transect_partial::one_pass::OnePassOptions;

fn setup(partial: Method, fusion: FusionMethod) -> Setup {
    let guide = StraightGuide::along(Vector3::z()).unwrap();
    let planes = PlaneFamily::new(guide, 0.0, 0.5).unwrap();
    Setup { partial, fusion, ..Setup::new(LengthUnit::Metre, planes) }
}

fn with_options(options: &str) -> StoreHeader {
    let mut header = setup(Method::default(), FusionMethod::default()).store_header();
    header.options = options.to_owned();
    header
}

#[test]
fn settings_come_back_from_the_record() {
    let mut one_pass = OnePassOptions::default();
    (one_pass.gap, one_pass.max_incidence_rad) = (2, 70_f64.to_radians());
    for partial in [Method::OnePass(one_pass), Method::Dissertation(DissertationOptions::default())]
    {
        for fusion in [FusionMethod::default(), FusionMethod::Pairwise(PairwiseOptions::default())]
        {
            let setup = setup(partial, fusion);
            let header = setup.store_header();
            assert_eq!(Setup::of_store(&header).unwrap(), setup);
            assert_eq!(setup.difference(&header).unwrap(), None);
        }
    }
}

/// The names in a record are those in the stores of users; a test of their own keeps them.
#[test]
fn names_in_the_record_stay() {
    let text = r#"{"version":1,
        "partial":{"one_pass":{"max_incidence_rad":1.0,"jump_sigmas":3.0,"smooth":false,
            "subpixel":"four_point","gap":1,"excursion_sigmas":2.0,"least_sigma_factor":0.5}},
        "fusion":{"consensus":{"threshold_spreads":7.0,"direction_limit_rad":0.5,
            "shortest_footprints":3.0}}}"#;
    let setup = Setup::of_store(&with_options(text)).unwrap();
    let Method::OnePass(options) = setup.partial else { panic!("{:?}", setup.partial) };
    assert_eq!((options.max_incidence_rad, options.jump_sigmas), (1.0, 3.0));
    assert_eq!((options.smooth, options.gap, options.least_sigma_factor), (false, 1, 0.5));
    let FusionMethod::Consensus(options) = setup.fusion else { panic!("{:?}", setup.fusion) };
    assert_eq!((options.threshold_spreads, options.shortest_footprints), (7.0, 3.0));
    let text = r#"{"version":1,
        "partial":{"dissertation":{"jump":{"printed":{"threshold":0.25}},"gap":3,"thickness":2,
            "subpixel":"device_curves","direction":"codes","smooth":false}},
        "fusion":{"pairwise":{"tolerance":{"distance":0.1,"max_angle_rad":0.5,"remainder":0.2},
            "threshold_spreads":6.0}}}"#;
    let setup = Setup::of_store(&with_options(text)).unwrap();
    let Method::Dissertation(options) = setup.partial else { panic!("{:?}", setup.partial) };
    assert_eq!((options.gap, options.thickness, options.smooth), (3, 2, false));
    assert!(matches!(setup.fusion, FusionMethod::Pairwise(options) if options.tolerance.is_some()));
    // At this angle both sides of a sheet would be one.
    let wide = text.replace(r#""max_angle_rad":0.5"#, r#""max_angle_rad":3.0"#);
    let error = Setup::of_store(&with_options(&wide)).unwrap_err();
    let causes = format!("{error}: {:?}", error.source().map(ToString::to_string));
    assert!(causes.contains("within 0 and 90°, got 3 rad"), "{causes}");
}

#[test]
fn absent_fields_have_their_defaults() {
    for text in [
        r#"{"version":1}"#,
        r#"{"version":1,"partial":{"one_pass":{"gap":4}},"fusion":{"consensus":{}}}"#,
    ] {
        let expected = setup(Method::default(), FusionMethod::default());
        assert_eq!(Setup::of_store(&with_options(text)).unwrap(), expected);
    }
}

#[test]
fn what_a_newer_program_wrote_is_refused_by_name() {
    let refused = |text| {
        let error = Setup::of_store(&with_options(text)).unwrap_err();
        let cause = error.source().map_or(String::new(), ToString::to_string);
        format!("{error}: {cause}")
    };
    let text = refused(r#"{"version":1,"partial":{"one_pass":{"sharpen":true}}}"#);
    assert!(text.contains("unknown field `sharpen`") && text.contains("transect 0."), "{text}");
    let text = refused(r#"{"version":1,"colour":3}"#);
    assert!(text.contains("unknown field `colour`"), "{text}");
    let text = refused(r#"{"version":1,"fusion":{"majority":{}}}"#);
    assert!(text.contains("unknown variant `majority`"), "{text}");
    let text = refused(r#"{"version":2}"#);
    assert!(text.contains("version 2; this program reads version 1"), "{text}");
    assert!(refused("fast and good").contains("\"fast and good\""));
}

#[test]
fn only_the_fields_that_differ_are_listed() {
    let text = r#"{"version":1,"fusion":{"consensus":{"threshold_spreads":6.0}}}"#;
    let header = with_options(text);
    let here = setup(Method::default(), FusionMethod::default());
    let difference = here.difference(&header).unwrap().unwrap();
    assert_eq!(difference, "threshold_spreads: the store has 6.0, this run 8.0");
}

/// Texts as they are in stores made before the record, for every pair of methods.
#[test]
fn settings_before_the_record_are_read() {
    let one_pass = "OnePass(OnePassOptions { max_incidence_rad: 1.361356816555577, \
        jump_sigmas: 4.0, smooth: true, subpixel: Cartesian, gap: 4, excursion_sigmas: 4.0, \
        least_sigma_factor: 0.25 })";
    let dissertation = "Dissertation(DissertationOptions { jump: ScaleFree { max_incidence_rad: \
        1.361356816555577, jump_sigmas: 4.0 }, gap: 4, thickness: 4, subpixel: Cartesian, \
        direction: PlanePoints, smooth: true })";
    let consensus = "Consensus(ConsensusOptions { threshold_spreads: 8.0, direction_limit_rad: \
        0.8726646259971648, shortest_footprints: 4.0 })";
    let pairwise = "Pairwise(PairwiseOptions { tolerance: None, threshold_spreads: 8.0 })";
    let methods =
        [(one_pass, Method::default()), (dissertation, Method::Dissertation(Default::default()))];
    let fusions = [
        (consensus, FusionMethod::default()),
        (pairwise, FusionMethod::Pairwise(Default::default())),
    ];
    for (partial_text, partial) in methods {
        for (fusion_text, fusion) in fusions {
            let header = with_options(&format!("{partial_text}; {fusion_text}"));
            assert_eq!(setup(partial, fusion).difference(&header).unwrap(), None);
        }
    }
    let given = "Pairwise(PairwiseOptions { tolerance: Some(OverlapTolerance { distance: 0.1, \
        max_angle_rad: 0.5, remainder: 1e-7 }), threshold_spreads: 8.0 })";
    let header = with_options(&format!("{one_pass}; {given}"));
    let FusionMethod::Pairwise(options) = Setup::of_store(&header).unwrap().fusion else {
        panic!("not pairwise")
    };
    assert!(format!("{:?}", options.tolerance).contains("remainder: 1e-7"));
    for broken in [one_pass, "OnePass(; Consensus(", &format!("{one_pass}; {consensus} ")] {
        assert!(Setup::of_store(&with_options(broken)).is_err());
    }
}

#[test]
fn another_guide_of_the_same_length_is_another_guide() {
    let along = |y: f64| {
        let points = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [4.0, y, 0.0]].map(Point3::from).to_vec();
        let guide = CurvedGuide::spline(points).unwrap();
        let planes = PlaneFamily::new(guide, 0.0, 0.5).unwrap();
        Setup::new(LengthUnit::Metre, planes)
    };
    let header = along(1.0).store_header();
    assert_eq!(along(1.0).difference(&header).unwrap(), None);
    let mirrored = along(-1.0).difference(&header).unwrap().unwrap();
    assert!(mirrored.starts_with("guide: "), "{mirrored}");
}
