//! Smoothing against the slow, obvious way: pixel by pixel in double precision.

use crate::surfaces::{Normal, camera, look, pixels, radar, shared_noise};
use nalgebra::{Matrix6, Vector6};
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageSize, Isometry3, Neighbour, Pixel, Point3, RangeImage, View,
};
use transect_image::smooth::smooth;
use transect_image::{BreakRule, RangeNoise, length_per_value};
use transect_sensors::{AngularScan, ImagingRadar};

const REACH: i64 = 10;
const CUT: f64 = 5.0;
/// Largest change, in cuts.
const LARGEST: f64 = 4.0 / CUT;

struct Twin<'a> {
    view: &'a View,
    rule: BreakRule,
    noise: RangeNoise,
}

/// What becomes of a pixel.
#[derive(Debug)]
enum Expected {
    Stays,
    Changes {
        value: f64,
        factor: f64,
    },
    /// Rounding decides.
    Close,
}

impl Twin<'_> {
    fn size(&self) -> ImageSize {
        self.view.image().size()
    }

    /// The pixel some rows and columns away, across the seam of a full circle.
    fn at(&self, from: Pixel, rows: i64, cols: i64) -> Option<Pixel> {
        let (row, mut col) = (from.row as i64 + rows, from.col as i64 + cols);
        if self.view.frame().columns_wrap() {
            col = col.rem_euclid(self.size().cols as i64);
        }
        let inside = |at: i64, count: usize| usize::try_from(at).ok().filter(|at| *at < count);
        Some(Pixel::new(inside(row, self.size().rows)?, inside(col, self.size().cols)?))
    }

    fn pair(&self, pixel: Pixel, neighbour: Neighbour) -> Option<f64> {
        let other = self.view.frame().neighbour(pixel, neighbour)?;
        let pair = self.view.frame().pair(self.view.image(), pixel, other)?;
        self.rule.holds(&pair).then_some(f64::from(pair.lateral))
    }

    fn spacing(&self, pixel: Pixel) -> Option<(f64, f64)> {
        let later = |rows, cols, n| self.at(pixel, rows, cols).and_then(|p| self.pair(p, n));
        let across = later(0, 1, Neighbour::Left).or(self.pair(pixel, Neighbour::Left))?;
        let down = later(1, 0, Neighbour::Up).or(self.pair(pixel, Neighbour::Up))?;
        Some((across, down))
    }

    /// Whether a pixel is alone between two surfaces, across or down.
    fn is_flying(&self, pixel: Pixel) -> bool {
        let joined = |(rows, cols): (i64, i64), neighbour: Neighbour, k: i64| {
            let at = self.at(pixel, k * rows, k * cols);
            at.and_then(|p| self.pair(p, neighbour)).is_some()
        };
        let [across, down] = [((0, 1), Neighbour::Left), ((1, 0), Neighbour::Up)];
        let alone =
            [across, down].iter().all(|(to, n)| ![0, 1].iter().any(|k| joined(*to, *n, *k)));
        let between = |(to, neighbour): ((i64, i64), Neighbour)| {
            let at = |k: i64| self.at(pixel, k * to.0, k * to.1);
            let surfaces = joined(to, neighbour, -1) && joined(to, neighbour, 2);
            let value = |k: i64| at(k).and_then(|p| self.view.image().get(p)).map(f64::from);
            let step = |k: i64| Some(value(k)? - value(k - 1)?);
            let [Some(a), Some(b), Some(c), Some(d)] = [-1, 0, 1, 2].map(step) else {
                return false;
            };
            let rim = 1.0 + 2_f64.sqrt();
            surfaces && b * c > 0.0 && b.abs() > rim * a.abs() && c.abs() > rim * d.abs()
        };
        alone && (between(across) || between(down))
    }

    /// The view without its flying pixels, and their number.
    fn without_flying(&self) -> (View, usize) {
        let image = self.view.image();
        let flies = |p: Pixel| image.get(p).is_some() && self.is_flying(p);
        let keep = |p: Pixel| image.get(p).filter(|_| !flies(p)).unwrap_or(f32::NAN);
        let values = pixels(self.size()).map(keep).collect();
        let left = RangeImage::from_values(self.size(), values).unwrap();
        let count = image.valid_count() - left.valid_count();
        (self.view.with_image(left).unwrap(), count)
    }

    /// The offsets that are reached without turning back.
    fn connected(&self, centre: Pixel) -> Vec<(i64, i64)> {
        let mut reached = Vec::new();
        let mut fill = |row: i64, seeds: Vec<i64>| -> Vec<i64> {
            let mut cols = seeds;
            let mut k = 0;
            while k < cols.len() {
                for step in [-1, 1] {
                    let next = cols[k] + step;
                    let right = self.at(centre, row, cols[k].max(next));
                    let open = right.and_then(|p| self.pair(p, Neighbour::Left)).is_some();
                    if open && next.abs() <= REACH && !cols.contains(&next) {
                        cols.push(next);
                    }
                }
                k += 1;
            }
            reached.extend(cols.iter().map(|col| (row, *col)));
            cols
        };
        let middle = fill(0, vec![0]);
        for direction in [-1, 1] {
            let mut cols = middle.clone();
            for distance in 1..=REACH {
                let row = direction * distance;
                let lower = if direction > 0 { row } else { row + 1 };
                cols.retain(|&col| {
                    let pixel = self.at(centre, lower, col);
                    pixel.and_then(|p| self.pair(p, Neighbour::Up)).is_some()
                });
                cols = fill(row, cols);
            }
        }
        reached
    }

    fn expected(&self, pixel: Pixel) -> Expected {
        let image = self.view.image();
        let Some(d3) = image.get(pixel).map(f64::from) else { return Expected::Stays };
        let Some((across, down)) = self.spacing(pixel) else { return Expected::Stays };
        let rate = length_per_value(self.view.frame(), pixel, d3).unwrap();
        let sigma = self.noise.value_sigma(d3, rate);
        let spacing = (across * down).sqrt();
        let radius = 6.0 * (sigma * rate / spacing).cbrt();
        if radius < 2.3 {
            return Expected::Stays;
        }
        let radius = radius.min(7.5);
        let (rows, cols) = (
            (radius * spacing / down).clamp(1.0, 7.5),
            (radius * spacing / across).clamp(1.0, 7.5),
        );
        let of = |rows: f64, cols: f64| -> Vec<Sample> {
            let sample = |&(dy, dx): &(i64, i64)| {
                let value = f64::from(image.get(self.at(pixel, dy, dx)?)?);
                let (y, x) = (dy as f64, dx as f64);
                let squared = (y / rows).powi(2) + (x / cols).powi(2);
                let weight = (1.0 - squared * squared).max(0.0).powi(2);
                let residual = (1.0 / value - 1.0 / d3) / (CUT * sigma / (d3 * d3));
                Some((Vector6::new(1.0, x, y, x * x, x * y, y * y), residual, weight))
            };
            // Half of the rows is enough where neighbours share their noise.
            let apart = if self.noise.is_mostly_shared() { 2 } else { 1 };
            let connected = self.connected(pixel);
            connected.iter().filter(|(dy, _)| dy % apart == 0).filter_map(sample).collect()
        };
        let wider = |radius: f64| (1.5 * radius).min(10.5);
        let windows = [of(rows, cols), of(wider(rows), wider(cols))];
        solve(&windows, d3, CUT * sigma / (d3 * d3)).unwrap_or(Expected::Close)
    }
}

/// Terms at the place, value, weight by distance.
type Sample = (Vector6<f64>, f64, f64);

/// Change and variance at the centre, and the polynomial; `None` where rounding decides.
fn fit(samples: &[Sample], last: Option<&Vector6<f64>>) -> Option<(f64, f64, Vector6<f64>)> {
    let weight = |x: &Vector6<f64>, v: f64, w: f64| {
        let residual = last.map_or(0.0, |last| v - last.dot(x));
        w * (1.0 - residual * residual).max(0.0).powi(2)
    };
    let (mut gram, mut right) = (Matrix6::zeros(), Vector6::zeros());
    for (x, v, w) in samples {
        gram += x * x.transpose() * weight(x, *v, *w);
        right += x * (weight(x, *v, *w) * v);
    }
    let scale = gram.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
    let scaled = Matrix6::from_diagonal(&scale) * gram * Matrix6::from_diagonal(&scale);
    if scaled.symmetric_eigenvalues().min() < 2e-3 {
        return None;
    }
    let inverse = gram.try_inverse().unwrap();
    let centre = inverse.column(0).into_owned();
    let shares = samples.iter().map(|(x, v, w)| (weight(x, *v, *w) * centre.dot(x), *v));
    let (change, variance) =
        shares.fold((0.0, 0.0), |(c, q), (share, v)| (c + share * v, q + share * share));
    Some((change, variance, inverse * right))
}

fn close_to(a: f64, b: f64) -> bool {
    (a - b).abs() < 0.01 * b
}

fn solve([narrow, wide]: &[Vec<Sample>; 2], d3: f64, cut: f64) -> Option<Expected> {
    let (_, _, first) = fit(narrow, None)?;
    let (_, _, second) = fit(narrow, Some(&first))?;
    let (mut change, mut variance, _) = fit(narrow, Some(&second))?;
    let (wide_change, wide_variance, _) = fit(wide, Some(&second))?;
    let limits = [change.abs(), variance, wide_change.abs()];
    if limits.iter().any(|v| close_to(*v, 1.0) || close_to(*v, LARGEST))
        || (variance - wide_variance).abs() < 1e-3
    {
        return None;
    }
    if change.abs() > LARGEST || variance > 1.0 {
        return Some(Expected::Stays);
    }
    if wide_variance < variance && wide_change.abs() < LARGEST {
        let apart = (CUT * (wide_change - change)).powi(2);
        let share = (1.0 - apart / (variance - wide_variance) / 9.0).max(0.0).powi(2);
        change += share * (wide_change - change);
        variance += share * (wide_variance - variance) + 0.7 * apart.min(1.0);
    }
    if close_to(variance, 1.0) || close_to(change.abs(), LARGEST) {
        return None;
    }
    let value = 1.0 / (1.0 / d3 + change * cut);
    let stays = variance > 1.0;
    Some(if stays { Expected::Stays } else { Expected::Changes { value, factor: variance.sqrt() } })
}

/// Compares all pixels; the shares of the pixels that changed, and that could not be compared.
fn compare(view: &View) -> (f64, f64) {
    let noise = RangeNoise::of(view);
    let rule = BreakRule::new(78_f64.to_radians(), 4.0 * noise.length());
    let result = smooth(view, &noise, &rule).unwrap();
    let (view, flying) = Twin { view, rule, noise }.without_flying();
    assert_eq!(result.flying, flying);
    let twin = Twin { view: &view, rule, noise };
    let (mut changed, mut close) = (0, 0);
    for pixel in pixels(view.image().size()) {
        let (old, new) = (view.image().get(pixel), result.view.image().get(pixel));
        match twin.expected(pixel) {
            Expected::Close => close += 1,
            Expected::Stays => assert_eq!((old, 1.0), (new, result.factor(pixel)), "{pixel}"),
            Expected::Changes { value, factor } => {
                changed += 1;
                let rate = length_per_value(twin.view.frame(), pixel, value).unwrap();
                let apart = (value - f64::from(new.unwrap())) / twin.noise.value_sigma(value, rate);
                assert!(apart.abs() < 0.01, "{pixel}: {value} and {new:?}, {apart} sigma apart");
                let factors = (factor, result.factor(pixel));
                assert!((factors.0 - factors.1).abs() < 0.01, "{pixel}: {factors:?}");
            }
        }
    }
    let valid = view.image().valid_count() as f64;
    (f64::from(changed) / valid, f64::from(close) / valid)
}

/// Two balls before a wall, or around: seen along any axis.
fn scene(p: &Point3) -> f64 {
    let ball = |x: f64, y: f64, z: f64, r: f64| (p - Point3::new(x, y, z)).norm() - r;
    let balls =
        ball(0.3, 0.2, 3.0, 0.8).min(ball(3.0, 0.2, -0.3, 0.8)).min(ball(-3.0, 0.0, 0.0, 1.0));
    let tube = 4.0 - p.coords.norm() * 0.5 - p.coords.xy().norm() * 0.5;
    balls.min(tube)
}

fn with_missing(view: &View, share: f64) -> View {
    let mut random = Normal(3);
    let size = view.image().size();
    let keep = |p: Pixel| view.image().get(p).filter(|_| random.uniform() > share);
    let values = pixels(size).map(keep).map(|v| v.unwrap_or(f32::NAN)).collect();
    view.with_image(RangeImage::from_values(size, values).unwrap()).unwrap()
}

#[test]
fn every_pixel_is_as_the_slow_way_says() {
    let all = [(0.1, 0.02), (0.5, 0.02), (2.5, 0.02), (0.5, 0.4)];
    for (frame, cases) in [(camera(), &all[..]), (radar(), &all[1..2])] {
        for &(ratio, missing) in cases {
            let sigma = ratio * 3.0 / 120.0;
            let view = with_missing(&look(&frame, scene, sigma, Some(sigma)), missing);
            let (changed, close) = compare(&view);
            println!("{ratio}: {changed:.3} changed, {close:.3} not compared");
            assert!(close < 0.05, "{ratio}: {close}");
            assert!(missing > 0.1 || changed > 0.7, "{ratio}: {changed}");
        }
    }
}

#[test]
fn every_second_row_is_as_the_slow_way_says() {
    let sigma = 0.004;
    let own = look(&camera(), scene, sigma, None);
    let mut shared = shared_noise(own.image().size(), 4, 5).into_iter();
    let mut with_shared = |v: f32| v + (2.0 * sigma * shared.next().unwrap()) as f32;
    let values =
        pixels(own.image().size()).map(|p| own.image().get(p).map_or(f32::NAN, &mut with_shared));
    let image = RangeImage::from_values(own.image().size(), values.collect()).unwrap();
    let view = own.with_image(image).unwrap();
    assert!(RangeNoise::of(&view).is_mostly_shared(), "or else all rows count");
    let (changed, close) = compare(&view);
    println!("{changed:.3} changed, {close:.3} not compared");
    assert!(changed > 0.7 && close < 0.05, "{changed} {close}");
}

/// A full circle of 160 columns that starts at a column.
fn circle(first: usize) -> Arc<dyn DeviceFrame> {
    let step = std::f64::consts::TAU / 160.0;
    let theta = AngularScan::from_radians(first as f64 * step, step);
    let phi = AngularScan::from_radians(-0.4, 0.02);
    Arc::new(ImagingRadar::new(ImageSize { rows: 40, cols: 160 }, theta, phi).unwrap())
}

#[test]
fn a_full_circle_has_no_seam() {
    let sigma = 0.05;
    let view = look(&circle(0), scene, sigma, Some(sigma));
    assert!(view.frame().columns_wrap());
    let (changed, _) = compare(&view);
    assert!(changed > 0.9, "{changed}");
    // Whole blocks of pixels, which share what follows from the noise of one of them.
    let (size, shift) = (view.image().size(), 48);
    let shifted = |p: Pixel| {
        let from = Pixel::new(p.row, (p.col + shift) % size.cols);
        view.image().get(from).unwrap_or(f32::NAN)
    };
    let image = RangeImage::from_values(size, pixels(size).map(shifted).collect()).unwrap();
    let turned = View::new("turned", image, circle(shift), Isometry3::identity(), Some(sigma));
    let turned = turned.unwrap();
    let rule = BreakRule::new(78_f64.to_radians(), 4.0 * sigma);
    let [a, b] = [&view, &turned].map(|v| smooth(v, &RangeNoise::of(v), &rule).unwrap().view);
    for pixel in pixels(size) {
        let from = Pixel::new(pixel.row, (pixel.col + shift) % size.cols);
        let (x, y) = (a.image().get(from), b.image().get(pixel));
        let same = x.zip(y).map_or(x == y, |(x, y)| (x - y).abs() < 1e-3 * sigma as f32);
        assert!(same, "{pixel}: {x:?} and {y:?}");
    }
}
