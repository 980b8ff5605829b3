//! Open ends: joined where they meet and where the curve goes on, turned round thin tips, cut back where
//! they cross.
//!
//! All limits are in *local footprints*, those of the coarsest view around: one fixed length fails where
//! footprints differ sixfold.

use super::pieces::Piece;
use super::{Kept, Scale};
use crate::grid::PointGrid;
use transect_geometry::{Point2, Vector2};

/// How two ends may be joined.
#[derive(Debug, Clone, Copy)]
pub(super) struct JoinRule {
    /// Longest gap, in local footprints.
    pub gap_footprints: f64,
    /// Smallest and largest cosine between the directions of the two ends.
    pub turn_cosine: (f64, f64),
    /// How far back from an end the other may lie, as a cosine.
    pub backward: f64,
    /// Nodes that may be cut from each end to find where the two come closest.
    pub cut_nodes: usize,
}

impl JoinRule {
    /// How far apart two ends may be before anything is cut, if this is their larger spacing.
    fn farthest(&self, spacing: f64, scale: &Scale) -> f64 {
        ((2 * self.cut_nodes) as f64 + self.gap_footprints) * spacing + scale.threshold
    }
}

/// The rules in their order: what meets, what goes on, what turns, and what crosses.
pub(super) const RULES: [JoinRule; 4] = [MEETING, SMOOTH, HAIRPIN, CROSSING];

/// Ends that meet, whatever the turn: they belong together before anything is cut or bridged. Wider, a
/// small gap round a corner would win over a longer one straight on.
const MEETING: JoinRule =
    JoinRule { gap_footprints: 0.7, turn_cosine: (-1.0, 1.0), backward: -0.7, cut_nodes: 0 };

/// A smooth continuation; ends that pass beside each other are cut until the gap leads forward.
const SMOOTH: JoinRule =
    JoinRule { gap_footprints: 4.0, turn_cosine: (0.5, 1.0), backward: 0.3, cut_nodes: 8 };

/// A sharp bend or a thin tip, where the curve turns back on itself.
const HAIRPIN: JoinRule =
    JoinRule { gap_footprints: 4.0, turn_cosine: (-1.0, 0.5), backward: -0.7, cut_nodes: 0 };

/// Ends that overshoot a rim and cross, or pass each other.
const CROSSING: JoinRule =
    JoinRule { gap_footprints: 2.5, turn_cosine: (-1.0, 0.5), backward: -1.0, cut_nodes: 10 };

/// What a node that is cut adds to the cost of a join, in its footprints.
const CUT_COST: f64 = 0.3;

/// Part of the overlap threshold by which gaps may be longer: ends of two views' curves may lie that
/// far apart sideways.
const GAP_SHARE: f64 = 0.25;

/// Joins ends of pieces, cheapest first, until no two fit the rule.
pub(super) fn join(
    kept: &[Kept],
    pieces: Vec<Piece>,
    scale: &Scale,
    rule: &JoinRule,
) -> Vec<Piece> {
    let mut slots: Vec<Option<Piece>> = pieces.into_iter().map(Some).collect();
    loop {
        let joins = candidates(kept, &slots, scale, rule);
        if joins.is_empty() {
            return slots.into_iter().flatten().collect();
        }
        // Each piece takes part once per round; the next round sees the longer pieces.
        let mut busy = vec![false; slots.len()];
        for j in joins {
            if !busy[j.tail] && !busy[j.head] {
                (busy[j.tail], busy[j.head]) = (true, true);
                apply(&mut slots, &j);
            }
        }
    }
}

/// The tail of one piece goes on at the head of another, or of itself.
#[derive(Debug, Clone, Copy)]
struct Join {
    cost: f64,
    tail: usize,
    head: usize,
    /// Nodes cut from the tail's end and the head's beginning.
    cut: (usize, usize),
}

fn candidates(kept: &[Kept], slots: &[Option<Piece>], scale: &Scale, rule: &JoinRule) -> Vec<Join> {
    let open = |k: &usize| slots[*k].as_ref().is_some_and(|p| !p.closed);
    let open: Vec<usize> = (0..slots.len()).filter(open).collect();
    let end = |&k: &usize, last: bool| {
        let nodes = slots[k].as_ref().map_or(&[][..], |p| &p.nodes);
        let node = if last { nodes.last() } else { nodes.first() };
        node.map(|&n| End {
            position: kept[n as usize].position,
            spacing: kept[n as usize].spacing,
        })
    };
    let tails: Vec<End> = open.iter().filter_map(|k| end(k, true)).collect();
    let heads: Vec<End> = open.iter().filter_map(|k| end(k, false)).collect();
    let mut joins: Vec<Join> = Vec::new();
    neighbours(&tails, &heads, scale, rule, |tail, head| {
        let (tail, head) = (open[tail], open[head]);
        if let (Some(a), Some(b)) = (&slots[tail], &slots[head]) {
            let fit = fit(kept, (a, b), tail == head, scale, rule);
            joins.extend(fit.map(|(cost, cut)| Join { cost, tail, head, cut }));
        }
    });
    joins.sort_by(|a, b| a.cost.total_cmp(&b.cost).then((a.tail, a.head).cmp(&(b.tail, b.head))));
    joins
}

/// An open end of a piece.
#[derive(Debug, Clone, Copy)]
struct End {
    position: Point2,
    spacing: f64,
}

/// Visits every tail and head close enough for the rule. How close depends on the larger spacing
/// of the two, so each pair is found from that one.
fn neighbours(
    tails: &[End],
    heads: &[End],
    scale: &Scale,
    rule: &JoinRule,
    mut visit: impl FnMut(usize, usize),
) {
    let places = |ends: &[End]| ends.iter().map(|e| e.position).collect::<Vec<Point2>>();
    let cell = rule.farthest(scale.spacing, scale);
    let (tail_grid, head_grid) =
        (PointGrid::new(&places(tails), cell), PointGrid::new(&places(heads), cell));
    for (t, tail) in tails.iter().enumerate() {
        head_grid.within(&tail.position, rule.farthest(tail.spacing, scale), |h, _| {
            if heads[h].spacing <= tail.spacing {
                visit(t, h);
            }
        });
    }
    for (h, head) in heads.iter().enumerate() {
        tail_grid.within(&head.position, rule.farthest(head.spacing, scale), |t, _| {
            if tails[t].spacing < head.spacing {
                visit(t, h);
            }
        });
    }
}

/// Cost of joining the tail of one piece to the head of another, and what to cut; `None` if they do
/// not fit the rule.
fn fit(
    kept: &[Kept],
    (a, b): (&Piece, &Piece),
    itself: bool,
    scale: &Scale,
    rule: &JoinRule,
) -> Option<(f64, (usize, usize))> {
    let (tail, head) = (kept[*a.nodes.last()? as usize], kept[*b.nodes.first()? as usize]);
    let shortest = a.nodes.len().min(b.nodes.len());
    let most = rule.cut_nodes.min(if itself { shortest / 3 } else { shortest / 2 });
    // What overshoots points elsewhere than the curve it is cut back to.
    let leaving: Vec<Vector2> = (0..=most).map(|cut| a.direction(kept, true, cut)).collect();
    let arriving: Vec<Vector2> = (0..=most).map(|cut| b.direction(kept, false, cut)).collect();
    let mut best: Option<(f64, (usize, usize))> = None;
    for (cut_a, cut_b) in (0..=most).flat_map(|a| (0..=most).map(move |b| (a, b))) {
        let (leaving, arriving) = (leaving[cut_a], arriving[cut_b]);
        let turn = leaving.dot(&arriving);
        if turn < rule.turn_cosine.0 || turn > rule.turn_cosine.1 + 1e-9 {
            continue;
        }
        let p = kept[a.nodes[a.nodes.len() - 1 - cut_a] as usize];
        let q = kept[b.nodes[cut_b] as usize];
        let gap = q.position - p.position;
        let longest = rule.gap_footprints * p.spacing.max(q.spacing) + GAP_SHARE * scale.threshold;
        let (leave, arrive) = (gap_cosine(&gap, &leaving), gap_cosine(&gap, &arriving));
        let fits = gap.norm() <= longest && leave.min(arrive) >= rule.backward;
        let lost = cut_a as f64 * tail.footprint + cut_b as f64 * head.footprint;
        let cost = gap.norm() * (3.0 - leave - arrive) + CUT_COST * lost;
        if fits && best.is_none_or(|(c, _)| cost < c) {
            best = Some((cost, (cut_a, cut_b)));
        }
    }
    // Closing needs enough nodes to be left for a ring.
    best.filter(|(_, (x, y))| !itself || a.nodes.len() >= x + y + 4)
}

fn gap_cosine(gap: &Vector2, direction: &Vector2) -> f64 {
    gap.try_normalize(0.0).map_or(1.0, |g| g.dot(direction))
}

fn apply(slots: &mut [Option<Piece>], join: &Join) {
    let Some(mut tail) = slots[join.tail].take() else { return };
    tail.nodes.truncate(tail.nodes.len() - join.cut.0);
    if join.tail == join.head {
        tail.nodes.drain(..join.cut.1);
        tail.closed = true;
    } else if let Some(head) = slots[join.head].take() {
        tail.nodes.extend(head.nodes.into_iter().skip(join.cut.1));
    }
    slots[join.tail] = Some(tail);
}

#[cfg(test)]
mod tests {
    use super::super::link::spread_spacing;
    use super::*;

    const SCALE: Scale = Scale {
        spacing: 0.003,
        threshold: 0.001,
        threshold_spreads: 8.0,
        same_way: 0.6,
        steps: super::super::Steps::ALL,
    };

    /// Adds a piece of some nodes.
    fn add(kept: &mut Vec<Kept>, nodes: impl IntoIterator<Item = Kept>) -> Piece {
        let first = kept.len() as u32;
        kept.extend(nodes);
        Piece { nodes: (first..kept.len() as u32).collect(), closed: false }
    }

    fn node(x: f64, y: f64, tangent: Vector2, footprint: f64) -> Kept {
        Kept::new(Point2::new(x, y), tangent, footprint)
    }

    /// A node on the x axis.
    fn on_axis((x, footprint): (f64, f64)) -> Kept {
        node(x, 0.0, Vector2::x(), footprint)
    }

    #[test]
    fn no_gap_is_where_one_coarse_sample_lies_next_to_the_other() {
        let fine = |from: u32, to: u32| (from..to).map(|k| on_axis((0.003 * f64::from(k), 0.003)));
        let mut kept = Vec::new();
        // Coarse samples have taken in the fine ones around them, but for one at each end.
        let between = [(0.39, 0.003), (0.40, 0.06), (0.46, 0.06), (0.475, 0.003)].map(on_axis);
        let pieces = vec![
            add(&mut kept, fine(0, 121)),
            add(&mut kept, between),
            add(&mut kept, fine(170, 300)),
        ];
        spread_spacing(&mut kept, &SCALE);
        let joined = join(&kept, pieces, &SCALE, &SMOOTH);
        assert_eq!(joined.len(), 1);
        assert_eq!(joined[0].nodes.len(), kept.len(), "nothing need be cut");
    }

    #[test]
    fn a_short_jamb_is_not_cut_off() {
        // A wall, a jamb of three samples that begins and ends where others do, and the wall behind.
        let mut kept = Vec::new();
        let wall = |from: f64, y: f64| {
            (0..10).map(move |k| node(from + 0.02 * f64::from(k), y, Vector2::x(), 0.02))
        };
        let jamb = [-0.01, -0.03, -0.05].map(|y| node(0.0, y, -Vector2::y(), 0.02));
        let mut pieces = vec![
            add(&mut kept, wall(-0.18, 0.0)),
            add(&mut kept, jamb),
            add(&mut kept, wall(0.01, -0.06)),
        ];
        for rule in RULES {
            pieces = join(&kept, pieces, &SCALE, &rule);
        }
        assert_eq!(pieces.len(), 1);
        assert_eq!(pieces[0].nodes.len(), kept.len(), "nothing need be cut");
    }
}
