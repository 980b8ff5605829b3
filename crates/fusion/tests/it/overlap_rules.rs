//! The overlap rules as laws, on random pairs of curves whose parts are known beforehand.
//!
//! Run by `cargo test -p transect-fusion --test it overlap_rules`.

use crate::page::generated_blocks;
use crate::table::{Reversed, combinations};
use proptest::prelude::*;
use std::f64::consts::TAU;
use transect_fusion::pattern::{
    CurveRange, Fork, Overlap, OverlapTolerance, Overlaps, Parts, Pattern, Relation, Verdict,
    classify, verdict,
};
use transect_geometry::{Curve, Node, Point2, Vector2};

/// Whether the rules allow to merge the two curves: one valid overlap, or a ring.
fn can_be_merged(overlaps: &Overlaps) -> bool {
    let counted_right = matches!(overlaps.relation(), Relation::Single | Relation::Ring);
    counted_right && overlaps.as_slice().iter().all(|o| o.verdict.is_valid())
}

/// Nodes lie within a fifth of this of their true place.
const DISTANCE: f64 = 0.06;
const NOISE: f64 = DISTANCE / 5.0;
/// Unenclosed parts are at least this long along the base curve. It is four times the remainder
/// tolerance, so that neither noise nor the way out of reach at a fork can make them empty.
const PART: f64 = 16.0 * DISTANCE;
/// Ends that should coincide differ by up to this: less than the remainder tolerance.
const END_JITTER: f64 = DISTANCE;

fn tolerance() -> OverlapTolerance {
    OverlapTolerance::within(DISTANCE).unwrap()
}

// Strategies.

/// The surface that was seen: a sine with a radius of curvature of at least 2.
fn base(u: f64) -> Point2 {
    Point2::new(u, (u * 0.7).sin())
}

/// How one curve is sampled: node spacing, noise across and end jitter, from fixed random numbers.
#[derive(Debug, Clone)]
struct Sampling {
    spacing: f64,
    noise: Vec<f64>,
    end_jitter: (f64, f64),
}

fn samplings() -> impl Strategy<Value = Sampling> {
    let noise = prop::collection::vec(-NOISE..NOISE, 64);
    let jitter = (0.0..END_JITTER, 0.0..END_JITTER);
    (0.04..0.3, noise, jitter).prop_map(|(spacing, noise, end_jitter)| Sampling {
        spacing,
        noise,
        end_jitter,
    })
}

/// Lengths of the stretch before the overlap, of the overlap, and of the stretch behind it.
fn stretches() -> impl Strategy<Value = [f64; 3]> {
    prop::array::uniform3(PART..3.0)
}

fn parts() -> impl Strategy<Value = Parts> {
    prop::sample::select(Parts::ALL.to_vec())
}

/// The parts of two curves that overlap in one of the five patterns.
fn parts_in_patterns() -> impl Strategy<Value = (Pattern, (Parts, Parts))> {
    let of = |pattern: Pattern| {
        let found = combinations().filter(|&(a, b)| verdict(a, b) == Verdict::Valid(pattern));
        found.collect::<Vec<_>>()
    };
    let pattern = prop::sample::select(Pattern::ALL.to_vec());
    pattern.prop_flat_map(move |p| (Just(p), prop::sample::select(of(p))))
}

/// Two curves that overlap in one place and leave the given parts.
#[derive(Debug, Clone)]
struct Case {
    a: Curve,
    b: Curve,
    parts_a: Parts,
    parts_b: Parts,
}

fn cases() -> impl Strategy<Value = Case> {
    cases_of((parts(), parts()))
}

fn cases_of(parts: impl Strategy<Value = (Parts, Parts)>) -> impl Strategy<Value = Case> {
    (parts, stretches(), samplings(), samplings()).prop_map(
        |((parts_a, parts_b), [before, overlap, behind], sampling_a, sampling_b)| {
            let (begin, end) = (before, before + overlap);
            // Where both curves go on, the second one leaves the surface.
            let leaves = (
                parts_a.begins_unenclosed && parts_b.begins_unenclosed,
                parts_a.ends_unenclosed && parts_b.ends_unenclosed,
            );
            let curve = |parts: Parts, sampling: &Sampling, leaves: (bool, bool)| {
                let from =
                    if parts.begins_unenclosed { 0.0 } else { begin + sampling.end_jitter.0 };
                let to =
                    if parts.ends_unenclosed { end + behind } else { end - sampling.end_jitter.1 };
                let path = |u: f64| {
                    let before = if leaves.0 { (begin - u).max(0.0) } else { 0.0 };
                    let behind = if leaves.1 { (u - end).max(0.0) } else { 0.0 };
                    base(u) + Vector2::new(0.0, 0.8 * (before + behind))
                };
                sampled(path, from, to, sampling)
            };
            let a = curve(parts_a, &sampling_a, (false, false));
            let b = curve(parts_b, &sampling_b, leaves);
            Case { a, b, parts_a, parts_b }
        },
    )
}

fn sampled(path: impl Fn(f64) -> Point2, from: f64, to: f64, sampling: &Sampling) -> Curve {
    let units = ((to - from) / sampling.spacing).ceil().max(2.0) as usize;
    let node = |i: usize| {
        let u = from + (to - from) * i as f64 / units as f64;
        // Noise no rougher than the spacing keeps the directions within the angle limit.
        let roughest = NOISE.min(0.1 * sampling.spacing);
        let noise = sampling.noise[i % sampling.noise.len()].clamp(-roughest, roughest);
        Node::at(path(u) + Vector2::new(0.0, noise))
    };
    Curve::new((0..=units).map(node).collect(), false).unwrap()
}

/// A solid of radius 3; `u` is the arc length.
fn circle(u: f64) -> Point2 {
    let (sin, cos) = (u / RADIUS).sin_cos();
    Point2::new(RADIUS * cos, RADIUS * sin)
}

const RADIUS: f64 = 3.0;
const ROUND: f64 = RADIUS * TAU;

/// Two arcs that make a ring: how far each reaches, where they begin, and their sampling.
fn rings() -> impl Strategy<Value = (Curve, Curve)> {
    let overlaps = (PART..2.0, PART..2.0);
    (0.0..ROUND, 6.0..12.0, overlaps, samplings(), samplings()).prop_map(
        |(start, reach, (first, second), sampling_a, sampling_b)| {
            let a = sampled(circle, start, start + reach, &sampling_a);
            let b = sampled(circle, start + reach - first, start + ROUND + second, &sampling_b);
            (a, b)
        },
    )
}

/// A turn and a shift, as far as a survey's coordinates go.
fn motions() -> impl Strategy<Value = (f64, Vector2)> {
    let shift = (-1e4..1e4, -1e4..1e4).prop_map(|(x, y)| Vector2::new(x, y));
    (0.0..TAU, shift)
}

// What is done to curves and answers.

fn moved(curve: &Curve, (angle, shift): (f64, Vector2)) -> Curve {
    let (sin, cos) = angle.sin_cos();
    let turn = |p: Point2| Point2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y) + shift;
    let nodes = curve.nodes().iter().map(|n| n.moved_to(turn(n.position)));
    Curve::new(nodes.collect(), curve.is_closed()).unwrap()
}

fn closed(curve: &Curve) -> Curve {
    Curve::new(curve.nodes().to_vec(), true).unwrap()
}

/// Cuts an open curve at one of the nodes that lie well between its ends' overlaps, each of which
/// is less than `overlap` long; both pieces keep the node.
fn cut(curve: &Curve, overlap: f64, share: f64) -> [Curve; 2] {
    let nodes = curve.nodes();
    let units: Vec<_> = curve.units().map(|u| u.vector().norm()).collect();
    let arc = |k: usize| units[..k].iter().sum::<f64>();
    let free = |k: &usize| arc(*k) > overlap && arc(*k) < curve.length() - overlap;
    let between: Vec<_> = (0..nodes.len()).filter(free).collect();
    let at = between[(share * between.len() as f64) as usize];
    [&nodes[..=at], &nodes[at..]].map(|piece| Curve::new(piece.to_vec(), false).unwrap())
}

/// The one overlap of two curves.
fn single(found: &Overlaps) -> Result<Overlap, TestCaseError> {
    prop_assert_eq!(found.relation(), Relation::Single, "{:?}", found);
    Ok(found.as_slice()[0])
}

fn parts_of(overlap: &Overlap) -> (Parts, Parts) {
    (overlap.parts_a, overlap.parts_b)
}

// Laws.

proptest! {
    #[test]
    fn the_parts_a_pair_was_made_from_are_found_again(case in cases()) {
        let found = classify(&case.a, &case.b, &tolerance());
        let overlap = single(&found)?;
        prop_assert_eq!(parts_of(&overlap), (case.parts_a, case.parts_b));
        prop_assert_eq!(overlap.verdict, verdict(case.parts_a, case.parts_b));
    }

    #[test]
    fn the_pattern_a_pair_was_made_from_is_found_again(
        (pattern, case) in parts_in_patterns().prop_flat_map(|(p, parts)| (Just(p), cases_of(Just(parts)))),
        motion in motions(),
    ) {
        let (a, b) = (moved(&case.a, motion), moved(&case.b, motion));
        let verdict_of = |a: &Curve, b: &Curve| Ok(single(&classify(a, b, &tolerance()))?.verdict);
        let found: Result<_, TestCaseError> = verdict_of(&a, &b);
        prop_assert_eq!(found?, Verdict::Valid(pattern));
        let exchanged: Result<_, TestCaseError> = verdict_of(&b, &a);
        prop_assert_eq!(exchanged?, Verdict::Valid(pattern));
        let walked_back: Result<_, TestCaseError> = verdict_of(&a.reversed(), &b.reversed());
        prop_assert_eq!(walked_back?, Verdict::Valid(pattern).reversed());
    }

    #[test]
    fn a_pair_can_be_merged_exactly_if_there_is_no_fork(case in cases()) {
        let (a, b) = (case.parts_a, case.parts_b);
        let fork = a.begins_unenclosed && b.begins_unenclosed
            || a.ends_unenclosed && b.ends_unenclosed;
        prop_assert_eq!(can_be_merged(&classify(&case.a, &case.b, &tolerance())), !fork);
    }

    #[test]
    fn moving_both_curves_changes_nothing(case in cases(), motion in motions()) {
        let (a, b) = (moved(&case.a, motion), moved(&case.b, motion));
        let overlap = single(&classify(&a, &b, &tolerance()))?;
        prop_assert_eq!(parts_of(&overlap), (case.parts_a, case.parts_b));
    }

    #[test]
    fn exchanging_the_curves_exchanges_the_answer(case in cases()) {
        let there = single(&classify(&case.a, &case.b, &tolerance()))?;
        let back = single(&classify(&case.b, &case.a, &tolerance()))?;
        prop_assert_eq!(parts_of(&there), (back.parts_b, back.parts_a));
        prop_assert_eq!((there.on_a, there.on_b), (back.on_b, back.on_a));
        prop_assert_eq!(there.verdict, back.verdict);
    }

    #[test]
    fn walking_both_curves_back_exchanges_beginnings_and_ends(case in cases()) {
        let there = single(&classify(&case.a, &case.b, &tolerance()))?;
        let back = classify(&case.a.reversed(), &case.b.reversed(), &tolerance());
        let back = single(&back)?;
        prop_assert_eq!(back.verdict, there.verdict.reversed());
        let expected = (there.parts_a.reversed(), there.parts_b.reversed());
        prop_assert_eq!(parts_of(&back), expected);
        let length = case.a.length();
        prop_assert!((back.on_a.from - (length - there.on_a.to)).abs() < 1e-9);
        prop_assert!((back.on_a.to - (length - there.on_a.from)).abs() < 1e-9);
    }

    #[test]
    fn walking_one_curve_back_leaves_no_overlap(case in cases()) {
        let found = classify(&case.a, &case.b.reversed(), &tolerance());
        prop_assert_eq!(found.relation(), Relation::Apart);
    }

    #[test]
    fn the_enclosed_stretches_are_equally_long(case in cases()) {
        let overlap = single(&classify(&case.a, &case.b, &tolerance()))?;
        let (a, b) = (overlap.on_a.length(), overlap.on_b.length());
        // Noise of up to a tenth of the spacing lengthens a curve by 2 %; a fork is left late,
        // where curves are the distance apart, which noise moves.
        let late = 1.25 * DISTANCE;
        prop_assert!((a - b).abs() < 0.05 * a.max(b) + late, "{} and {}", a, b);
        for (range, curve) in [(overlap.on_a, &case.a), (overlap.on_b, &case.b)] {
            prop_assert!(range.from >= 0.0 && range.to <= curve.length());
            let nodes = nodes_within(&range, curve);
            prop_assert!(nodes.windows(2).all(|w| w[1] == w[0] + 1));
        }
    }

    #[test]
    fn a_ring_of_two_curves_has_two_overlaps((a, b) in rings(), motion in motions()) {
        let (a, b) = (moved(&a, motion), moved(&b, motion));
        for (p, q) in [(&a, &b), (&b, &a)] {
            let found = classify(p, q, &tolerance());
            prop_assert_eq!(found.relation(), Relation::Ring, "{:?}", found);
            prop_assert!(can_be_merged(&found));
        }
    }

    #[test]
    fn a_ring_cut_into_sections_of_one_overlap_each_obeys_rule_2(
        (a, b) in rings(), share in 0.0..1.0,
    ) {
        // What is left on either side of the cut is no stub.
        let clear = 2.0 + PART / 2.0;
        for (ring, whole) in [(&a, &b), (&b, &a)] {
            for section in cut(ring, clear, share) {
                let overlap = single(&classify(&section, whole, &tolerance()))?;
                prop_assert_eq!(overlap.verdict, Verdict::Valid(Pattern::EndToBeginning));
            }
        }
    }

    #[test]
    fn an_open_curve_on_a_closed_one_lies_on_its_middle(
        start in 0.0..ROUND, reach in PART..16.0, ring in samplings(), arc in samplings(),
    ) {
        // The last node of the ring stays one unit away from the first.
        let ring = closed(&sampled(circle, 0.0, ROUND - ring.spacing, &ring));
        let arc = sampled(circle, start, start + reach, &arc);
        for (p, q) in [(&ring, &arc), (&arc, &ring)] {
            let overlap = single(&classify(p, q, &tolerance()))?;
            prop_assert_eq!(overlap.verdict, Verdict::Valid(Pattern::WholeAndMiddle));
        }
    }

    #[test]
    fn two_closed_curves_around_the_same_solid_overlap_whole(
        turn in 0.0..ROUND, a in samplings(), b in samplings(),
    ) {
        let ring = |start: f64, sampling: &Sampling| {
            closed(&sampled(circle, start, start + ROUND - sampling.spacing, sampling))
        };
        let overlap = single(&classify(&ring(0.0, &a), &ring(turn, &b), &tolerance()))?;
        prop_assert_eq!(overlap.verdict, Verdict::Valid(Pattern::BothWhole));
    }
}

// Named cases.

fn along_x(places: &[(f64, f64)]) -> Curve {
    let nodes = places.iter().map(|&(x, y)| Node::at(Point2::new(x, y))).collect();
    Curve::new(nodes, false).unwrap()
}

#[test]
fn every_combination_of_table_5_1_is_found_on_straight_curves() {
    // The overlap is from 2 to 4; unenclosed parts begin at 0 and end at 6.
    for parts_a in Parts::ALL {
        for parts_b in Parts::ALL {
            let curve = |parts: Parts, height: f64| {
                let before = parts.begins_unenclosed.then_some((0.0, height));
                let behind = parts.ends_unenclosed.then_some((6.0, height));
                let inside = [(2.0, 0.0), (3.0, 0.0), (4.0, 0.0)];
                along_x(&before.into_iter().chain(inside).chain(behind).collect::<Vec<_>>())
            };
            let found = classify(&curve(parts_a, 0.0), &curve(parts_b, 1.0), &tolerance());
            assert_eq!(found.as_slice().len(), 1, "{parts_a:?} {parts_b:?}");
            let overlap = found.as_slice()[0];
            assert_eq!((overlap.parts_a, overlap.parts_b), (parts_a, parts_b));
            assert_eq!(overlap.verdict, verdict(parts_a, parts_b));
        }
    }
}

#[test]
fn a_bulge_in_one_of_two_curves_breaks_rule_2() {
    let straight = along_x(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (6.0, 0.0), (8.0, 0.0)]);
    let bulging = along_x(&[(0.0, 0.0), (2.0, 0.0), (4.0, 1.0), (6.0, 0.0), (8.0, 0.0)]);
    let found = classify(&straight, &bulging, &tolerance());
    assert_eq!((found.relation(), found.as_slice().len()), (Relation::Several, 2));
    assert!(!can_be_merged(&found));
    let verdicts: Vec<_> = found.as_slice().iter().map(|o| o.verdict).collect();
    assert_eq!(verdicts, [Verdict::Fork(Fork::AtEnd), Verdict::Fork(Fork::AtBeginning)]);
}

#[test]
fn a_short_stub_beyond_the_overlap_counts_as_nothing() {
    let straight = along_x(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0)]);
    let stub = along_x(&[(0.0, 0.0), (2.0, 0.0), (2.15, 0.15)]);
    let found = classify(&straight, &stub, &tolerance());
    assert_eq!(found.as_slice()[0].verdict, Verdict::Valid(Pattern::WholeAndBeginning));
    let longer = along_x(&[(0.0, 0.0), (2.0, 0.0), (3.0, 1.0)]);
    let found = classify(&straight, &longer, &tolerance());
    assert_eq!(found.as_slice()[0].verdict, Verdict::Fork(Fork::AtEnd));
}

#[test]
fn ends_that_touch_are_joined_and_ends_that_are_apart_are_not() {
    let first = along_x(&[(0.0, 0.0), (2.0, 0.0)]);
    let touching = along_x(&[(2.0, 0.0), (4.0, 0.0)]);
    let found = classify(&first, &touching, &tolerance());
    assert_eq!(found.relation(), Relation::Single);
    assert_eq!(found.as_slice()[0].verdict, Verdict::Valid(Pattern::EndToBeginning));
    let apart = along_x(&[(2.0 + 1.1 * DISTANCE, 0.0), (4.0, 0.0)]);
    assert_eq!(classify(&first, &apart, &tolerance()).relation(), Relation::Apart);
}

#[test]
fn of_two_ends_each_may_project_beyond_the_other() {
    let a = along_x(&[(3.2566, 0.7485), (3.5036, 0.6324)]);
    let b = along_x(&[(3.2590, 0.7614), (3.5065, 0.6384)]);
    let found = classify(&a, &b, &tolerance());
    assert_eq!(found.as_slice()[0].verdict, Verdict::Valid(Pattern::BothWhole));
}

#[test]
fn curves_without_length_overlap_nothing() {
    let point = along_x(&[(1.0, 0.0), (1.0, 0.0), (1.0, 0.0)]);
    let line = along_x(&[(0.0, 0.0), (2.0, 0.0)]);
    for point in [closed(&point), point] {
        assert_eq!(classify(&point, &line, &tolerance()).relation(), Relation::Apart);
        assert_eq!(classify(&line, &point, &tolerance()).relation(), Relation::Apart);
    }
}

#[test]
fn one_noisy_node_does_not_split_an_overlap() {
    let straight = along_x(&[(0.0, 0.0), (2.0, 0.0), (4.0, 0.0)]);
    let spike =
        [(0.0, 0.0), (1.0, 0.0), (1.93, 0.0), (2.0, 0.07), (2.07, 0.0), (3.0, 0.0), (4.0, 0.0)];
    let found = classify(&straight, &along_x(&spike), &tolerance());
    assert_eq!(found.relation(), Relation::Single);
    assert_eq!(found.as_slice()[0].verdict, Verdict::Valid(Pattern::BothWhole));
}

#[test]
fn an_overlap_over_the_first_node_of_a_closed_curve_is_one() {
    let square = along_x(&[(0.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
    let corner = along_x(&[(0.0, 1.0), (0.0, 0.0), (1.0, 0.0)]);
    let overlap = classify(&closed(&square), &corner, &tolerance()).as_slice()[0];
    assert_eq!((overlap.on_a.from, overlap.on_a.to), (7.0, 9.0));
    assert_eq!(nodes_within(&overlap.on_a, &closed(&square)), [0]);
    assert_eq!(overlap.verdict, Verdict::Valid(Pattern::WholeAndMiddle));
}

#[test]
fn tolerances_that_make_no_sense_are_refused() {
    assert!(OverlapTolerance::within(-1.0).is_err());
    assert!(OverlapTolerance::within(f64::NAN).is_err());
    assert!(OverlapTolerance::new(1.0, 3.0, 1.0).is_err());
    let text = OverlapTolerance::new(1.0, 0.5, f64::INFINITY).unwrap_err().to_string();
    assert_eq!(text, "an overlap tolerance must be a finite length of at least 0, got inf");
}

/// The indices of the curve's nodes within a stretch, in curve order.
fn nodes_within(range: &CurveRange, curve: &Curve) -> Vec<usize> {
    let mut arc = 0.0;
    let mut first_round = Vec::with_capacity(curve.nodes().len());
    for unit in curve.units() {
        first_round.push(arc);
        arc += unit.vector().norm();
    }
    let length = arc;
    if !curve.is_closed() {
        first_round.push(length);
    }
    let rounds = if curve.is_closed() { 2 } else { 1 };
    let places = (0..rounds)
        .flat_map(|round| first_round.iter().map(move |s| s + f64::from(round) * length));
    let within = |(_, s): &(usize, f64)| range.from <= *s && *s <= range.to;
    let count = curve.nodes().len();
    let nodes = places.enumerate().filter(within).map(|(i, _)| i % count);
    // A stretch all the way round meets its first node again.
    nodes.take(count).collect()
}

/// A page with what the code generates between its marks.
fn with_generated_blocks(page: &str) -> String {
    generated_blocks().into_iter().fold(page.to_owned(), |page, (name, block)| {
        let (begin, end) =
            (format!("<!-- generated: {name} -->\n"), format!("<!-- end of {name} -->"));
        let (before, rest) = page.split_once(&begin).unwrap();
        let (_, behind) = rest.split_once(&end).unwrap();
        format!("{before}{begin}{block}{end}{behind}")
    })
}

#[test]
fn the_page_shows_what_the_code_generates() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/overlap-rules.md");
    let page = std::fs::read_to_string(path).unwrap().replace("\r\n", "\n");
    let expected = with_generated_blocks(&page);
    if std::env::var_os("TRANSECT_WRITE_PAGES").is_some() {
        std::fs::write(path, &expected).unwrap();
        return;
    }
    assert!(page == expected, "docs/overlap-rules.md should be\n\n{expected}");
}
