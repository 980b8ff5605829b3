//! The warnings of regions of images that contradict other views, in words.

use crate::evaluate::digits;
use std::collections::BTreeSet;
use transect_device::median;
use transect_geometry::LengthUnit;
use transect_register::{Region, RegionKind};

/// Most regions that are warned of one by one. Chosen by hand: sound scans have one at most, and a
/// mirror in a room shows in every station. Doubled, a wrong camera fills the screen.
const MOST_REGIONS: usize = 8;

/// Largest part of an image that regions of one thing take together, over the median of each. No
/// unit. Chosen by hand: what a camera carries moves a little in its holder, and a wrong camera
/// or wrong poses make regions all over the image. Doubled, these are called an arm, too.
const LARGEST_SPREAD: f64 = 2.0;

/// Each region, or what many of them have in common.
pub(super) fn texts(regions: &[&Region], all_views: usize, unit: LengthUnit) -> Vec<String> {
    match regions.len() <= MOST_REGIONS {
        true => regions.iter().map(|region| text(region, unit)).collect(),
        false => vec![carried(regions).unwrap_or_else(|| of_many(regions, all_views))],
    }
}

/// One region.
pub(super) fn text(region: &Region, unit: LengthUnit) -> String {
    let Region { view, rows, cols, views, .. } = region;
    let distance = digits(region.distance);
    let problem = match region.kind {
        RegionKind::InFront => format!(
            "{views} other views saw free space there, up to {distance} {unit} behind it: \
             something that was not always there. Curves that more views looked through than \
             measured are left out by default. To leave out all of it, make"
        ),
        RegionKind::SeenThrough => format!(
            "{views} other views saw a surface {distance} {unit} before it: a mirror, a window, or \
             something that came later. If the surface is wrong, make"
        ),
    };
    let columns = match cols {
        [first, last] if first > last => format!("{first} to the last, and 0 to {last}"),
        [first, last] => format!("{first} to {last}"),
    };
    format!(
        "view {view}, rows {} to {}, columns {columns}: {problem} these pixels missing",
        rows[0], rows[1]
    )
}

/// The text for regions in one part of most views, before what others see; `None` if they are
/// elsewhere.
fn carried(regions: &[&Region]) -> Option<String> {
    let in_front = || regions.iter().filter(|r| r.kind == RegionKind::InFront);
    // Cameras have no seam that a region could lie across.
    let middle = |span: [usize; 2]| usize::midpoint(span[0], span[1]);
    let holds = |span: [usize; 2], at: usize| (span[0]..=span[1]).contains(&at);
    let at_one_place = |of: &&&Region| {
        let (row, col) = (middle(of.rows), middle(of.cols));
        let here = in_front().filter(|r| holds(r.rows, row) && holds(r.cols, col));
        here.copied().collect::<Vec<&Region>>()
    };
    let place = in_front().map(|of| at_one_place(&of)).max_by_key(|here| concerned(here))?;
    if 2 * concerned(&place) <= concerned(regions) {
        return None;
    }
    let span = |of: fn(&Region) -> [usize; 2]| {
        let ends = || place.iter().map(|region| of(region));
        Some((ends().map(|s| s[0]).min()?, ends().map(|s| s[1]).max()?))
    };
    let ((first_row, last_row), (first_col, last_col)) = (span(|r| r.rows)?, span(|r| r.cols)?);
    let area = |rows: [usize; 2], cols: [usize; 2]| {
        let length = |[first, last]: [usize; 2]| (last + 1).saturating_sub(first) as f64;
        length(rows) * length(cols)
    };
    let usual = median(place.iter().map(|region| area(region.rows, region.cols)))?;
    if area([first_row, last_row], [first_col, last_col]) > LARGEST_SPREAD * usual {
        return None;
    }
    Some(format!(
        "{} views see a surface within rows {first_row} to {last_row} and columns {first_col} to \
         {last_col} where other views saw free space: something that the camera carries with it, \
         such as an arm or a housing. Make these pixels missing in all images",
        concerned(&place)
    ))
}

/// The text for regions that have no place in common.
fn of_many(regions: &[&Region], all_views: usize) -> String {
    format!(
        "{} regions of {} of the {all_views} views contradict other views. Make the pixels of \
         things missing that moved between the views (the report lists the regions). If nothing \
         moved, check what the views share: the camera (fx, fy, cx, cy), the unit and the scale of \
         the images and of the poses, ranges along the rays against depths along the axis, and \
         that every image has its own pose",
        regions.len(),
        concerned(regions)
    )
}

/// The number of views that have any of these regions.
fn concerned(regions: &[&Region]) -> usize {
    regions.iter().map(|region| region.view.as_str()).collect::<BTreeSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(view: usize, corner: [usize; 2], kind: RegionKind) -> Region {
        let [row, col] = corner;
        let (rows, cols) = ([row, row + 80], [col, col + 120]);
        let view = format!("view {view}");
        Region { view, kind, rows, cols, distance: 1.5, views: 2, cells: 50 }
    }

    fn told(regions: &[Region]) -> Vec<String> {
        texts(&regions.iter().collect::<Vec<_>>(), 20, LengthUnit::Metre)
    }

    #[test]
    fn a_surface_in_one_part_of_most_views_is_carried_by_the_camera() {
        let arm = |k| region(k, [400 - k, 200 + 4 * k], RegionKind::InFront);
        let far = |k| region(k, [10, 40 * k], RegionKind::SeenThrough);
        let both: Vec<Region> = (0..10).map(arm).chain((8..16).map(far)).collect();
        let texts = told(&both);
        assert!(texts.len() == 1 && texts[0].starts_with("10 views see a surface"), "{texts:?}");
        assert!(texts[0].contains("rows 391 to 480 and columns 200 to 356"), "{texts:?}");
    }

    #[test]
    fn a_region_across_the_seam_has_two_ranges_of_columns() {
        let across = Region { cols: [380, 20], ..region(1, [10, 0], RegionKind::InFront) };
        let told = text(&across, LengthUnit::Metre);
        assert!(told.contains("rows 10 to 90, columns 380 to the last, and 0 to 20: "), "{told}");
    }

    #[test]
    fn large_regions_that_overlap_are_not_carried() {
        // As of a camera whose middle is stated wrongly: all hold one place, none is like another.
        let of = |k: usize| Region {
            rows: [40 * k, 280],
            cols: [200, 260 + 40 * k],
            ..region(k, [0, 0], RegionKind::InFront)
        };
        let texts = told(&(0..9).map(of).collect::<Vec<_>>());
        assert!(texts.len() == 1 && texts[0].contains("check what the views share"), "{texts:?}");
    }

    #[test]
    fn surfaces_in_different_parts_may_have_moved() {
        let moved: Vec<Region> =
            (0..10).map(|k| region(k, [40 * k, 60 * (k % 7)], RegionKind::InFront)).collect();
        let texts = told(&moved);
        assert!(texts.len() == 1 && texts[0].starts_with("10 regions of 10 of the 20 views"));
        assert_eq!(told(&moved[..8]).len(), 8);
    }
}
