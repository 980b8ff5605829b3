//! Charts: lines and dots over two axes.

use transect_exchange::svg::{Anchor, Figure};
use transect_geometry::Point2;

/// Width and height of the plotted field, in pixels.
const SIZE: [f64; 2] = [560.0, 380.0];

/// Steps of an axis at least. No unit. Chosen by hand. Doubled, labels get crowded.
const STEPS: f64 = 5.0;

/// The range of an axis, and where it has grid lines.
pub struct Axis {
    range: [f64; 2],
    is_logarithmic: bool,
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// An axis with labels at round numbers.
    pub fn linear(range: [f64; 2]) -> Self {
        let coarsest = (range[1] - range[0]) / STEPS;
        let decade = 10_f64.powf(coarsest.log10().floor());
        let step = [5.0, 2.0, 1.0].map(|k| k * decade).into_iter().find(|s| *s <= coarsest);
        let step = step.unwrap_or(decade);
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let label = |k: i64| (k as f64 * step, format!("{:.decimals$}", k as f64 * step));
        let ticks = (range[0] / step).ceil() as i64..=(range[1] / step).floor() as i64;
        Self { range, is_logarithmic: false, ticks: ticks.map(label).collect() }
    }

    /// An axis in decades, with labels at some numbers.
    pub fn logarithmic(range: [f64; 2], ticks: Vec<f64>, unit: &str) -> Self {
        let ticks = ticks.into_iter().map(|tick| (tick, format!("{tick}{unit}"))).collect();
        Self { range, is_logarithmic: true, ticks }
    }

    /// Where a value lies, from 0 to 1.
    fn share(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.is_logarithmic {
            true => (value / low).log10() / (high / low).log10(),
            false => (value - low) / (high - low),
        }
    }
}

/// A figure with a grid over two axes, x and y.
pub struct Chart {
    pub figure: Figure,
    axes: [Axis; 2],
}

impl Chart {
    /// An empty chart. The caption says what the axes are.
    pub fn new(title: &str, caption: &str, axes: [Axis; 2]) -> Self {
        let figure = Figure::new(title, caption, [SIZE[0], SIZE[1] + 30.0]);
        let mut chart = Self { figure, axes };
        for k in [1, 0] {
            for (value, label) in chart.axes[k].ticks.clone() {
                let [mut first, mut last] =
                    [0, 1].map(|end| chart.axes.each_ref().map(|a| a.range[end]));
                (first[k], last[k]) = (value, value);
                let ends = [chart.place(first), chart.place(last)];
                chart.figure.line(&ends, false, "stroke=\"#ddd\"");
                let (at, anchor) = match k {
                    0 => (Point2::new(ends[0].x, SIZE[1] + 20.0), Anchor::Middle),
                    _ => (Point2::new(-6.0, ends[0].y + 5.0), Anchor::End),
                };
                chart.figure.text(at, anchor, 14.0, "#222", &label);
            }
        }
        chart
    }

    fn place(&self, [x, y]: [f64; 2]) -> Point2 {
        Point2::new(SIZE[0] * self.axes[0].share(x), SIZE[1] * (1.0 - self.axes[1].share(y)))
    }

    /// A line through points.
    pub fn line(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: &str, width: f64) {
        let places: Vec<Point2> = points.into_iter().map(|p| self.place(p)).collect();
        let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\"");
        self.figure.line(&places, false, &style);
    }

    /// A dot at each point.
    pub fn dots(&mut self, points: impl IntoIterator<Item = [f64; 2]>, colour: &str, radius: f64) {
        for point in points {
            self.figure.circle(self.place(point), radius, &format!("fill=\"{colour}\""));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_and_inside_the_range() {
        let labels = |range| -> Vec<String> {
            Axis::linear(range).ticks.into_iter().map(|(_, label)| label).collect()
        };
        assert_eq!(labels([0.3, 2.9]), ["0.5", "1.0", "1.5", "2.0", "2.5"]);
        assert_eq!(labels([-41.0, 12.0]), ["-40", "-30", "-20", "-10", "0", "10"]);
        let axis = Axis::logarithmic([0.01, 1.0], vec![0.1], "°");
        assert_eq!(axis.ticks[0].1, "0.1°");
        assert!((axis.share(0.1) - 0.5).abs() < 1e-12);
    }
}
