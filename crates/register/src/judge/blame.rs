//! Which views explain the contradictions.
//!
//! **Problem.** A wrong view contradicts every right view, and each right view contradicts the
//! wrong one. A score per view would blame them all.
//!
//! **Steps.**
//! 1. Views are blamed one after the other. Each time it is the one whose pairs with the views not
//!    yet blamed are the least likely among right views (a vertex cover with soft edges, greedily).
//! 2. Blame holds only where it makes peace: the blamed views must contradict the others far more
//!    than any two of the others do. Real scans have many small contradictions without a culprit.
//!    Of two sets of blamed views that make peace, the smaller one counts if the larger one leaves
//!    views that do not meet.

use super::tuning::{BAD_IF_RIGHT, BLAME_COST, EVIDENCE_OF_A_PAIR, LEAST_USUAL, STANDS_OUT};
use crate::tuning::LEAST_MEETINGS;

/// How many patches of some views agree and contradict.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Counts {
    pub good: usize,
    pub bad: usize,
    /// Patches that show that two views see one place, and not whether they agree.
    pub unclear: usize,
}

impl Counts {
    /// The patches in places that both views see.
    pub fn all(self) -> usize {
        self.good + self.bad + self.unclear
    }

    /// The share of contradictions in what agrees or contradicts; 0 of nothing.
    pub fn bad_share(self) -> f64 {
        self.bad as f64 / (self.good + self.bad).max(1) as f64
    }
}

impl std::ops::Add for Counts {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            good: self.good + other.good,
            bad: self.bad + other.bad,
            unclear: self.unclear + other.unclear,
        }
    }
}

/// The counts of every pair of views.
#[derive(Debug, Clone)]
pub(super) struct Table {
    views: usize,
    counts: Vec<Counts>,
}

impl Table {
    pub fn new(views: usize, of: impl Fn(usize, usize) -> Counts) -> Self {
        let counts = (0..views * views).map(|k| of(k / views, k % views)).collect();
        Self { views, counts }
    }

    pub fn pair(&self, a: usize, b: usize) -> Counts {
        self.counts[a * self.views + b]
    }

    /// The counts of a view with the views that are not blamed.
    pub fn with_right(&self, view: usize, blamed: &[usize]) -> Counts {
        let right = (0..self.views).filter(|k| *k != view && !blamed.contains(k));
        right.map(|k| self.pair(view, k)).fold(Counts::default(), |sum, pair| sum + pair)
    }

    /// The right view that a blamed one contradicts, if it meets no other right view, and neither
    /// does that one: then either of the two may be wrong.
    pub fn only_opponent(&self, view: usize, blamed: &[usize]) -> Option<usize> {
        let met = |view: usize| {
            let right = (0..self.views).filter(move |k| *k != view && !blamed.contains(k));
            right.filter(move |k| self.pair(view, *k).all() >= LEAST_MEETINGS)
        };
        let mut opponents = met(view);
        let opponent = opponents.next().filter(|_| opponents.next().is_none())?;
        met(opponent).next().is_none().then_some(opponent)
    }

    /// The largest share of contradictions of a view that is not blamed; `None` if no two of these
    /// meet.
    pub fn usual_share(&self, blamed: &[usize]) -> Option<f64> {
        self.shares(blamed).max_by(f64::total_cmp)
    }

    /// The shares of contradictions of the views that are not blamed and meet another of these.
    pub fn shares(&self, blamed: &[usize]) -> impl Iterator<Item = f64> {
        let right = (0..self.views).filter(|k| !blamed.contains(k));
        let counts = right.map(|k| self.with_right(k, blamed));
        counts.filter(|c| c.all() >= LEAST_MEETINGS).map(Counts::bad_share)
    }

    /// The views whose being wrong explains the contradictions: at most half of all.
    pub fn blamed(&self) -> Vec<usize> {
        let mut order: Vec<usize> = Vec::new();
        while order.len() < self.views / 2 {
            let unblamed = (0..self.views).filter(|k| !order.contains(k));
            let gains = unblamed.map(|k| (k, self.gain(k, &order)));
            let best = gains.max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)));
            match best {
                Some((view, gain)) if gain > BLAME_COST => order.push(view),
                _ => break,
            }
        }
        while !order.is_empty() && !self.makes_peace(&order) {
            order.pop();
        }
        // Where the others do not meet, nothing tells what is usual, and the last view that was
        // blamed may be as good as they are.
        while let [first @ .., _] = &order[..]
            && !first.is_empty()
            && !self.others_meet(&order)
            && self.makes_peace(first)
        {
            order.pop();
        }
        order.sort_unstable();
        order
    }

    /// Whether any two of the views that are not blamed meet.
    fn others_meet(&self, blamed: &[usize]) -> bool {
        let mut right = (0..self.views).filter(|k| !blamed.contains(k));
        right.any(|k| self.with_right(k, blamed).all() >= LEAST_MEETINGS)
    }

    fn makes_peace(&self, blamed: &[usize]) -> bool {
        let least = self.least_share(blamed);
        blamed.iter().all(|k| self.with_right(*k, blamed).bad_share() >= least)
    }

    /// The share of contradictions from which a view stands out among those not blamed. Where no
    /// two of these meet, their usual share is unknown, and [`BAD_IF_RIGHT`] stands for it.
    pub fn least_share(&self, blamed: &[usize]) -> f64 {
        STANDS_OUT[0] + STANDS_OUT[1] * self.usual_share(blamed).unwrap_or(BAD_IF_RIGHT)
    }

    /// How likely a right view has some counts. Of what is known to be positive and to have a mean,
    /// the exponential distribution says least else (maximum entropy: Jaynes, 1957).
    pub fn likelihood(&self, blamed: &[usize]) -> impl Fn(Counts) -> f64 + Copy + use<> {
        let usual = self.usual_share(blamed).unwrap_or(BAD_IF_RIGHT).max(LEAST_USUAL);
        move |counts| (-counts.bad_share() / usual).exp()
    }

    /// By how much the logarithm of the likelihood grows if a view is taken to be wrong, with the
    /// share of contradictions that its pairs have.
    fn gain(&self, view: usize, blamed: &[usize]) -> f64 {
        let right = (0..self.views).filter(|k| *k != view && !blamed.contains(k));
        let weighted = |k: usize| {
            let pair = self.pair(view, k);
            let weight = EVIDENCE_OF_A_PAIR / (pair.all() as f64).max(EVIDENCE_OF_A_PAIR);
            [weight * pair.good as f64, weight * pair.bad as f64]
        };
        let [good, bad] =
            right.map(weighted).fold([0.0; 2], |sum, pair| [sum[0] + pair[0], sum[1] + pair[1]]);
        let share = bad / (good + bad);
        if share.is_nan() || share <= BAD_IF_RIGHT {
            return 0.0;
        }
        let of_good = if good > 0.0 { ((1.0 - share) / (1.0 - BAD_IF_RIGHT)).ln() } else { 0.0 };
        bad * (share / BAD_IF_RIGHT).ln() + good * of_good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn counts(good: usize, bad: usize) -> Counts {
        Counts { good, bad, unclear: 0 }
    }

    /// The counts of four views: 0 and 1 see one face of a sheet, 2 and 3 the other one.
    fn sheet(between_faces: Counts) -> Table {
        let contradict = counts(0, 100);
        Table::new(4, |a, b| match (a.min(b), a.max(b)) {
            (0, 1) => counts(100, 0),
            (2, 3) => contradict,
            (1, 2) => between_faces,
            _ => Counts::default(),
        })
    }

    #[test]
    fn a_view_beside_a_wrong_one_is_not_blamed_for_what_is_usual() {
        // Four views around an object: each meets the two beside it, and errs a little.
        let around = |a: usize, b: usize, wrong: &[usize]| match (a + 4 - b) % 4 {
            1 | 3 if wrong.contains(&a) || wrong.contains(&b) => counts(0, 140),
            1 | 3 => counts(130, 10),
            _ => Counts::default(),
        };
        for wrong in 0..4 {
            assert_eq!(Table::new(4, |a, b| around(a, b, &[wrong])).blamed(), [wrong]);
        }
        // If all pairs contradict equally and seldom, no view is blamed.
        let all_alike = |a: usize, b: usize| match (a + 4 - b) % 4 {
            1 | 3 => counts(101, 8),
            _ => Counts::default(),
        };
        assert_eq!(Table::new(4, all_alike).blamed(), []);
        // Two wrong views leave two that do not meet, and both are needed for peace.
        assert_eq!(Table::new(4, |a, b| around(a, b, &[0, 2])).blamed().len(), 2);
    }

    #[test]
    fn either_of_two_views_without_a_witness_may_be_wrong() {
        let alone = sheet(Counts::default());
        assert_eq!(alone.blamed(), [2]);
        assert_eq!(alone.only_opponent(2, &[2]), Some(3));
        // A few patches are no witness, twelve are.
        let few = sheet(counts(0, 3));
        assert_eq!(few.only_opponent(2, &few.blamed()), Some(3));
        let witness = sheet(counts(0, 12));
        assert_eq!(witness.blamed(), [2]);
        assert_eq!(witness.only_opponent(2, &[2]), None);
        let of_other = sheet(counts(12, 0));
        assert_eq!(of_other.blamed(), [3]);
        assert_eq!(of_other.only_opponent(3, &[3]), None);
    }
}
