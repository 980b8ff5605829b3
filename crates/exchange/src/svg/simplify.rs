//! Removal of vertices that do not move a line visibly (Douglas and Peucker, 1973).

use transect_geometry::{CurveUnit, Point2};

/// Indices of the vertices to keep, ascending, so that no vertex is further than `tolerance` from
/// the line through the kept ones. Ends of open lines stay. Takes n log n in practice.
pub(super) fn simplified(points: &[Point2], closed: bool, tolerance: f64) -> Vec<usize> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut kept = vec![false; points.len()];
    let mut keep = |at: usize| {
        if let Some(k) = kept.get_mut(at) {
            *k = true;
        }
    };
    keep(0);
    let mut open_pieces = Vec::new();
    if closed {
        // The two halves of a ring meet at its first vertex and the one farthest from it.
        let (split, _) = farthest(points, 0, points.len(), 0);
        keep(split);
        open_pieces.extend([(0, split), (split, points.len())]);
    } else {
        keep(last);
        open_pieces.push((0, last));
    }
    while let Some((from, to)) = open_pieces.pop() {
        let (middle, distance) = farthest(points, from, to, to % points.len());
        if distance > tolerance {
            keep(middle);
            open_pieces.extend([(from, middle), (middle, to)]);
        }
    }
    (0..points.len()).filter(|&i| kept.get(i) == Some(&true)).collect()
}

/// The vertex strictly between two others that is farthest from the segment between them.
fn farthest(points: &[Point2], from: usize, to: usize, end: usize) -> (usize, f64) {
    let start = (from, -1.0);
    let Some((&start_point, &end_point)) = points.get(from).zip(points.get(end)) else {
        return start;
    };
    let segment = CurveUnit { start: start_point, end: end_point };
    let between = points.iter().enumerate().take(to).skip(from + 1);
    between.fold(start, |best, (i, p)| {
        let distance = segment.distance(p);
        if distance > best.1 { (i, distance) } else { best }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn no_vertex_moves_more_than_the_tolerance(
            steps in prop::collection::vec((-1.0..1.0, -1.0..1.0), 3..60),
            closed: bool, tolerance in 0.01..1.0,
        ) {
            let mut at = Point2::origin();
            let mut points = Vec::new();
            for (x, y) in steps {
                at += transect_geometry::Vector2::new(x, y);
                points.push(at);
            }
            let kept = simplified(&points, closed, tolerance);
            prop_assert!(kept.is_sorted() && kept[0] == 0);
            prop_assert!(closed || kept.last() == Some(&(points.len() - 1)));
            let mut ring = kept.clone();
            if closed {
                ring.push(points.len());
            }
            for pair in ring.windows(2) {
                let segment =
                    CurveUnit { start: points[pair[0]], end: points[pair[1] % points.len()] };
                for p in &points[pair[0]..pair[1]] {
                    prop_assert!(segment.distance(p) <= tolerance + 1e-12);
                }
            }
        }
    }

    #[test]
    fn straight_lines_keep_their_ends_only() {
        let line: Vec<_> = (0..1000).map(|i| Point2::new(f64::from(i), 0.0)).collect();
        assert_eq!(simplified(&line, false, 0.01), vec![0, 999]);
        assert_eq!(simplified(&line, true, 0.01), vec![0, 999]);
        assert_eq!(simplified(&[], true, 0.01), Vec::<usize>::new());
    }
}
