//! Which views contradict the others, and how.
//!
//! **Problem.** A wrong pose spoils every section that its view has a part in. Curves far apart
//! count as other surfaces, so the sections do not tell.
//!
//! **Steps.**
//! 1. Some patches of each view are looked up in every other view (`pair.rs`): they meet a surface
//!    within its noise, they miss it, or they lie in free space. `evidence.rs` also finds how far
//!    the views of this scan usually differ.
//! 2. The views that explain the contradictions are found for all pairs together (`blame.rs`).
//! 3. For each of them, the motion or the scale is estimated that would make it agree with the
//!    others (`motion.rs`).
//! 4. Where only a part of a view contradicts, the part is named (`region.rs`).
//! 5. Where most views contradict however they are taken, no view and no part is named.
//!
//! While poses are refined, `search/` finds where a view belongs that is far off.

mod blame;
mod evidence;
mod motion;
pub(crate) mod pair;
mod region;
mod search;
mod tuning;

use crate::coarse::CoarseView;
use crate::tuning::LEAST_MEETINGS;
use blame::Table;
use evidence::Evidence;
use motion::{Change, Changed, best};
use rayon::prelude::*;
use region::{Regions, regions};
pub(crate) use search::{Places, root_of_far, squares_apart};
use std::cmp::Reverse;
use transect_device::{Isometry3, median};
use tuning::{BAD_IF_RIGHT, BAD_IF_WRONG, MENDED, REGION_SHARE};

/// The findings about the poses of a scan.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Judgement {
    /// The contradictions; empty for sound poses.
    pub findings: Vec<Finding>,
    /// One for each view, by name.
    pub views: Vec<Agreement>,
    /// The distance by which surfaces of two views usually differ, in the model's length unit.
    pub usual_distance: f64,
}

impl Judgement {
    /// Whether most views contradict each other.
    pub fn all_contradict(&self) -> bool {
        self.findings.iter().any(|finding| matches!(finding, Finding::All { .. }))
    }
}

/// How far a view agrees with all others together.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Agreement {
    /// The name of the view.
    pub view: String,
    /// How many patches were compared: of this view in others, and of others in this view.
    pub compared: usize,
    /// The share of them that contradict.
    pub contradicting: f64,
}

/// Something wrong with the poses.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Finding {
    /// A view contradicts the others, which agree among themselves.
    Misplaced(Misplaced),
    /// A view agrees with the others if its ranges are scaled.
    Scaled(Scaled),
    /// A view has no surface in common with any other view, although the others overlap. Its pose
    /// may be wrong by any amount.
    Apart {
        /// The name of the view.
        view: String,
    },
    /// Views agree within groups, and the groups contradict each other.
    Groups {
        /// The names of the views of each group, the largest group first.
        groups: Vec<Vec<String>>,
        /// Share of the patches that contradict, among those compared between groups.
        contradicting: f64,
    },
    /// A part of a view contradicts others, while the rest of it agrees.
    Region(Region),
    /// Most views contradict the others, and none stands out: their poses belong to another scan,
    /// or are none at all.
    All {
        /// Share of the contradicting patches of the median view, but for those that stand out.
        contradicting: f64,
        /// Whether all views have the same pose, as stations that were never registered.
        one_pose: bool,
    },
}

/// A view that contradicts the others.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Misplaced {
    /// The name of the view.
    pub view: String,
    /// Share of the patches that contradict, among those compared with the other views.
    pub contradicting: f64,
    /// The largest such share among the other views.
    pub usual: f64,
    /// With how many other views it was compared.
    pub against: usize,
    /// The motion that would make it agree; `None` if none near its pose does.
    pub motion: Option<Motion>,
}

/// A motion of a view's sensor.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Motion {
    /// Its angle, in radians.
    pub rotation: f64,
    /// How far the sensor's origin moves, in the model's length unit.
    pub translation: f64,
    /// Share of contradicting patches after it.
    pub contradicting: f64,
}

/// A view whose ranges have a wrong scale.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Scaled {
    /// The name of the view.
    pub view: String,
    /// Its lengths over the true ones: 1.005 if they are half a per cent too long.
    pub factor: f64,
    /// Share of contradicting patches as given.
    pub contradicting: f64,
    /// The same with the lengths divided by the factor.
    pub corrected: f64,
}

/// A part of a view that contradicts other views.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Region {
    /// The name of the view.
    pub view: String,
    /// How it contradicts. Serialized as `contradiction`, since `kind` is the finding's own.
    #[serde(rename = "contradiction")]
    pub kind: RegionKind,
    /// First and last row of pixels.
    pub rows: [usize; 2],
    /// First and last column of pixels. In an image that turns around once, a region may go on
    /// from the last column to the first; its first column is then larger than its last one.
    pub cols: [usize; 2],
    /// Median distance between its surface and the free space's end, in the model's length unit.
    pub distance: f64,
    /// How many other views were found to contradict it: 2 to 4.
    pub views: usize,
    /// How many cells of the coarse copy it has.
    pub cells: usize,
}

/// How a region contradicts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum RegionKind {
    /// Its surface lies where others saw free space: an object that was not always there.
    InFront,
    /// It lies behind surfaces that others saw: a mirror, a window, or an object that came later.
    SeenThrough,
}

/// Finds what is wrong with the poses of views.
///
/// Views whose poses err as much as those of all others are not named. The result does not depend
/// on the order of the views.
pub fn judge(views: &[CoarseView]) -> Judgement {
    let mut sorted: Vec<&CoarseView> = views.iter().collect();
    sorted.sort_by_cached_key(|view| view.rank());
    let evidence = Evidence::new(&sorted);
    let table = evidence.table();
    let mut blamed = table.blamed();
    let n = sorted.len();
    let right =
        |blamed: &[usize]| -> Vec<usize> { (0..n).filter(|k| !blamed.contains(k)).collect() };
    let all: Vec<Regions> =
        (0..n).into_par_iter().map(|k| regions_of(&evidence, k, &blamed)).collect();
    let excused = |view: usize| is_regional(&evidence, &table, view, &blamed, &all[view]);
    let excused: Vec<usize> = blamed.iter().copied().filter(|k| excused(*k)).collect();
    blamed.retain(|k| !excused.contains(k));
    let mut findings = if blamed.is_empty() {
        Vec::new()
    } else {
        of_blamed(&evidence, &table, &blamed, &right(&blamed))
    };
    findings.extend(apart(&evidence, &table, &blamed));
    let named = right(&blamed).into_iter().flat_map(|k| all[k].regions.iter().cloned());
    findings.extend(named.map(Finding::Region));
    if let Some(all) = all_contradict(&evidence, &table, &blamed) {
        findings = vec![all];
    }
    let agreement = |k: usize| {
        let counts = table.with_right(k, &[]);
        let (compared, contradicting) = (counts.all(), counts.bad_share());
        Agreement { view: sorted[k].name().to_owned(), compared, contradicting }
    };
    let usual_distance = evidence.usual;
    Judgement { findings, views: (0..n).map(agreement).collect(), usual_distance }
}

/// Wrong views among right ones, each by its place in the order.
#[derive(Debug, Default)]
pub(crate) struct Suspects {
    /// Views that contradict the others.
    pub turned: Vec<usize>,
    /// Views that agree once their lengths are divided by one number.
    pub scaled: Vec<usize>,
}

/// The views that are named as wrong, each by itself, where all others agree at these poses. Where
/// these err, too, it is chance which view stands out.
pub(crate) fn suspects(sorted: &[&CoarseView], poses: &[Isometry3]) -> Suspects {
    let evidence = Evidence::at(sorted, poses);
    let table = evidence.table();
    let mut blamed = table.blamed();
    let excused = |view: &usize| {
        is_regional(&evidence, &table, *view, &blamed, &regions_of(&evidence, *view, &blamed))
    };
    let excused: Vec<usize> = blamed.iter().copied().filter(excused).collect();
    blamed.retain(|k| !excused.contains(k));
    let usual = table.usual_share(&blamed);
    if blamed.is_empty() || usual.is_none_or(|share| share > BAD_IF_RIGHT) {
        return Suspects::default();
    }
    let right: Vec<usize> = (0..sorted.len()).filter(|k| !blamed.contains(k)).collect();
    let findings = of_blamed(&evidence, &table, &blamed, &right);
    let named = |is_named: &dyn Fn(&Finding, &str) -> bool| {
        let is_named = |k: &&usize| findings.iter().any(|f| is_named(f, sorted[**k].name()));
        blamed.iter().filter(is_named).copied().collect::<Vec<usize>>()
    };
    let turned = named(&|f, name| matches!(f, Finding::Misplaced(m) if m.view == name));
    let scaled = named(&|f, name| matches!(f, Finding::Scaled(s) if s.view == name));
    Suspects { turned, scaled }
}

/// Those of some views that contradict all others at these poses.
pub(crate) fn contradicting(
    sorted: &[&CoarseView],
    poses: &[Isometry3],
    some: &[usize],
) -> Vec<usize> {
    let table = Evidence::at(sorted, poses).table();
    let least = table.least_share(some);
    let is_bad = |k: &&usize| table.with_right(**k, some).bad_share() >= least;
    some.iter().filter(is_bad).copied().collect()
}

/// How probable such contradictions are in a right view, if this view has them at these poses with
/// those that are not wrong; `None` if it stands out among these.
pub(crate) fn likelihood(
    sorted: &[&CoarseView],
    poses: &[Isometry3],
    view: usize,
    wrong: &[usize],
) -> Option<f64> {
    let table = Evidence::at(sorted, poses).table();
    let counts = table.with_right(view, wrong);
    (counts.bad_share() < table.least_share(wrong)).then(|| table.likelihood(wrong)(counts))
}

/// Poses at which a view agrees with all that are not wrong, and which are where `poses` says.
pub(crate) fn places_of(
    sorted: &[&CoarseView],
    poses: &[Isometry3],
    view: usize,
    wrong: &[usize],
) -> Option<Places> {
    let evidence = Evidence::at(sorted, poses);
    search::places(&evidence, &evidence.table(), view, wrong)
}

/// The regions of a view that the others contradict, but for those that are blamed.
fn regions_of(evidence: &Evidence<'_>, view: usize, blamed: &[usize]) -> Regions {
    let others = (0..evidence.views.len()).filter(|k| *k != view && !blamed.contains(k));
    regions(evidence, view, &others.collect::<Vec<_>>())
}

/// Whether the contradictions of a blamed view lie in its regions, and most of it agrees.
fn is_regional(
    evidence: &Evidence<'_>,
    table: &Table,
    view: usize,
    blamed: &[usize],
    found: &Regions,
) -> bool {
    let size = evidence.views[view].size().pixels() as f64;
    if found.cells.is_empty() || found.cells.len() as f64 > REGION_SHARE * size {
        return false;
    }
    let right = (0..evidence.views.len()).filter(|k| *k != view && !blamed.contains(k));
    let outside = right.flat_map(|other| {
        let own = evidence.between(view, other).iter().filter(|s| !found.cells.contains(&s.cell));
        let others = evidence.between(other, view).iter();
        own.chain(others.filter(|s| !found.cells.contains(&s.other_cell)))
    });
    let outside = evidence.count(outside);
    let all = table.with_right(view, blamed);
    outside.bad_share() < table.least_share(blamed) && 2 * outside.good > all.all()
}

/// Blamed views: each by itself where most views are right, else as groups.
fn of_blamed(
    evidence: &Evidence<'_>,
    table: &Table,
    blamed: &[usize],
    right: &[usize],
) -> Vec<Finding> {
    let name = |k: &usize| evidence.views[*k].name().to_owned();
    let agree = |view: usize, other: usize| {
        let counts = table.pair(view, other);
        counts.all() >= LEAST_MEETINGS && counts.bad_share() < table.least_share(blamed)
    };
    let mut groups = vec![right.to_vec()];
    groups.extend(agreeing(blamed, agree));
    let alone = right.len() > 1 && groups.iter().skip(1).all(|group| group.len() == 1);
    if alone {
        let finding = |view: &usize| match table.only_opponent(*view, blamed) {
            Some(other) => {
                let groups = [other, *view].map(|k| vec![name(&k)]).to_vec();
                let contradicting = table.pair(*view, other).bad_share();
                Finding::Groups { groups, contradicting }
            }
            None => of_view(evidence, table, *view, blamed, right),
        };
        return blamed.par_iter().map(finding).collect();
    }
    let across = blamed.iter().map(|k| table.with_right(*k, blamed));
    let contradicting = across.fold(blame::Counts::default(), |a, b| a + b).bad_share();
    let groups = groups.iter().map(|group| group.iter().map(name).collect()).collect();
    vec![Finding::Groups { groups, contradicting }]
}

/// Groups of views that agree with each other, the largest first. A view that agrees with several
/// groups joins them.
fn agreeing(views: &[usize], agree: impl Fn(usize, usize) -> bool) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for &view in views {
        let (joined, mut apart): (Vec<_>, Vec<_>) =
            groups.into_iter().partition(|group| group.iter().any(|other| agree(view, *other)));
        apart.push(joined.into_iter().flatten().chain([view]).collect());
        groups = apart;
    }
    groups.sort_by_key(|group| Reverse(group.len()));
    groups
}

/// The finding about one blamed view.
fn of_view(
    evidence: &Evidence<'_>,
    table: &Table,
    view: usize,
    blamed: &[usize],
    right: &[usize],
) -> Finding {
    let name = evidence.views[view].name().to_owned();
    let contradicting = table.with_right(view, blamed).bad_share();
    let mends = |c: &Changed| {
        c.counts.all() >= LEAST_MEETINGS && c.counts.bad_share() < (1.0 - MENDED) * contradicting
    };
    let moved = Some(best(evidence, view, right, Change::Motion)).filter(mends);
    // One factor explains all, or it is not the reason.
    let explains = |c: &Changed| c.counts.bad_share() < table.least_share(blamed);
    let scaled = Some(best(evidence, view, right, Change::Scale)).filter(mends).filter(explains);
    if let Some(scaled) = scaled.filter(|s| moved.is_none_or(|m| s.cost < m.cost)) {
        let (factor, corrected) = (1.0 / scaled.placing.scale, scaled.counts.bad_share());
        return Finding::Scaled(Scaled { view: name, factor, contradicting, corrected });
    }
    let given = evidence.placings[view].world_from_sensor;
    let motion = moved.map(|m| Motion {
        rotation: given.rotation.angle_to(&m.placing.world_from_sensor.rotation),
        translation: (m.placing.world_from_sensor.translation.vector - given.translation.vector)
            .norm(),
        contradicting: m.counts.bad_share(),
    });
    let compared = |k: &&usize| table.pair(view, **k).all() > 0;
    let against = right.iter().filter(compared).count();
    let usual = table.usual_share(blamed).unwrap_or(0.0);
    Finding::Misplaced(Misplaced { view: name, contradicting, usual, against, motion })
}

/// The finding that most of the views contradict which are not blamed.
fn all_contradict(evidence: &Evidence<'_>, table: &Table, blamed: &[usize]) -> Option<Finding> {
    let contradicting = median(table.shares(blamed)).filter(|share| *share > BAD_IF_WRONG)?;
    let poses = || evidence.placings.iter().map(|placing| placing.world_from_sensor);
    let one_pose = poses().zip(poses().skip(1)).all(|(a, b)| a == b);
    Some(Finding::All { contradicting, one_pose })
}

/// Views that no other view meets, where the others meet each other.
fn apart(evidence: &Evidence<'_>, table: &Table, blamed: &[usize]) -> Vec<Finding> {
    let n = evidence.views.len();
    let few = |k: &usize| table.with_right(*k, &[]).all() < LEAST_MEETINGS;
    let lonely: Vec<usize> = (0..n).filter(|k| !blamed.contains(k)).filter(few).collect();
    // A view that overlaps a wrong view alone meets no other view, either.
    if 2 * lonely.len() >= n || !blamed.is_empty() {
        return Vec::new();
    }
    let name = |k: &usize| evidence.views[*k].name().to_owned();
    lonely.iter().map(|k| Finding::Apart { view: name(k) }).collect()
}

#[cfg(test)]
mod tests {
    use super::agreeing;

    #[test]
    fn a_view_that_agrees_with_two_groups_joins_them() {
        let pairs = [(1, 3), (2, 3), (5, 6)];
        let agree = |a: usize, b: usize| pairs.contains(&(a.min(b), a.max(b)));
        assert_eq!(agreeing(&[5, 1, 2, 6, 3], agree), [vec![1, 2, 3], vec![5, 6]]);
        assert_eq!(agreeing(&[1, 2], agree), [[1], [2]]);
    }
}
