use super::*;
use crate::test_data::{curve, model};
use std::f64::consts::TAU;
use transect_geometry::{Curve, PlaneIndex};
use transect_model::Model;

fn circle(radius: f64, nodes: u32) -> Curve {
    let at = |i| TAU * f64::from(i) / f64::from(nodes);
    let points: Vec<_> = (0..nodes).map(|i| (radius * at(i).cos(), radius * at(i).sin())).collect();
    curve(&points, true)
}

fn ball() -> Model {
    let half = |k: i64| (1.0 - (k as f64 / 40.0).powi(2)).sqrt() * 10.0;
    let mut planes: Vec<_> = (-39..40).map(|k| (k, vec![circle(half(k), 5000)])).collect();
    // Outside of the circle, so that the disc is known solid.
    planes[3].1.push(curve(&[(5.0, 0.0), (8.0, 0.1)], false));
    model([0.0, 0.0, 1.0], &planes)
}

fn sheet(model: &Model, plane: i64) -> String {
    let mut out = Vec::new();
    Sheets::new(model).write(PlaneIndex(plane), &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

fn overview(model: &Model) -> String {
    let mut out = Vec::new();
    write_overview(model, &OverviewOptions::default(), &mut out).unwrap();
    String::from_utf8(out).unwrap()
}

/// Every element opened is closed, and no coordinate is other than a number.
fn assert_well_formed(svg: &str) {
    let opened = svg.matches('<').count() - svg.matches("</").count() - svg.matches("/>").count();
    assert_eq!(opened, svg.matches("</").count());
    for wild in ["NaN", "inf", "e-"] {
        assert!(
            !svg.contains(&format!("{wild} ")) && !svg.contains(&format!("{wild}\"")),
            "{wild}"
        );
    }
}

#[test]
fn scales_are_true_when_they_fit_and_round_when_not() {
    let of = |size: f64| {
        let square = curve(&[(0.0, 0.0), (size, 0.0), (size, size)], true);
        Sheets::new(&model([0.0, 0.0, 1.0], &[(0, vec![square])])).scale()
    };
    assert_eq!(of(200.0), "1:1");
    assert_eq!(of(300.0), "1:2");
    assert_eq!(of(9000.0), "1:50");
    assert_eq!(of(20.0), "10:1");
    assert_eq!(Sheets::new(&model([0.0, 0.0, 1.0], &[])).scale(), "1:1");
}

#[test]
fn a_sheet_has_its_plane_unit_and_scale_and_stays_small() {
    let model = ball();
    let svg = sheet(&model, -36);
    assert_well_formed(&svg);
    for text in ["Section plane −36", "station −9 mm", "1 closed and 1 open curves", "scale 10:1"]
    {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.contains("fill=\"#dbe7f3\""), "the closed curve is filled");
    assert!(svg.contains("stroke=\"#d1495b\""), "open ends are marked");
    assert!(svg.len() < 12_000, "5000 nodes in {} bytes", svg.len());
    assert_well_formed(&sheet(&model, 1000));
}

#[test]
fn ticks_stand_on_the_solid_side() {
    // Solid above a curve that runs to the right: on paper, ticks point to smaller y.
    let line = curve(&[(0.0, 0.0), (100.0, 0.0)], false);
    let svg = sheet(&model([0.0, 0.0, 1.0], &[(0, vec![line])]), 0);
    let ticks = svg.lines().find(|l| l.contains("#7d9cbc")).unwrap();
    let first = ticks.split("d=\"").nth(1).unwrap().split('M').nth(1).unwrap();
    let relative = first.split('l').nth(1).unwrap();
    assert_eq!(relative, "-113-113", "{first}");
}

#[test]
fn the_overview_hides_the_far_side_and_stays_small() {
    let svg = overview(&ball());
    assert_well_formed(&svg);
    assert!(svg.contains("79 planes every 0.25 mm"), "{svg:.800}");
    assert!(svg.len() < 300_000, "400 000 nodes in {} bytes", svg.len());
    let empty = overview(&model([0.3, 0.0, 1.0], &[]));
    assert_well_formed(&empty);
    assert_eq!(svg, overview(&ball()), "the same model gives the same bytes");
}
