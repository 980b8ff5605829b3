//! The part of a scan that is used: some of its views, and their points within some limits.

use crate::WorkflowError;
use serde::{Serialize, Serializer};
use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;
use transect_device::{RangeImage, View, ViewError};
use transect_exchange::{Scan, ScanView};
use transect_geometry::{Length, LengthUnit};

/// The part of a scan that is used, as a user gives it. Without anything it is the whole scan.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Selection {
    /// These views; without it all views.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub views: Option<ViewList>,
    /// Of these views, the first one and every so many further on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub every: Option<usize>,
    /// Points outside this box are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crop: Option<CropBox>,
    /// Points farther than this length from the start of their ray are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_range: Option<Length>,
}

/// A list of views: by name, by number from 0 or by range of numbers, with commas between them,
/// such as `3-7,12`.
///
/// It is a text, because only a scan tells names with commas from several names. A name goes before
/// a number, and a name with commas before its parts.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(transparent)]
pub struct ViewList(String);

impl From<&str> for ViewList {
    fn from(text: &str) -> Self {
        Self(text.to_owned())
    }
}

/// A box in the world, along its axes. A side without a length is open.
///
/// As text: `x0,x1,y0,y1,z0,z1`, where an empty length leaves its side open.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CropBox {
    /// The smallest x, y and z.
    pub low: [Option<Length>; 3],
    /// The largest x, y and z.
    pub high: [Option<Length>; 3],
}

impl FromStr for CropBox {
    type Err = WorkflowError;

    fn from_str(text: &str) -> Result<Self, WorkflowError> {
        let sides: Vec<&str> = text.split(',').map(str::trim).collect();
        if sides.len() != 6 {
            let problem = format!("{text:?} has {} lengths; write x0,x1,y0,y1,z0,z1", sides.len());
            return Err(WorkflowError::setting("crop", problem));
        }
        let mut crop = Self::default();
        for (k, side) in sides.iter().enumerate().filter(|(_, side)| !side.is_empty()) {
            let bounds = if k % 2 == 0 { &mut crop.low } else { &mut crop.high };
            let length = side.parse().map_err(|e| WorkflowError::setting("crop", e))?;
            bounds[k / 2] = Some(length);
        }
        Ok(crop)
    }
}

impl fmt::Display for CropBox {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sides = self.low.iter().zip(&self.high).flat_map(|(low, high)| [low, high]);
        let side = |side: &Option<Length>| side.map_or(String::new(), |length| length.to_string());
        f.write_str(&sides.map(side).collect::<Vec<_>>().join(","))
    }
}

impl Serialize for CropBox {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        out.collect_str(self)
    }
}

/// Limits of the points that are used, in the scan's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    low: [f64; 3],
    high: [f64; 3],
    max_range: f64,
}

impl Default for Limits {
    fn default() -> Self {
        let far = f64::INFINITY;
        Self { low: [-far; 3], high: [far; 3], max_range: far }
    }
}

impl Limits {
    /// The view without its points beyond the limits; their pixels are missing.
    ///
    /// # Errors
    /// [`ViewError::NoValidPixel`] if no point is left.
    pub fn apply(&self, view: View) -> Result<View, ViewError> {
        if *self == Self::default() {
            return Ok(view);
        }
        let size = view.image().size();
        let value = |pixel| {
            let value = view.image().get(pixel)?;
            let point = view.point_in_sensor(pixel)?;
            let range = (point - view.frame().ray(pixel)?.start).norm();
            let world = view.world_from_sensor() * point;
            let inside = (0..3).all(|k| (self.low[k]..=self.high[k]).contains(&world[k]));
            (inside && range <= self.max_range).then_some(value)
        };
        let values = size.all_pixels().map(|pixel| value(pixel).unwrap_or(f32::NAN)).collect();
        let image = RangeImage::from_values(size, values).map_err(|_| ViewError::NoValidPixel)?;
        view.with_image(image)
    }
}

impl Selection {
    /// Whether it is the whole scan.
    pub(crate) fn is_whole(&self) -> bool {
        *self == Self::default()
    }

    pub(crate) fn limits(&self, unit: LengthUnit) -> Result<Limits, WorkflowError> {
        let mut limits = Limits::default();
        if let Some(length) = self.max_range {
            limits.max_range = length.in_unit(unit);
            if limits.max_range <= 0.0 {
                let problem = format!("\"{length}\" leaves no pixel; write a length over 0");
                return Err(WorkflowError::setting("max_range", problem));
            }
        }
        let Some(crop) = &self.crop else { return Ok(limits) };
        for k in 0..3 {
            limits.low[k] = crop.low[k].map_or(limits.low[k], |length| length.in_unit(unit));
            limits.high[k] = crop.high[k].map_or(limits.high[k], |length| length.in_unit(unit));
        }
        if let Some(k) = (0..3).find(|&k| limits.low[k] >= limits.high[k]) {
            let (low, high, axis) = (limits.low[k], limits.high[k], ["x", "y", "z"][k]);
            let problem =
                format!("{axis} runs from {low} {unit} to {high} {unit}; write {axis}0 < {axis}1");
            return Err(WorkflowError::setting("crop", problem));
        }
        Ok(limits)
    }

    /// The numbers of the views, in the order of the scan.
    pub(crate) fn numbers(&self, scan: &Scan) -> Result<Vec<usize>, WorkflowError> {
        let every = self.every.unwrap_or(1);
        if every == 0 {
            return Err(WorkflowError::setting("every", "0 selects no view; write 1 or more"));
        }
        let Some(ViewList(text)) = &self.views else {
            return Ok((0..scan.views.len()).step_by(every).collect());
        };
        let mut chosen = vec![false; scan.views.len()];
        let names: Vec<&str> = scan.views.iter().map(ScanView::name).collect();
        for item in items(text, &names) {
            let named = numbers_of_name(names.iter().copied(), &item);
            let range = numbered(&item).filter(|r| named.is_empty() && *r.end() < chosen.len());
            let found: Vec<usize> = range.map_or(named, Iterator::collect);
            found.iter().for_each(|number| chosen[*number] = true);
            if found.is_empty() {
                let last = chosen.len().saturating_sub(1);
                let problem = format!(
                    "there is no view {item:?}; write names of views, or numbers from 0 to {last} \
                     such as 3-7,12"
                );
                return Err(WorkflowError::setting("views", problem));
            }
        }
        Ok((0..chosen.len()).filter(|&k| chosen[k]).step_by(every).collect())
    }
}

/// The items of a list with commas between them. As many parts as possible make up a name.
fn items(text: &str, names: &[&str]) -> Vec<String> {
    let parts: Vec<&str> = text.split(',').collect();
    let most = names.iter().map(|name| name.split(',').count()).max().unwrap_or(1);
    let (mut items, mut rest) = (Vec::new(), parts.as_slice());
    while let Some((first, later)) = rest.split_first() {
        let joined = |count: &usize| rest[..*count].join(",").trim().to_owned();
        let is_name = |count: &usize| names.contains(&joined(count).as_str());
        match (2..=most.min(rest.len())).rev().find(is_name) {
            Some(count) => {
                items.push(joined(&count));
                rest = &rest[count..];
            }
            None => {
                items.push(first.trim().to_owned());
                rest = later;
            }
        }
    }
    items
}

/// The numbers of the views of a name.
pub(crate) fn numbers_of_name<'a>(views: impl Iterator<Item = &'a str>, name: &str) -> Vec<usize> {
    views.enumerate().filter(|(_, view)| *view == name).map(|(number, _)| number).collect()
}

/// The numbers `3`, or `3-7` from 3 to 7; `None` for a name.
fn numbered(item: &str) -> Option<RangeInclusive<usize>> {
    let (first, last) = item.split_once('-').unwrap_or((item, item));
    Some(first.parse().ok()?..=last.parse().ok()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_with_commas_are_items_of_a_list() {
        let names = ["hall", "room 1, north", "room 1", "a,b,c", "a,b"];
        let list = |text: &str| items(text, &names).join("|");
        assert_eq!(list("hall, 3-7,12"), "hall|3-7|12");
        assert_eq!(list("hall, room 1, north,2"), "hall|room 1, north|2");
        assert_eq!(list("room 1,hall"), "room 1|hall");
        assert_eq!(list("a,b,c,a,b"), "a,b,c|a,b");
        assert_eq!((list("a,,b"), list("")), ("a||b".to_owned(), String::new()));
    }

    #[test]
    fn a_box_is_written_as_it_is_read() {
        for text in ["0,1m,,,-2.5cm,3", ",,,,,"] {
            assert_eq!(text.parse::<CropBox>().unwrap().to_string(), text);
        }
        for (text, wanted) in [("1,2", "has 2 lengths"), ("x,,,,,", "\"x\" is not a length")] {
            let error = text.parse::<CropBox>().unwrap_err().to_string();
            assert!(error.starts_with("crop: ") && error.contains(wanted), "{error}");
        }
    }
}
