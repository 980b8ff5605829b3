//! The fast sweep against the slow, obvious one, and against itself however the work is cut.

use crate::common::{planes_along, random_views};
use crate::oracle::{Chain, Crossing};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use transect_device::{Neighbour, PairGeometry, Pixel, Point3, Vector3, View};
use transect_geometry::Point2;
use transect_partial::one_pass::{
    Contours, Effort, Instructions, Kind, Polyline, Vertex, Workspace, contours, seen,
};
use transect_partial::{BreakRule, SectionAxes};

/// A vertex's pair, in the order of rows and columns.
fn pair(contours: &Contours<'_>, vertex: &Vertex) -> [Pixel; 2] {
    let (_, [a, b]) = contours.pair(vertex);
    if (a.row, a.col) <= (b.row, b.col) { [a, b] } else { [b, a] }
}

/// How far the fast vertex of a crossing may be from its place.
///
/// Levels in `f32` are wrong by a few units in the last place of what they are made of. This moves
/// the crossing by that over the pair's difference in level. Rounding of `t` may, too.
fn tolerance(crossing: &Crossing, view: &View, axes: &SectionAxes) -> f64 {
    let p = view.point_in_sensor(crossing.pair[0]).unwrap();
    let [a, b] = crossing.levels;
    let (gradient, constant) = (axes.level().gradient.norm(), axes.level().constant.abs());
    let rounding = 2_f64.powi(-21);
    let level = rounding * (gradient * p.coords.norm() + constant);
    let share = (2.0 * level / (a - b).abs()).min(1.0);
    share * crossing.length + rounding * (p.coords.norm() + crossing.length) + 1e-9
}

/// The in-plane place of a vertex, between the samples of its pair.
fn place(contours: &Contours<'_>, vertex: &Vertex, view: &View, axes: &SectionAxes) -> Point2 {
    let (_, pair) = contours.pair(vertex);
    let [a, b] = pair.map(|pixel| axes.in_plane(&view.point_in_sensor(pixel).unwrap()));
    a + f64::from(vertex.t) * (b - a)
}

fn same_line(
    line: &Polyline<'_>,
    chain: &Chain,
    contours: &Contours<'_>,
    (view, axes): (&View, &SectionAxes),
) -> bool {
    let n = line.vertices.len();
    if line.closed != chain.closed || chain.crossings.len() != n {
        return false;
    }
    let first = pair(contours, &line.vertices[0]);
    let Some(turn) = chain.crossings.iter().position(|c| c.pair == first) else { return false };
    (line.closed || turn == 0)
        && line.vertices.iter().enumerate().all(|(k, v)| {
            let crossing = &chain.crossings[(k + turn) % n];
            let apart = (place(contours, v, view, axes) - crossing.position).norm();
            pair(contours, v) == crossing.pair && apart <= tolerance(crossing, view, axes)
        })
}

/// Lines by plane and by the smallest pair they pass, which no two of a plane share.
fn key(level: i32, pairs: impl Iterator<Item = [Pixel; 2]>) -> (i32, Option<[(usize, usize); 2]>) {
    (level, pairs.map(|pair| pair.map(|p| (p.row, p.col))).min())
}

type Lines = (Vec<(i32, bool, usize)>, Vec<[u32; 2]>);

/// All bits of a result.
fn bits(
    view: &View,
    axes: &SectionAxes,
    rule: &BreakRule,
    effort: &Effort,
    work: &mut Workspace,
) -> Lines {
    let found = contours(view, axes, rule, effort, work).unwrap();
    let lines = found.polylines().map(|l| (l.level, l.closed, l.vertices.len())).collect();
    let vertices = found.polylines().flat_map(|l| l.vertices.to_vec());
    (lines, vertices.map(|v| [v.edge, v.t.to_bits()]).collect())
}

fn rules() -> impl Strategy<Value = BreakRule> {
    (0.5..1.55_f64, prop_oneof![Just(0.0), 0.0..0.3])
        .prop_map(|(a, slack)| BreakRule::new(a, slack))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn lines_are_those_of_the_slow_way(
        view in random_views(), normal in crate::common::normals(), interval in 0.02..0.4, rule in rules(),
    ) {
        let axes = SectionAxes::new(&view, &planes_along(normal, interval)).unwrap();
        let mut work = Workspace::default();
        let seen = seen(&view, &axes, &rule, Instructions::Best);
        let slow = crate::oracle::chains(&view, &axes, &seen);
        let fast = contours(&view, &axes, &rule, &Effort::default(), &mut work).unwrap();
        let mut slow: Vec<&Chain> = slow.iter().collect();
        slow.sort_by_key(|c| key(c.crossings[0].level, c.crossings.iter().map(|c| c.pair)));
        let mut lines: Vec<_> = fast.polylines().collect();
        lines.sort_by_key(|l| key(l.level, l.vertices.iter().map(|v| pair(&fast, v))));
        prop_assert_eq!(lines.len(), slow.len());
        for (line, chain) in lines.iter().zip(slow) {
            prop_assert_eq!(line.level, chain.crossings[0].level);
            prop_assert!(same_line(line, chain, &fast, (&view, &axes)), "{:?} {:?}", line, chain);
        }
    }

    #[test]
    fn no_cut_changes_a_bit(
        view in random_views(), normal in crate::common::normals(), interval in 0.02..0.4, rule in rules(),
    ) {
        let axes = SectionAxes::new(&view, &planes_along(normal, interval)).unwrap();
        let mut work = Workspace::default();
        let whole = bits(&view, &axes, &rule, &Effort::default(), &mut work);
        for parts in [1, 2, 3, 5, 8] {
            for band_size in [0, 20, 300, 1 << 15] {
                let effort = Effort { parts, band_size, ..Effort::default() };
                let cut = bits(&view, &axes, &rule, &effort, &mut work);
                prop_assert!(cut == whole, "{} parts, bands of {}", parts, band_size);
            }
        }
    }

    #[test]
    fn no_instruction_changes_a_bit(
        view in random_views(), normal in crate::common::normals(), interval in 0.02..0.4, rule in rules(),
    ) {
        let axes = SectionAxes::new(&view, &planes_along(normal, interval)).unwrap();
        let with = |instructions| {
            let effort = Effort { instructions, ..Effort::default() };
            bits(&view, &axes, &rule, &effort, &mut Workspace::default())
        };
        let portable = with(Instructions::Portable);
        prop_assert!(with(Instructions::Avx2) == portable);
        prop_assert!(with(Instructions::Best) == portable);
    }

    #[test]
    fn levels_are_right_to_the_stated_bound(
        view in random_views(), normal in crate::common::normals(), interval in 0.02..0.4,
    ) {
        let axes = SectionAxes::new(&view, &planes_along(normal, interval)).unwrap();
        let seen = seen(&view, &axes, &BreakRule::new(1.0, 0.0), Instructions::Best);
        let cols = view.image().size().cols;
        for (k, level) in seen.levels.iter().enumerate() {
            let point = view.point_in_sensor(Pixel::new(k / cols, k % cols));
            prop_assert_eq!(point.is_none(), level.is_nan());
            let Some(p) = point else { continue };
            let size = axes.level().gradient.norm() * p.coords.norm() + axes.level().constant.abs();
            let bound = 2_f64.powi(-22) * size;
            prop_assert!((f64::from(*level) - axes.level().at(&p)).abs() <= bound);
        }
    }

    #[test]
    fn pairs_are_joined_as_the_rule_says(view in random_views(), rule in rules()) {
        let axes = SectionAxes::new(&view, &planes_along(Vector3::z(), 0.1)).unwrap();
        let seen = seen(&view, &axes, &rule, Instructions::Best);
        let (frame, size) = (view.frame(), view.image().size());
        let mut pairs = vec![PairGeometry::MISSING; size.cols];
        for (neighbour, joined) in [(Neighbour::Left, &seen.left), (Neighbour::Up, &seen.up)] {
            for row in 0..size.rows {
                frame.pair_row(view.image(), row, neighbour, &mut pairs);
                for (col, pair) in pairs.iter().enumerate() {
                    let here = view.point_in_sensor(Pixel::new(row, col)).unwrap_or(Point3::origin());
                    let limit = rule.tan_incidence() * pair.lateral + rule.slack();
                    // Where the range step is the limit to the rounding of a range, either will do.
                    let close = 1e-6 * (here.coords.norm() as f32 + pair.range_step + limit);
                    let either = (pair.range_step - limit).abs() <= close;
                    prop_assert!(either || joined[row * size.cols + col] == rule.holds(pair));
                }
            }
        }
    }
}

#[test]
fn vertices_name_their_pairs() {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut kinds, mut closed) = ([0; 4], 0);
    for _ in 0..40 {
        let view = random_views().new_tree(&mut runner).unwrap().current();
        let axes = SectionAxes::new(&view, &planes_along(Vector3::z(), 0.1)).unwrap();
        let mut work = Workspace::default();
        let rule = BreakRule::new(1.3, 0.1);
        let found = contours(&view, &axes, &rule, &Effort::default(), &mut work).unwrap();
        for line in found.polylines() {
            closed += usize::from(line.closed);
            for vertex in line.vertices {
                let (kind, [a, b]) = found.pair(vertex);
                kinds[kind as usize] += 1;
                let (down, across) = (a.row.abs_diff(b.row), a.col.abs_diff(b.col));
                let last = view.image().size().cols - 1;
                let beside = across == 1 || across == last;
                assert!(match kind {
                    Kind::Up => down == 1 && across == 0,
                    Kind::Left => down == 0 && (beside || last == 0),
                    Kind::Rising | Kind::Falling => down == 1 && (beside || last == 0),
                });
                assert!((0.0..=1.0).contains(&vertex.t));
            }
        }
    }
    assert!(kinds.iter().all(|count| *count > 100) && closed > 20, "{kinds:?}, {closed} closed");
}
