//! The tree against a list of lists that is searched from end to end.

use super::*;
use crate::samples::{empty, rectangle, strip, tangles};
use proptest::prelude::*;
use transect_geometry::Point2;

/// Planes in any order, each with its curves as nodes and whether they are closed.
type Plain = Vec<(i64, Vec<(Vec<Node>, bool)>)>;

#[derive(Debug, Clone)]
enum Step {
    Set(i64, Vec<Curve>),
    Insert(i64, Curve),
    Remove(i64, usize),
    Split(i64, usize, usize),
    Join(i64, usize, usize),
    InsertNode(i64, usize, usize, f64),
    RemoveNode(i64, usize, usize),
    ReplaceNode(i64, usize, usize, f64),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let plane = || prop_oneof![8 => 0..2i64, 2 => -2..3i64, 1 => Just(i64::MAX)];
    let partner = || prop_oneof![0..4usize, Just(ITSELF), Just(LAST)];
    let (curve, node) = (|| 0..4usize, || 0..13usize);
    let one = tangles().prop_map(|mut curves| curves.swap_remove(0));
    // Now and then a coordinate that is none.
    let x = || prop_oneof![9 => -5.0..5.0, 1 => Just(f64::NAN)];
    let step = prop_oneof![
        (plane(), tangles()).prop_map(|(k, curves)| Step::Set(k, curves)),
        plane().prop_map(|k| Step::Set(k, Vec::new())),
        (plane(), one).prop_map(|(k, c)| Step::Insert(k, c)),
        (plane(), curve()).prop_map(|(k, i)| Step::Remove(k, i)),
        (plane(), curve(), node()).prop_map(|(k, i, n)| Step::Split(k, i, n)),
        (plane(), curve(), partner()).prop_map(|(k, i, j)| Step::Join(k, i, j)),
        (plane(), curve(), node(), x()).prop_map(|(k, i, n, x)| Step::InsertNode(k, i, n, x)),
        (plane(), curve(), node()).prop_map(|(k, i, n)| Step::RemoveNode(k, i, n)),
        (plane(), curve(), node(), x()).prop_map(|(k, i, n, x)| Step::ReplaceNode(k, i, n, x)),
    ];
    // What is split is often joined again at once.
    let split_and_join = (plane(), curve(), node(), any::<bool>()).prop_map(|(k, i, n, own)| {
        vec![Step::Split(k, i, n), Step::Join(k, i, if own { ITSELF } else { LAST })]
    });
    let some = prop_oneof![4 => step.prop_map(|step| vec![step]), 1 => split_and_join];
    prop::collection::vec(some, 1..30).prop_map(|steps| steps.concat())
}

/// Partners of a joint that splitting leaves behind: the curve itself, or the last one of its
/// plane.
const ITSELF: usize = 100;
const LAST: usize = 101;

/// The step with its partner's place in the model.
fn resolved(model: &Model, step: Step) -> Step {
    match step {
        Step::Join(k, i, ITSELF) => Step::Join(k, i, i),
        Step::Join(k, i, LAST) => {
            let section = model.section(PlaneIndex(k));
            Step::Join(k, i, section.map_or(0, |s| s.curve_records().len() - 1))
        }
        other => other,
    }
}

fn node_at(x: f64) -> Node {
    Node::at(Point2::new(x, 1.0))
}

fn is_curve(nodes: &[Node], closed: bool) -> bool {
    nodes.len() >= if closed { 3 } else { 2 } && nodes.iter().all(|n| n.position.x.is_finite())
}

/// Does a step to the list of lists; `None` if it cannot be done.
fn plainly(plain: &mut Plain, step: &Step) -> Option<()> {
    let (Step::Set(k, _) | Step::Insert(k, _) | Step::Remove(k, _)) = step else {
        return edit_plainly(plain, step);
    };
    if !plain.iter().any(|(plane, _)| plane == k) {
        plain.push((*k, Vec::new()));
    }
    let curves = &mut plain.iter_mut().find(|(plane, _)| plane == k)?.1;
    let parts = |c: &Curve| (c.nodes().to_vec(), c.is_closed());
    match step {
        Step::Set(_, new) => *curves = new.iter().map(parts).collect(),
        Step::Insert(_, curve) => curves.push(parts(curve)),
        Step::Remove(_, i) if *i < curves.len() => drop(curves.remove(*i)),
        _ => return None,
    }
    Some(())
}

fn edit_plainly(plain: &mut Plain, step: &Step) -> Option<()> {
    let (Step::Split(k, i, _)
    | Step::Join(k, i, _)
    | Step::InsertNode(k, i, _, _)
    | Step::RemoveNode(k, i, _)
    | Step::ReplaceNode(k, i, _, _)) = step
    else {
        return None;
    };
    let curves = &mut plain.iter_mut().find(|(plane, _)| plane == k)?.1;
    let (nodes, closed) = curves.get(*i)?.clone();
    let mut changed = nodes.clone();
    match *step {
        Step::Split(_, _, n) if n < nodes.len() && closed => {
            let opened = [&nodes[n..], &nodes[..=n]].concat();
            curves[*i] = (opened, false);
            return Some(());
        }
        Step::Split(_, _, n) if n > 0 && n + 1 < nodes.len() && !closed => {
            curves[*i] = (nodes[..=n].to_vec(), false);
            curves.push((nodes[n..].to_vec(), false));
            return Some(());
        }
        Step::Join(_, _, j) => return join_plainly(curves, *i, j),
        Step::InsertNode(_, _, n, x) if n <= nodes.len() => changed.insert(n, node_at(x)),
        Step::RemoveNode(_, _, n) if n < nodes.len() => drop(changed.remove(n)),
        Step::ReplaceNode(_, _, n, x) if n < nodes.len() => changed[n] = node_at(x),
        _ => return None,
    }
    is_curve(&changed, closed).then(|| curves[*i] = (changed, closed))
}

fn join_plainly(curves: &mut Vec<(Vec<Node>, bool)>, i: usize, j: usize) -> Option<()> {
    let ((head, head_closed), (tail, tail_closed)) = (curves[i].clone(), curves.get(j)?.clone());
    if head_closed || tail_closed || head.last()?.position != tail.first()?.position {
        return None;
    }
    if i == j {
        let ring = head[..head.len() - 1].to_vec();
        return is_curve(&ring, true).then(|| curves[i] = (ring, true));
    }
    curves[i] = ([&head[..], &tail[1..]].concat(), false);
    curves.remove(j);
    Some(())
}

/// Does a step to the tree; `None` if it refuses.
fn really(model: &mut Model, step: Step) -> Option<()> {
    let (plane, curve, place) = (PlaneIndex, CurveIndex, NodeIndex);
    match step {
        Step::Set(k, curves) => model.set_curves(plane(k), curves),
        Step::Insert(k, new) => _ = model.insert_curve(plane(k), new),
        Step::Remove(k, i) => _ = model.remove_curve(plane(k), curve(i))?,
        Step::Split(k, i, n) => _ = model.split_curve(plane(k), curve(i), place(n)).ok()?,
        Step::Join(k, i, j) => model.join_curves(plane(k), curve(i), curve(j)).ok()?,
        Step::InsertNode(k, i, n, x) => {
            model.insert_node(plane(k), curve(i), place(n), node_at(x)).ok()?;
        }
        Step::RemoveNode(k, i, n) => _ = model.remove_node(plane(k), curve(i), place(n)).ok()?,
        Step::ReplaceNode(k, i, n, x) => {
            model.replace_node(plane(k), curve(i), place(n), node_at(x)).ok()?;
        }
    }
    Some(())
}

fn check_same(model: &Model, plain: &Plain) {
    let mut sorted: Vec<_> = plain.iter().filter(|(_, curves)| !curves.is_empty()).collect();
    sorted.sort_by_key(|(k, _)| *k);
    let parts = |c: &Curve| (c.nodes().to_vec(), c.is_closed());
    let tree: Vec<(i64, Vec<_>)> =
        model.sections().map(|(k, s)| (k.0, s.curves().map(parts).collect())).collect();
    assert_eq!(tree.iter().collect::<Vec<_>>(), sorted);
    for probe in [i64::MIN, -3, -2, -1, 0, 1, 2, 3, i64::MAX] {
        let next = sorted.iter().map(|(k, _)| *k).find(|k| *k > probe);
        let before = sorted.iter().map(|(k, _)| *k).rfind(|k| *k < probe);
        assert_eq!(model.next_after(PlaneIndex(probe)).map(|(k, _)| k.0), next);
        assert_eq!(model.previous_before(PlaneIndex(probe)).map(|(k, _)| k.0), before);
    }
    let runs = model.sub_families();
    let in_runs = |k: i64| runs.iter().filter(|run| run.contains(&PlaneIndex(k))).count();
    for probe in -4..5 {
        assert_eq!(in_runs(probe), usize::from(sorted.iter().any(|(k, _)| *k == probe)));
    }
    let gaps = sorted.windows(2).filter(|pair| pair[0].0 + 1 < pair[1].0).count();
    assert_eq!(runs.len(), gaps + usize::from(!sorted.is_empty()));
}

/// Walks every curve both ways, and searches a rectangle.
fn check_walks(section: &Section) {
    for (i, curve) in section.curves().enumerate() {
        let n = curve.nodes().len();
        for k in 0..n {
            let after = section.node_after(CurveIndex(i), NodeIndex(k)).map(|(at, _)| at.0);
            let wanted =
                if curve.is_closed() { Some((k + 1) % n) } else { (k + 1 < n).then_some(k + 1) };
            assert_eq!(after, wanted);
            if let Some((next, node)) = section.node_after(CurveIndex(i), NodeIndex(k)) {
                assert_eq!(node, &curve.nodes()[next.0]);
                let (back, _) = section.node_before(CurveIndex(i), next).unwrap();
                assert_eq!(back, NodeIndex(k));
            }
        }
        assert!(section.node_after(CurveIndex(i), NodeIndex(n)).is_none());
        assert!(section.node_before(CurveIndex(i), NodeIndex(n)).is_none());
    }
    let probe = rectangle(-0.5, -0.5, 0.5, 0.5).envelope();
    let near: Vec<_> = section.curves_near(probe).map(|(i, _)| i.0).collect();
    let slow = section.curves().enumerate().filter(|(_, c)| c.envelope().intersects(&probe));
    assert_eq!(near, slow.map(|(i, _)| i).collect::<Vec<_>>());
}

proptest! {
    #[test]
    fn the_tree_is_the_list_of_lists_after_every_step(steps in steps()) {
        let (mut model, mut plain) = (empty(), Plain::new());
        for step in steps {
            let step = resolved(&model, step);
            let before = model.clone();
            let expected = plainly(&mut plain, &step);
            let done = really(&mut model, step.clone());
            prop_assert_eq!(done, expected, "{:?}", step);
            if done.is_none() {
                prop_assert_eq!(&model, &before);
            }
            prop_assert_eq!(model.check(), Ok(()));
            check_same(&model, &plain);
            model.sections().for_each(|(_, section)| check_walks(section));
        }
    }
}

#[test]
fn changes_that_leave_no_curve_are_refused_with_the_reason() {
    let (mut model, plane) = (empty(), PlaneIndex(0));
    model.set_curves(plane, vec![strip()]);
    let first = CurveIndex(0);
    model.remove_node(plane, first, NodeIndex(1)).unwrap();
    let flat = model.remove_node(plane, first, NodeIndex(0)).unwrap_err();
    assert!(matches!(flat, EditError::NoCurve(_)));
    let beyond = model.insert_node(plane, first, NodeIndex(3), node_at(0.0)).unwrap_err();
    assert_eq!(beyond.to_string(), "the curve has no node 3");
    let missing = model.replace_node(plane, CurveIndex(1), NodeIndex(0), node_at(0.0)).unwrap_err();
    assert_eq!(missing.to_string(), "plane 0 has no curve 1");
}
