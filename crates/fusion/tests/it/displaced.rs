//! Views that wrong poses displace by several footprints, as depth cameras' are.

use crate::draws::Noise;
use transect_fusion::{ConsensusOptions, FusedPlane, PairwiseOptions, consensus, pairwise};
use transect_geometry::{Curve, Node, Point2, crossings};

/// Distance between neighbouring nodes, and one node's own standard deviation.
const SPACING: f64 = 0.004;
const SIGMA: f64 = 0.0004;

/// Standard deviations of a view's shift and turn.
const SHIFT: f64 = 0.008;
const TURN: f64 = 0.004;

/// Length of each side of the square.
const SIDE: f64 = 2.0;

/// The place at a distance along the outline of the square.
fn outline(along: f64) -> Point2 {
    let along = along.rem_euclid(4.0 * SIDE);
    let rest = along % SIDE;
    match (along / SIDE) as usize {
        0 => Point2::new(rest, 0.0),
        1 => Point2::new(SIDE, rest),
        2 => Point2::new(SIDE - rest, SIDE),
        _ => Point2::new(0.0, SIDE - rest),
    }
}

/// Distance of a place from the outline.
fn off(place: &Point2) -> f64 {
    let outside = |v: f64| (v - 0.5 * SIDE).abs() - 0.5 * SIDE;
    let (x, y) = (outside(place.x), outside(place.y));
    if x > 0.0 && y > 0.0 { x.hypot(y) } else { x.max(y).abs() }
}

/// What a displaced view saw of the outline between two distances along it.
fn view(noise: &mut Noise, from: f64, to: f64) -> Vec<Curve> {
    let turn = TURN * noise.normal();
    let shift = [SHIFT * noise.normal(), SHIFT * noise.normal()];
    let node = |k: u32| {
        let true_place = outline(from + SPACING * f64::from(k));
        let (x, y) = (true_place.x - 0.5 * SIDE, true_place.y - 0.5 * SIDE);
        let (sin, cos) = turn.sin_cos();
        let moved = Point2::new(
            0.5 * SIDE + cos * x - sin * y + shift[0] + SIGMA * noise.normal(),
            0.5 * SIDE + sin * x + cos * y + shift[1] + SIGMA * noise.normal(),
        );
        Node::at(moved).with_sigma(SIGMA as f32).with_footprint(SPACING as f32)
    };
    let count = ((to - from) / SPACING) as u32;
    vec![Curve::new((0..count).map(node).collect(), false).unwrap()]
}

/// Median distance from the outline of the nodes that satisfy a condition.
fn median_off(plane: &FusedPlane, wanted: impl Fn(&Node) -> bool) -> f64 {
    let nodes = plane.curves.iter().flat_map(|curve| curve.nodes());
    let mut off: Vec<f64> = nodes.filter(|n| wanted(n)).map(|n| off(&n.position)).collect();
    off.sort_by(f64::total_cmp);
    off[off.len() / 2]
}

/// Twelve views, each of five eighths of the outline; the last side is seen by the last view alone.
fn scene(seed: u64) -> Vec<Vec<Curve>> {
    let mut noise = Noise(seed);
    let mut views: Vec<_> = (0..11)
        .map(|k| {
            let from = 0.1 * f64::from(k);
            view(&mut noise, from, from + 2.2 * SIDE)
        })
        .collect();
    views.push(view(&mut noise, 1.2 * SIDE, 3.7 * SIDE));
    views
}

#[test]
fn displaced_views_become_one_curve_that_does_not_cross_itself() {
    let mut sharp_turns = 0;
    for seed in 1..6 {
        let views = scene(seed);
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let plane = consensus(&slices, &ConsensusOptions::default());
        assert_eq!(crossings(&plane.curves), [], "seed {seed}");
        let length: f64 = plane.curves.iter().map(Curve::length).sum();
        assert!((length / (3.7 * SIDE) - 1.0).abs() < 0.03, "seed {seed}: {length}");
        let sharp = |curve: &Curve| {
            let nodes: Vec<_> = curve.nodes().iter().map(|n| n.position).collect();
            nodes.windows(3).filter(|p| (p[1] - p[0]).dot(&(p[2] - p[1])) < 0.0).count()
        };
        sharp_turns += plane.curves.iter().map(sharp).sum::<usize>();
    }
    println!("turns beyond 90 degrees in five scenes: {sharp_turns}");
    // Twenty corners, and 37 m of outline.
    assert!(sharp_turns <= 7, "{sharp_turns}");
}

/// Nodes of weight 0 are part of the view's curve, but no bead of theirs has a length.
#[test]
fn a_stretch_without_weight_takes_no_curve_away() {
    let mut views = scene(1);
    let nodes = views[3][0].nodes().iter().enumerate();
    let light = |(k, n): (usize, &Node)| n.with_weight(if k < 600 { 0.0 } else { 1.0 });
    views[3] = vec![Curve::new(nodes.map(light).collect(), false).unwrap()];
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let plane = consensus(&slices, &ConsensusOptions::default());
    let length: f64 = plane.curves.iter().map(Curve::length).sum();
    assert!((length / (3.7 * SIDE) - 1.0).abs() < 0.03, "{length}");
}

#[test]
fn the_spread_is_that_of_the_views_though_it_exceeds_the_first_search() {
    let ratio = |seed: u64| {
        let views = scene(seed);
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        consensus(&slices, &ConsensusOptions::default()).spread / SHIFT
    };
    let mean = (1..6).map(ratio).sum::<f64>() / 5.0;
    println!("measured spread over that of the shifts: {mean:.2}");
    assert!((0.75..1.3).contains(&mean), "{mean}");
}

#[test]
fn nodes_tell_whether_their_sigma_holds_the_views_errors() {
    let views = scene(1);
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let of = |views: &[&[Curve]]| consensus(views, &ConsensusOptions::default());
    let (one, all) = (of(&slices[..1]), of(&slices));
    assert!(one.sigma_is_noise_alone && !all.sigma_is_noise_alone);
    let sigma = |plane: &FusedPlane| {
        let nodes = plane.curves.iter().flat_map(|curve| curve.nodes());
        nodes.map(|n| f64::from(n.sigma)).fold(0.0, f64::max)
    };
    assert!(sigma(&one) < 2.0 * SIGMA && sigma(&all) > 4.0 * SIGMA);
    let pairwise = pairwise(&slices, &PairwiseOptions::default());
    assert!(pairwise.sigma_is_noise_alone && pairwise.view_error > SIGMA);
}

#[test]
fn ground_that_one_view_alone_saw_moves_with_its_view() {
    let mut ratios = Vec::new();
    for seed in 1..9 {
        let views = scene(seed);
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let mut options = ConsensusOptions::default();
        let alone =
            |n: &Node| n.position.x < 0.3 && n.position.y < 0.9 * SIDE && n.position.y > 0.6;
        let aligned = median_off(&consensus(&slices, &options), alone);
        options.steps.align = false;
        ratios.push(aligned / median_off(&consensus(&slices, &options), alone));
    }
    ratios.sort_by(f64::total_cmp);
    println!("error of ground seen once, with alignment over without: {ratios:.2?}");
    assert!(ratios[4] < 0.6, "{ratios:?}");
}

/// Adds errors to a view that change along its curve, as those of depth cameras do.
fn with_waves(view: &[Curve], noise: &mut Noise) -> Vec<Curve> {
    let lengths = [0.11, 0.15, 0.2, 0.26];
    let phases = lengths.map(|_| std::f64::consts::TAU * noise.uniform());
    let wave = |k: usize| {
        let angle = |length: f64| std::f64::consts::TAU * SPACING * k as f64 / length;
        let part = |(length, phase): (&f64, &f64)| (angle(*length) + phase).sin();
        0.5 * SHIFT * lengths.iter().zip(&phases).map(part).sum::<f64>()
    };
    let waved = |curve: &Curve| {
        let nodes = curve.nodes().iter().enumerate().map(|(k, n)| {
            Node::at(Point2::new(n.position.x + wave(k), n.position.y + wave(k)))
                .with_sigma(n.sigma)
                .with_footprint(n.footprint)
        });
        Curve::new(nodes.collect(), false).unwrap()
    };
    view.iter().map(waved).collect()
}

#[test]
fn errors_that_change_along_a_wall_average_out_and_corners_stay() {
    let mut off = [(); 4].map(|()| Vec::new());
    for seed in 1..32 {
        let mut noise = Noise(100 + seed);
        let views: Vec<_> = scene(seed).iter().map(|v| with_waves(v, &mut noise)).collect();
        let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
        let corner = |n: &Node| (n.position - Point2::new(SIDE, SIDE)).norm() < 0.06;
        let wall = |n: &Node| {
            let along = |v: f64| v.min(SIDE - v).abs();
            along(n.position.x).max(along(n.position.y)) > 0.15
        };
        let mut options = ConsensusOptions::default();
        let wide = consensus(&slices, &options);
        options.steps.wider_courses = false;
        let narrow = consensus(&slices, &options);
        off[0].push(median_off(&wide, wall));
        off[1].push(median_off(&narrow, wall));
        off[2].push(median_off(&wide, corner));
        off[3].push(median_off(&narrow, corner));
    }
    off.iter_mut().for_each(|off| off.sort_by(f64::total_cmp));
    let [wide, narrow, wide_corner, narrow_corner] = off.map(|off| off[15]);
    println!("walls {wide:.5} over {narrow:.5}, corners {wide_corner:.5} over {narrow_corner:.5}");
    assert!(wide < 0.9 * narrow && wide_corner < 1.1 * narrow_corner);
}

/// Every so many nodes of a view, whose footprints are as much longer.
fn sampled(view: &[Curve], every: usize) -> Vec<Curve> {
    let coarser = |curve: &Curve| {
        let nodes = curve.nodes().iter().step_by(every);
        let nodes = nodes.map(|n| n.with_footprint(SPACING as f32 * every as f32));
        Curve::new(nodes.collect(), false).unwrap()
    };
    view.iter().map(coarser).collect()
}

#[test]
fn errors_are_averaged_down_to_what_sampling_makes_of_a_curve() {
    // Views err by 0.4 footprints, then by 0.2.
    let ratio = |every: usize| {
        let mut ratios: Vec<f64> = (1..16)
            .map(|seed| {
                let mut noise = Noise(100 + seed);
                let views = scene(seed);
                let views = views.iter().map(|v| sampled(&with_waves(v, &mut noise), every));
                let views: Vec<_> = views.collect();
                let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
                let mut options = ConsensusOptions::default();
                let averaged = median_off(&consensus(&slices, &options), |_| true);
                options.steps.settle = false;
                averaged / median_off(&consensus(&slices, &options), |_| true)
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios[7]
    };
    let ratios = [ratio(6), ratio(12)];
    println!("median error with averaging over without: {ratios:.3?}");
    assert!(ratios[0] < 0.9 && ratios[1] == 1.0, "{ratios:?}");
}

#[test]
fn a_curve_of_one_view_is_left_out_if_it_is_shorter_than_a_common_course() {
    let mut views = scene(1);
    let straight = |y: f64, length: f64| {
        let node = |k: u32| {
            Node::at(Point2::new(0.5 + SPACING * f64::from(k), y))
                .with_sigma(SIGMA as f32)
                .with_footprint(SPACING as f32)
        };
        Curve::new((0..(length / SPACING) as u32).map(node).collect(), false).unwrap()
    };
    views[3].extend([straight(0.8, 0.05), straight(1.2, 0.4)]);
    let slices: Vec<&[Curve]> = views.iter().map(Vec::as_slice).collect();
    let plane = consensus(&slices, &ConsensusOptions::default());
    let has = |y: f64| {
        let place = Point2::new(0.6, y);
        let nodes = || plane.curves.iter().flat_map(|curve| curve.nodes());
        nodes().any(|n| (n.position - place).norm() < 0.1)
    };
    assert!(has(1.2) && !has(0.8));
}
