//! Values that mean "no return".
//!
//! Zero, negative, infinite and NaN values are missing in every image, and the point (0, 0, 0) in
//! every grid. Programs write other values, too: the largest number of a type, 9999, or one point
//! again and again. A manifest can state such a value. This file finds the values that can be
//! nothing else, and refuses values that are neither plausible nor repeated.

use crate::Place;
use crate::error::Problem;
use serde::{Deserialize, Serialize};
use transect_device::{ImageSize, MISSING_POINT, Point3, RangeImage, median};

/// The value that an image's file holds where there was no return, before any scale.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a number, or [x, y, z] for a grid of points")]
pub enum MissingValue {
    /// A value of a range image.
    Number(f64),
    /// A point of a grid.
    Point([f64; 3]),
}

impl MissingValue {
    /// The value as a file of 32-bit numbers holds it.
    pub(crate) fn single(self) -> Self {
        let single = |value: f64| f64::from(narrowed(value));
        match self {
            Self::Number(value) => Self::Number(single(value)),
            Self::Point(point) => Self::Point(point.map(single)),
        }
    }

    /// The value after the scale of the file.
    pub(crate) fn scaled(self, scale: f64) -> Self {
        match self {
            Self::Number(value) => Self::Number(value * scale),
            Self::Point(point) => Self::Point(point.map(|c| c * scale)),
        }
    }
}

/// Fewest pixels with one value that make it a mark instead of a measurement. Theory: two of a
/// million 32-bit numbers share a value by chance, three of them far from all others do not.
/// Doubled, an image with few missing pixels keeps them as surface.
const FEWEST_REPEATS: usize = 3;

/// A repeated value this many times as far as every other value is a mark. Chosen by hand: marks
/// such as 9999 stand beside ranges below 100; a wall can stand 20 times as far as the object.
/// Doubled, 9999 beside ranges of 50 to 100 stays surface.
const FAR_OUTSIDE: f32 = 100.0;

/// Share of the pixels with the largest value from which a note tells of it. No unit. Chosen by
/// hand: 300 pixels of 640 × 480. Measured: no note on the red kitchen and on three simulated
/// depth cameras. Doubled, twice as many missing pixels are a surface in silence.
const BACKGROUND: f64 = 0.001;

/// The next largest value over that one, at most. No unit. Chosen by hand: walls have neighbours
/// nearly as far away. At 1, every wall without noise that faces its camera is told of.
const ALONE: f32 = 0.9;

/// A value this many times the median is refused. Chosen by hand: scanners reach from a tenth of a
/// metre to some kilometres, a factor of 1e5. Doubled, a value twice as absurd reaches the planes.
const ABSURD: f64 = 1e6;

/// How many times more often a mark occurs than the repetitions of the other points explain.
/// Theory: rounding repeats points where they are dense. The density of a scan varies with the
/// square of the range, up to 30² within a view. Doubled, rare marks in coarsely rounded grids stay
/// surface.
const MORE_OFTEN: f64 = 1000.0;

/// The kind of file that pixels come from, and with it the place to state missing ones.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Origin {
    /// An image or a grid that a manifest names, or an image of a folder of depth images.
    Manifest,
    /// A file of points that needs no manifest: E57, PTX, PCD, PLY, or a lidar's.
    PointFile,
}

/// Where the users of a folder of depth images have a manifest from.
const WITHOUT_MANIFEST: &str = ". For a folder of depth images, transect manifest FOLDER --out \
                                scan.json writes one";

/// The nearest 32-bit number. A finite value beyond all of them becomes the largest one, which the
/// search for absurd values finds; it would become infinite otherwise, and count as missing.
pub(crate) fn narrowed(value: f64) -> f32 {
    let largest = f64::from(f32::MAX);
    if value.is_finite() { value.clamp(-largest, largest) as f32 } else { value as f32 }
}

/// Makes the stated value NaN. `stated` holds the forms that the value may have in the image.
pub(crate) fn clear_stated(
    values: &mut [f32],
    stated: Option<[MissingValue; 2]>,
) -> Result<(), Problem> {
    for form in stated.into_iter().flatten() {
        let MissingValue::Number(mark) = form else {
            return Err(Problem::damaged("\"missing\" is a point; a range image needs a number"));
        };
        clear_value(values, narrowed(mark));
    }
    Ok(())
}

/// The image without repeated values far outside the rest. Refuses absurd values.
pub(crate) fn without_marks(
    image: RangeImage,
    notes: &mut Vec<String>,
) -> Result<RangeImage, Problem> {
    // Nearly every image ends here.
    if image.extremes().is_none_or(|(least, largest)| largest / least <= FAR_OUTSIDE) {
        notes.extend(background(&image));
        return Ok(image);
    }
    let size = image.size();
    let mut values: Vec<f32> = (0..size.rows).flat_map(|row| image.row(row)).copied().collect();
    while let Some((mark, count)) = far_mark(&values) {
        clear_value(&mut values, mark);
        notes.push(note(count, &format!("{mark:?}"), Origin::Manifest));
    }
    let text = |at: usize| values.get(at).map_or_else(String::new, |v| format!("{v:?}"));
    refuse_absurd(size, Origin::Manifest, || values.iter().map(|v| f64::from(*v)), text)?;
    let image =
        RangeImage::from_values(size, values).map_err(|e| Problem::damaged(e.to_string()))?;
    notes.extend(background(&image));
    Ok(image)
}

/// The note on a value that many pixels hold and that may be a background, not a surface.
fn background(image: &RangeImage) -> Option<String> {
    let (least, largest) = image.extremes()?;
    let (size, rows) = (image.size(), || (0..image.size().rows).map(|row| image.row(row)));
    let count: usize = rows().map(|row| row.iter().filter(|v| **v == largest).count()).sum();
    let many = count >= FEWEST_REPEATS && count as f64 >= BACKGROUND * size.pixels() as f64;
    if least == largest || !many {
        return None;
    }
    let is_alone = |v: &f32| v.is_nan() || *v == largest || *v < ALONE * largest;
    rows().flatten().all(is_alone).then(|| {
        format!(
            "{count} pixels hold exactly {largest:?}, and no other is as far away. They are taken \
             for a surface; if the value stands for no return, state \"missing\": {largest:?} in \
             the view's entry in scan.json (divided by its scale, if it has one){WITHOUT_MANIFEST}"
        )
    })
}

fn clear_value(values: &mut [f32], mark: f32) {
    values.iter_mut().filter(|v| **v == mark).for_each(|v| *v = f32::NAN);
}

/// The largest value and its count, if it repeats and is far outside the other values.
fn far_mark(values: &[f32]) -> Option<(f32, usize)> {
    let valid = || values.iter().copied().filter(|v| *v > 0.0 && v.is_finite());
    let largest = valid().reduce(f32::max)?;
    let second = valid().filter(|v| *v < largest).reduce(f32::max)?;
    let count = valid().filter(|v| *v == largest).count();
    let far = largest / second > FAR_OUTSIDE && count >= FEWEST_REPEATS;
    far.then_some((largest, count))
}

/// Makes the stated point NaN. `stated` holds the forms that the point may have in the grid.
pub(crate) fn clear_stated_point(
    points: &mut [Point3],
    stated: Option<[MissingValue; 2]>,
) -> Result<(), Problem> {
    for form in stated.into_iter().flatten() {
        let MissingValue::Point(mark) = form else {
            return Err(Problem::damaged("\"missing\" is a number; a grid needs [x, y, z]"));
        };
        clear_point(points, &Point3::from(mark));
    }
    Ok(())
}

/// Makes points that occur far more often than the others NaN. Refuses absurd points.
pub(crate) fn clear_points(
    size: ImageSize,
    points: &mut [Point3],
    origin: Origin,
    notes: &mut Vec<String>,
) -> Result<(), Problem> {
    while let Some((mark, count)) = repeated_mark(points) {
        clear_point(points, &mark);
        notes.push(note(count, &format!("[{}, {}, {}]", mark.x, mark.y, mark.z), origin));
    }
    let text = |at: usize| {
        points.get(at).map_or_else(String::new, |p| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z))
    };
    refuse_absurd(size, origin, || points.iter().map(|p| p.coords.norm()), text)
}

fn clear_point(points: &mut [Point3], mark: &Point3) {
    points.iter_mut().filter(|p| *p == mark).for_each(clear);
}

fn clear(point: &mut Point3) {
    *point = MISSING_POINT;
}

/// The most frequent point and its count, if the other points do not explain the count.
fn repeated_mark(points: &[Point3]) -> Option<(Point3, usize)> {
    let valid = |p: &&Point3| p.coords.norm().is_finite() && **p != Point3::origin();
    let mut hashes: Vec<u64> = points.iter().filter(valid).map(hash).collect();
    hashes.sort_unstable();
    let runs = || hashes.chunk_by(u64::eq);
    // Of equally frequent points the largest hash: the order of pixels does not matter.
    let most = runs().max_by_key(|run| run.len()).filter(|run| run.len() > FEWEST_REPEATS)?;
    let others = hashes.len() - most.len();
    let repeats = others as f64 / (runs().count() as f64 - 1.0).max(1.0) - 1.0;
    let explained = FEWEST_REPEATS as f64 + MORE_OFTEN * repeats.max(0.0);
    let mark = points.iter().filter(valid).find(|p| Some(&hash(p)) == most.first())?;
    let count = points.iter().filter(|p| *p == mark).count();
    (count as f64 > explained).then_some((*mark, count))
}

/// A hash of the coordinates (Knuth's multiplicative method).
fn hash(point: &Point3) -> u64 {
    let mixed = |hash: u64, c: &f64| (hash.rotate_left(23) ^ c.to_bits()).wrapping_mul(GOLDEN);
    point.iter().fold(0, mixed)
}

/// 2⁶⁴ divided by the golden ratio, made odd: spreads equal low bits over the whole hash.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Refuses the largest distance if it is absurd beside the median. `text` shows the content of a
/// pixel by its number, as the key `missing` states it.
fn refuse_absurd<I: Iterator<Item = f64>>(
    size: ImageSize,
    origin: Origin,
    distances: impl Fn() -> I,
    text: impl Fn(usize) -> String,
) -> Result<(), Problem> {
    let valid = || distances().filter(|v| *v > 0.0 && v.is_finite());
    let extremes = (f64::INFINITY, 0.0_f64);
    let (least, largest) = valid().fold(extremes, |(low, high), v| (low.min(v), high.max(v)));
    // No median is smaller than the least distance, so most images need no sorting.
    if largest <= ABSURD * least {
        return Ok(());
    }
    let Some(median) = median(valid()).filter(|median| largest > ABSURD * median) else {
        return Ok(());
    };
    let at = distances().position(|v| v == largest).unwrap_or_default();
    let value = text(at);
    let remedy = match origin {
        Origin::Manifest => format!(
            "add \"missing\": {value} to the view in scan.json (divided by its scale, if it has \
             one){WITHOUT_MANIFEST}"
        ),
        Origin::PointFile => "export it as the point 0 0 0".to_owned(),
    };
    let problem = format!(
        "the pixel holds {value}; values over {ABSURD:e} times the median, {median:e}, are \
         refused. If it means \"no return\", {remedy}; otherwise correct the pixel"
    );
    Err(Problem::at(Place::Pixel(size.pixel(at)), problem))
}

fn note(count: usize, value: &str, origin: Origin) -> String {
    let remedy = match origin {
        Origin::Manifest => format!(
            "\"missing\": {value} in the view's entry in scan.json states it without a note (divide \
             the value by its scale, if it has one){WITHOUT_MANIFEST}"
        ),
        Origin::PointFile => "export them as the point 0 0 0 to state it without a note".to_owned(),
    };
    format!(
        "{count} pixels hold exactly {value}, unlike any surface, and count as missing; {remedy}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize { rows: 4, cols: 8 };

    fn ranges() -> Vec<f32> {
        (0..32).map(|n| 2.0 + 0.25 * n as f32).collect()
    }

    /// The values that stay; NaN where missing.
    fn cleared(
        mut values: Vec<f32>,
        stated: Option<MissingValue>,
    ) -> Result<(Vec<f32>, Vec<String>), String> {
        let text = |p: Problem| format!("{}: {}", p.at, p.text);
        clear_stated(&mut values, stated.map(|stated| [stated; 2])).map_err(text)?;
        let mut notes = Vec::new();
        let image = RangeImage::from_values(SIZE, values).unwrap();
        let image = without_marks(image, &mut notes).map_err(text)?;
        Ok(((0..SIZE.rows).flat_map(|row| image.row(row)).copied().collect(), notes))
    }

    #[test]
    fn marks_far_outside_the_ranges_are_missing() {
        let mut values = ranges();
        for (n, mark) in [(3, 9999.0), (9, 9999.0), (20, 9999.0)] {
            values[n] = mark;
        }
        values[24..30].fill(f32::MAX);
        let (values, notes) = cleared(values, None).unwrap();
        assert!(notes[0].starts_with("6 pixels hold exactly 3.4028235e38, unlike"), "{notes:?}");
        assert!(notes[1].starts_with("3 pixels hold exactly 9999.0, unlike"), "{notes:?}");
        assert_eq!(values.iter().filter(|v| v.is_nan()).count(), 9);
    }

    #[test]
    fn walls_and_rounded_depths_stay() {
        let mut wall = ranges();
        wall[8..].fill(3.75);
        let counts: Vec<f32> = (0..32).map(|n| 0.001 * (500 + n / 8) as f32).collect();
        for values in [wall, counts] {
            assert_eq!(cleared(values.clone(), None), Ok((values, Vec::new())));
        }
    }

    #[test]
    fn a_background_stays_and_is_told() {
        let mut values = ranges();
        values[8..].fill(60.0);
        let (left, notes) = cleared(values.clone(), None).unwrap();
        assert_eq!(left, values);
        let told = |notes: &[String]| notes[0].starts_with("24 pixels hold exactly 60.0, and no");
        assert!(told(&notes), "{notes:?}");
        // One pixel before the sensor's nose makes the least range a thousandth of the largest.
        values[3] = 0.05;
        let (left, notes) = cleared(values.clone(), None).unwrap();
        assert!(left == values && told(&notes), "{notes:?}");
    }

    #[test]
    fn a_thousandth_of_the_pixels_is_told() {
        let told = |count: usize| {
            let mut values: Vec<f32> = (0..64 * 64).map(|k| 2.0 + 1e-4 * k as f32).collect();
            values[..count].fill(8.0);
            background(&RangeImage::from_values(ImageSize { rows: 64, cols: 64 }, values).unwrap())
        };
        assert!(told(5).is_some() && told(4).is_none());
    }

    #[test]
    fn a_stated_value_is_missing_without_a_note() {
        let (values, notes) = cleared(ranges(), Some(MissingValue::Number(2.5))).unwrap();
        assert!(notes.is_empty() && values[2].is_nan() && values[3] == 2.75);
        let point = cleared(values, Some(MissingValue::Point([0.0; 3])));
        assert!(point.unwrap_err().contains("a range image needs a number"));
    }

    #[test]
    fn an_absurd_pixel_is_named() {
        let mut values = ranges();
        values[13] = 3.4e38;
        let error = cleared(values.clone(), None).unwrap_err();
        let wanted = ", row 1, column 5: the pixel holds 3.4e38; values over 1e6 times the median";
        assert!(error.starts_with(wanted), "{error}");
        assert!(error.contains("add \"missing\": 3.4e38 to the view"), "{error}");
        assert!(cleared(values.clone(), Some(MissingValue::Number(3.4e38))).is_ok());
        // A 64-bit file holds a value that no 32-bit number reaches.
        values[13] = narrowed(1e300);
        assert!(cleared(values.clone(), None).unwrap_err().starts_with(", row 1, column 5"));
        assert!(cleared(values.clone(), Some(MissingValue::Number(1e300))).is_ok());
        assert!(narrowed(f64::INFINITY).is_infinite() && narrowed(f64::NAN).is_nan());
    }

    fn surface() -> Vec<Point3> {
        (0..32).map(|n| Point3::new(f64::from(n % 8), f64::from(n / 8), 3.0)).collect()
    }

    #[test]
    fn a_point_that_repeats_is_missing() {
        for mark in [[0.0, 0.0, -1.0], [-1.0; 3], [-9999.0; 3]] {
            let mut points = surface();
            points.iter_mut().step_by(6).for_each(|p| *p = Point3::from(mark));
            let mut notes = Vec::new();
            assert!(clear_points(SIZE, &mut points, Origin::PointFile, &mut notes).is_ok());
            assert_eq!(points.iter().filter(|p| p.x.is_nan()).count(), 6);
            assert!(
                notes[0].starts_with("6 pixels hold exactly [") && notes.len() == 1,
                "{notes:?}"
            );
        }
        let mut points = surface();
        let stated = Some([MissingValue::Point([1.0, 2.0, 3.0]); 2]);
        assert!(clear_stated_point(&mut points, stated).is_ok());
        assert_eq!(points.iter().position(|p| p.x.is_nan()), Some(17));
    }

    /// Only a manifest has keys.
    #[test]
    fn advice_for_points_names_what_their_file_can_hold() {
        for (origin, advice) in [
            (Origin::Manifest, "\"missing\": [-1, -1, -1] in the view's entry in scan.json"),
            (Origin::PointFile, "export them as the point 0 0 0"),
        ] {
            let mut points = surface();
            points.iter_mut().step_by(6).for_each(|p| *p = Point3::new(-1.0, -1.0, -1.0));
            let mut notes = Vec::new();
            assert!(clear_points(SIZE, &mut points, origin, &mut notes).is_ok());
            let has_key = notes[0].contains("\"missing\"");
            assert!(notes[0].contains(advice), "{notes:?}");
            assert_eq!(has_key, matches!(origin, Origin::Manifest));
            points[5] = Point3::new(3e30, 0.0, 0.0);
            let error = clear_points(SIZE, &mut points, origin, &mut notes).unwrap_err();
            let error = error.in_file(std::path::Path::new("a")).to_string();
            assert_eq!(error.contains("\"missing\""), has_key, "{error}");
            assert_eq!(error.contains("export it as the point 0 0 0"), !has_key, "{error}");
        }
    }

    /// Rounding to whole units puts four pixels on one point.
    #[test]
    fn points_that_rounding_repeats_stay() {
        let size = ImageSize { rows: 40, cols: 40 };
        let point = |n: i32| Point3::new(f64::from(n % 40 / 2), f64::from(n / 80), 30.0);
        let mut points: Vec<Point3> = (0..1600).map(point).collect();
        // A place near the sensor, where the grid is denser.
        points[..30].fill(Point3::new(0.0, 0.0, 1.0));
        let (before, mut notes) = (points.clone(), Vec::new());
        assert!(clear_points(size, &mut points, Origin::PointFile, &mut notes).is_ok());
        assert_eq!((points, notes), (before, Vec::new()));
    }
}
