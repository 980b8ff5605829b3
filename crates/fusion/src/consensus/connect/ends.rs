//! Open ends: joined where they meet and where the curve goes on, turned round thin tips, cut back
//! where they cross.
//!
//! All limits are in *local footprints*, those of the coarsest view around: one fixed length fails
//! where footprints differ sixfold.

use super::super::estimate::PlacedNode;
use super::super::measure::Scale;
pub(super) use super::super::tuning::ends::JoinRule;
use super::super::tuning::ends::{CUT_COST, CUT_PARTS, LEAST_CLOSED, THRESHOLD_SHARE};
use super::chain::Chain;
use crate::grid::PointGrid;
use crate::ground::Ground;
use transect_geometry::{Point2, Vector2};

impl JoinRule {
    /// How far apart two ends may be before anything is cut, if this is their larger spacing.
    fn farthest(&self, spacing: f64, scale: &Scale) -> f64 {
        ((2 * self.cut_nodes) as f64 + self.gap_footprints) * spacing + scale.threshold
    }
}

/// Joins ends of chains, cheapest first, until no two fit the rule.
pub(super) fn join(
    nodes: &[PlacedNode],
    chains: Vec<Chain>,
    ground: &Ground<'_>,
    scale: &Scale,
    rule: &JoinRule,
) -> Vec<Chain> {
    let mut slots: Vec<Option<Chain>> = chains.into_iter().map(Some).collect();
    loop {
        let joins = candidates(nodes, &slots, ground, scale, rule);
        if joins.is_empty() {
            return slots.into_iter().flatten().collect();
        }
        // Each chain takes part once per round; the next round sees the longer chains.
        let mut busy = vec![false; slots.len()];
        for j in joins {
            if !busy[j.tail] && !busy[j.head] {
                (busy[j.tail], busy[j.head]) = (true, true);
                apply(&mut slots, &j);
            }
        }
    }
}

/// The tail of one chain goes on at the head of another, or of itself.
#[derive(Debug, Clone, Copy)]
struct Join {
    tail: usize,
    head: usize,
    fit: JoinFit,
}

/// Nodes cut from the tail's end and the head's beginning, and the cost of joining what is left.
#[derive(Debug, Clone, Copy)]
struct JoinFit {
    cost: f64,
    cut_tail: usize,
    cut_head: usize,
}

fn candidates(
    nodes: &[PlacedNode],
    slots: &[Option<Chain>],
    ground: &Ground<'_>,
    scale: &Scale,
    rule: &JoinRule,
) -> Vec<Join> {
    let open: Vec<(usize, &Chain)> = slots
        .iter()
        .enumerate()
        .filter_map(|(k, slot)| Some((k, slot.as_ref().filter(|c| !c.closed)?)))
        .collect();
    let end = |number: Option<&u32>| Some(nodes[*number? as usize]);
    let heads: Vec<PlacedNode> = open.iter().filter_map(|(_, c)| end(c.nodes.first())).collect();
    let places: Vec<Point2> = heads.iter().map(|head| head.position).collect();
    let grid = PointGrid::new(&places, rule.farthest(scale.spacing, scale));
    let widest = heads.iter().map(|head| head.spacing).fold(0.0, f64::max);
    let mut joins: Vec<Join> = Vec::new();
    for &(tail, a) in &open {
        let Some(at) = end(a.nodes.last()) else { continue };
        grid.within(&at.position, rule.farthest(at.spacing.max(widest), scale), |h, d| {
            let (head, b) = open[h];
            let pair = Pair { nodes, ground, tail: a, head: b, is_one: tail == head };
            // How far the rule reaches depends on the larger spacing of the two.
            if d.norm() <= rule.farthest(at.spacing.max(heads[h].spacing), scale) {
                joins.extend(pair.best_fit(scale, rule).map(|fit| Join { tail, head, fit }));
            }
        });
    }
    joins.sort_by(|a, b| {
        a.fit.cost.total_cmp(&b.fit.cost).then((a.tail, a.head).cmp(&(b.tail, b.head)))
    });
    joins
}

/// The two chains of a join.
struct Pair<'a> {
    nodes: &'a [PlacedNode],
    ground: &'a Ground<'a>,
    tail: &'a Chain,
    head: &'a Chain,
    /// Whether both are one chain, which joining closes.
    is_one: bool,
}

impl Pair<'_> {
    /// The cheapest way to join the tail to the head; `None` if no way fits the rule.
    fn best_fit(&self, scale: &Scale, rule: &JoinRule) -> Option<JoinFit> {
        let Self { nodes, tail, head, is_one, .. } = *self;
        let [last, first] = [tail.nodes.last()?, head.nodes.first()?].map(|k| &nodes[*k as usize]);
        // Where nodes are cut, the ends are farther from the range jumps, but the ground is the
        // same.
        if last.turns_in_shadow(first, self.ground) {
            return None;
        }
        let shortest = tail.nodes.len().min(head.nodes.len());
        let most = rule.cut_nodes.min(shortest / CUT_PARTS[usize::from(is_one)]);
        // An overshooting end points elsewhere than the curve it is cut back to.
        let leaving: Vec<Vector2> = (0..=most).map(|c| tail.direction(nodes, true, c)).collect();
        let arriving: Vec<Vector2> = (0..=most).map(|c| head.direction(nodes, false, c)).collect();
        let lost_of_tail = lost(nodes, tail.nodes.iter().rev().take(most));
        let lost_of_head = lost(nodes, head.nodes.iter().take(most));
        let mut best: Option<JoinFit> = None;
        for (cut_tail, leaving) in leaving.iter().enumerate() {
            for (cut_head, arriving) in arriving.iter().enumerate() {
                let p = &nodes[tail.nodes[tail.nodes.len() - 1 - cut_tail] as usize];
                let q = &nodes[head.nodes[cut_head] as usize];
                let Some(cost) = gap_cost([p, q], [leaving, arriving], scale, rule) else {
                    continue;
                };
                let cost = cost + CUT_COST * (lost_of_tail[cut_tail] + lost_of_head[cut_head]);
                let is_best = best.is_none_or(|b| cost < b.cost);
                if is_best && !p.is_across_shadow(q, self.ground, scale) {
                    best = Some(JoinFit { cost, cut_tail, cut_head });
                }
            }
        }
        // Enough nodes must be left for a closed curve. A dearer cut that leaves enough is not
        // taken instead: it changes the bundled room's 95 % distance by 0.1 %.
        best.filter(|b| !is_one || tail.nodes.len() >= b.cut_tail + b.cut_head + LEAST_CLOSED)
    }
}

/// The footprints of none, one, two and more of the nodes, together.
fn lost<'a>(nodes: &[PlacedNode], cut: impl Iterator<Item = &'a u32>) -> Vec<f64> {
    let mut sum = 0.0;
    let footprints = cut.map(|k| {
        sum += nodes[*k as usize].evidence.footprint;
        sum
    });
    std::iter::once(0.0).chain(footprints).collect()
}

/// Cost of the gap between two nodes, at which the curve has these directions; `None` if the gap
/// does not fit the rule.
fn gap_cost(
    [p, q]: [&PlacedNode; 2],
    directions: [&Vector2; 2],
    scale: &Scale,
    rule: &JoinRule,
) -> Option<f64> {
    let turn = directions[0].dot(directions[1]);
    if turn < rule.cosines[0] || turn > rule.cosines[1] + 1e-9 {
        return None;
    }
    let gap = q.position - p.position;
    let longest =
        rule.gap_footprints * p.spacing.max(q.spacing) + THRESHOLD_SHARE * scale.threshold;
    let cosine = |direction: &Vector2| gap.try_normalize(0.0).map_or(1.0, |g| g.dot(direction));
    let [leave, arrive] = directions.map(cosine);
    let fits = gap.norm() <= longest && leave.min(arrive) >= rule.backward;
    fits.then(|| gap.norm() * (3.0 - leave - arrive))
}

fn apply(slots: &mut [Option<Chain>], join: &Join) {
    let Some(mut tail) = slots[join.tail].take() else { return };
    tail.nodes.truncate(tail.nodes.len() - join.fit.cut_tail);
    if join.tail == join.head {
        tail.nodes.drain(..join.fit.cut_head);
        tail.closed = true;
    } else if let Some(head) = slots[join.head].take() {
        tail.nodes.extend(head.nodes.into_iter().skip(join.fit.cut_head));
    }
    slots[join.tail] = Some(tail);
}

#[cfg(test)]
mod tests {
    use super::super::link::spread_spacing;
    use super::*;
    use crate::consensus::Steps;
    use crate::consensus::measure::Observations;
    use crate::consensus::options::ConsensusOptions;
    use transect_geometry::{Curve, EndReason};

    fn scale() -> Scale {
        let options = ConsensusOptions::default();
        Scale { spacing: 0.003, threshold: 0.001, same_way: 0.6, settled: false, options }
    }

    fn joined(nodes: &[PlacedNode], chains: Vec<Chain>, rule: &JoinRule) -> Vec<Chain> {
        let (observations, grid) = (Observations::default(), PointGrid::new(&[], 1.0));
        join(nodes, chains, &Ground::new(&observations, &grid), &scale(), rule)
    }

    /// Adds a chain of some nodes.
    fn add(nodes: &mut Vec<PlacedNode>, more: impl IntoIterator<Item = PlacedNode>) -> Chain {
        let first = nodes.len() as u32;
        nodes.extend(more);
        Chain { nodes: (first..nodes.len() as u32).collect(), closed: false }
    }

    fn node(x: f64, y: f64, tangent: Vector2, footprint: f64) -> PlacedNode {
        PlacedNode::at(Point2::new(x, y), tangent, footprint)
    }

    /// A node on the x axis.
    fn on_axis((x, footprint): (f64, f64)) -> PlacedNode {
        node(x, 0.0, Vector2::x(), footprint)
    }

    #[test]
    fn no_gap_is_where_one_coarse_sample_lies_next_to_the_other() {
        let fine = |from: u32, to: u32| (from..to).map(|k| on_axis((0.003 * f64::from(k), 0.003)));
        let mut nodes = Vec::new();
        // Coarse samples have taken in the fine ones around them, but for one at each end.
        let between = [(0.39, 0.003), (0.40, 0.06), (0.46, 0.06), (0.475, 0.003)].map(on_axis);
        let chains = vec![
            add(&mut nodes, fine(0, 121)),
            add(&mut nodes, between),
            add(&mut nodes, fine(170, 300)),
        ];
        spread_spacing(&mut nodes, &scale());
        let joined = joined(&nodes, chains, &JoinRule::SMOOTH);
        assert_eq!(joined.len(), 1);
        assert_eq!(joined[0].nodes.len(), nodes.len(), "nothing need be cut");
    }

    #[test]
    fn a_node_that_is_cut_costs_its_own_footprint() {
        let nodes = [0.003, 0.06, 0.06].map(|footprint| on_axis((0.0, footprint)));
        assert_eq!(lost(&nodes, [0, 1, 2].iter()), [0.0, 0.003, 0.003 + 0.06, 0.003 + 0.06 + 0.06]);
        assert_eq!(lost(&nodes, [].iter()), [0.0]);
    }

    #[test]
    fn a_short_jamb_is_not_cut_off() {
        // A wall, a jamb of three samples that begins and ends where others do, and the wall
        // behind.
        let mut nodes = Vec::new();
        let wall = |from: f64, y: f64| {
            (0..10).map(move |k| node(from + 0.02 * f64::from(k), y, Vector2::x(), 0.02))
        };
        let jamb = [-0.01, -0.03, -0.05].map(|y| node(0.0, y, -Vector2::y(), 0.02));
        let mut chains = vec![
            add(&mut nodes, wall(-0.18, 0.0)),
            add(&mut nodes, jamb),
            add(&mut nodes, wall(0.01, -0.06)),
        ];
        let rules = [JoinRule::MEETING, JoinRule::SMOOTH, JoinRule::HAIRPIN, JoinRule::CROSSING];
        for rule in rules {
            chains = joined(&nodes, chains, &rule);
        }
        assert_eq!(chains.len(), 1);
        assert_eq!(chains[0].nodes.len(), nodes.len(), "nothing need be cut");
    }

    #[test]
    fn ends_that_are_cut_keep_their_shadows() {
        // A coarse wall ends at the origin. A fine one across begins 0.2 farther.
        let mut nodes = Vec::new();
        let wall = (-5..=0).map(|k| on_axis((0.1 * f64::from(k), 0.1)));
        let across = |k: i32| node(0.2, 0.01 * f64::from(k), Vector2::y(), 0.01);
        let chains = vec![add(&mut nodes, wall), add(&mut nodes, (0..30).map(across))];
        let joins = |reason: EndReason| {
            let curves = chains.iter().map(|chain| {
                let nodes = chain.nodes.iter().map(|k| nodes[*k as usize].node()).collect();
                Curve::new(nodes, false).unwrap().with_ends([Some(reason); 2])
            });
            let curves: Vec<Curve> = curves.collect();
            let observations = Observations::collect(&[&curves], &Steps::default());
            let grid = PointGrid::new(&observations.positions(), observations.spacing());
            let ground = Ground::new(&observations, &grid);
            let rules =
                [JoinRule::MEETING, JoinRule::SMOOTH, JoinRule::HAIRPIN, JoinRule::CROSSING];
            let chains = rules
                .iter()
                .fold(chains.clone(), |chains, rule| join(&nodes, chains, &ground, &scale(), rule));
            chains.len() == 1
        };
        assert!(joins(EndReason::MissingPixel));
        assert!(!joins(EndReason::RangeJump));
    }
}
