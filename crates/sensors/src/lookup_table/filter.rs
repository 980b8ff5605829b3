//! Median filters for calibration data (4.7.2).
//!
//! The series of a sweep slope: `u` grows by a step from column to column. A plain running median
//! of a sloping series answers an outlier with a neighbour's value, one whole step off. So the
//! window's own slope goes first. Siegel's repeated median (Biometrika 69, 1982) draws a line
//! through the window, which fewer than half of its samples cannot move. The filter's value is the
//! median about that line. The line also serves the ends of a series, where no window fits around
//! the sample, and columns without a sample.
//!
//! A line cuts corners off a bent series, by `½ y″ Δθ²` times 4 in a window of seven. Filtering
//! what the first pass left over and adding it ("twicing", Tukey 1977) gives that back.

/// Samples of one series over column numbers, columns rising.
pub(super) struct Series<'a> {
    /// Columns, strictly rising.
    pub(super) columns: &'a [f64],
    /// One value per column.
    pub(super) values: &'a [f64],
}

impl Series<'_> {
    /// The values of the filter at `targets`, whose columns lie among the series'.
    ///
    /// A window of 1 leaves samples as they are.
    pub(super) fn filtered_at(&self, targets: &[f64], window: usize) -> Vec<f64> {
        let first = |at: &f64| self.local_line_at(*at, window);
        let rough: Vec<f64> = self.columns.iter().map(first).collect();
        let left: Vec<f64> = self.values.iter().zip(&rough).map(|(y, r)| y - r).collect();
        let left = Series { columns: self.columns, values: &left };
        targets.iter().map(|at| first(at) + left.local_line_at(*at, window)).collect()
    }

    /// The repeated-median line of the window about a column, at that column.
    fn local_line_at(&self, at: f64, window: usize) -> f64 {
        let window = window.clamp(1, self.columns.len().max(1));
        let next = self.columns.partition_point(|c| *c < at);
        let start = next.saturating_sub(window / 2).min(self.columns.len() - window);
        let pairs = self.columns.iter().zip(self.values).skip(start).take(window);
        let near: Vec<(f64, f64)> = pairs.map(|(c, y)| (c - at, *y)).collect();
        let slope = repeated_median_slope(&near);
        median(near.iter().map(|(c, y)| y - slope * c).collect())
    }
}

/// Median over all points of the median slope to the other points; 0 for a single point.
fn repeated_median_slope(points: &[(f64, f64)]) -> f64 {
    let slope_from = |(i, (x, y)): (usize, &(f64, f64))| {
        let others = points.iter().enumerate().filter(|(k, _)| *k != i);
        median(others.map(|(_, (other_x, other_y))| (other_y - y) / (other_x - x)).collect())
    };
    if points.len() < 2 {
        return 0.0;
    }
    median(points.iter().enumerate().map(slope_from).collect())
}

/// The median, the mean of the two middle values for an even count; NaN for none.
///
/// Not [`transect_device::median`]: each of seven samples has six slopes to the others, and the
/// upper of the two in the middle would tilt the line.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len().saturating_sub(1) / 2;
    let count = 2 - values.len() % 2;
    mean(values.iter().skip(middle).take(count))
}

/// The mean of the middle third of the sorted values (4.7.2); of all, if there are one or two.
pub(super) fn middle_third_mean(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let third = values.len() / 3;
    mean(values.iter().skip(third).take(values.len() - 2 * third))
}

fn mean<'a>(values: impl Iterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), v| (sum + v, count + 1.0));
    sum / count
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_middle_thirds_of_few_and_many() {
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), 2.5);
        assert!(median(Vec::new()).is_nan());
        assert_eq!(middle_third_mean(vec![5.0]), 5.0);
        assert_eq!(middle_third_mean(vec![5.0, 7.0]), 6.0);
        assert_eq!(middle_third_mean(vec![100.0, 5.0, -100.0]), 5.0);
        assert_eq!(middle_third_mean(vec![0.0, 90.0, 4.0, 6.0, -80.0, 5.0]), 4.5);
    }

    #[test]
    fn outliers_on_a_slope_leave_no_step_behind() {
        let columns: Vec<f64> = (0..20).map(f64::from).collect();
        let mut values: Vec<f64> = columns.iter().map(|c| 3.0 + 0.5 * c).collect();
        for (bad, by) in [(0, 9.0), (7, -5.0), (8, 4.0), (19, 3.0)] {
            values[bad] += by;
        }
        let series = Series { columns: &columns, values: &values };
        let filtered = series.filtered_at(&columns, 7);
        for (c, y) in columns.iter().zip(filtered) {
            assert!((y - 3.0 - 0.5 * c).abs() < 1e-12, "column {c}: {y}");
        }
    }

    #[test]
    fn bends_survive_and_holes_are_filled() {
        let bent = |c: f64| 0.01 * (c - 9.0) * (c - 9.0);
        let columns: Vec<f64> = (0..20).filter(|c| *c != 9).map(f64::from).collect();
        let values: Vec<f64> = columns.iter().map(|c| bent(*c)).collect();
        let series = Series { columns: &columns, values: &values };
        let all: Vec<f64> = (0..20).map(f64::from).collect();
        let worst_inside = all.iter().zip(series.filtered_at(&all, 7)).skip(6).take(8);
        for (c, y) in worst_inside {
            assert!((y - bent(*c)).abs() < 0.011, "column {c}: {y} for {}", bent(*c));
        }
    }
}
