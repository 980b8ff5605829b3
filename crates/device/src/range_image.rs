//! One range-related value per pixel, with missing pixels explicit.

/// Row and column of a pixel, both from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pixel {
    /// Row `i`, the first scanning variable.
    pub row: usize,
    /// Column `j`, the second scanning variable.
    pub col: usize,
}

impl Pixel {
    /// The pixel in a row and a column.
    pub const fn new(row: usize, col: usize) -> Self {
        Self { row, col }
    }
}

impl std::fmt::Display for Pixel {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "row {}, column {}", self.row, self.col)
    }
}

/// Number of rows and columns of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSize {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub cols: usize,
}

impl ImageSize {
    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.rows.saturating_mul(self.cols)
    }

    /// The size of every other row and column, from row 0 and column 0 on.
    #[must_use]
    pub fn halved(self) -> Self {
        Self { rows: self.rows.div_ceil(2), cols: self.cols.div_ceil(2) }
    }

    /// All pixels, row by row.
    pub fn all_pixels(self) -> impl Iterator<Item = Pixel> {
        (0..self.rows).flat_map(move |row| (0..self.cols).map(move |col| Pixel::new(row, col)))
    }

    /// The pixel at a place in row-major order.
    #[inline]
    pub fn pixel(&self, place: usize) -> Pixel {
        let cols = self.cols.max(1);
        Pixel::new(place / cols, place % cols)
    }

    /// Place of a pixel in row-major order; `None` outside the image.
    #[inline]
    pub fn index(&self, pixel: Pixel) -> Option<usize> {
        let inside = pixel.row < self.rows && pixel.col < self.cols;
        inside.then(|| pixel.row * self.cols + pixel.col)
    }

    /// Refuses impossible sizes, before memory is taken for them.
    ///
    /// # Errors
    /// [`ImageError::AbsurdSize`] without rows or columns, or beyond [`MAX_PIXELS`].
    pub fn check(&self) -> Result<(), ImageError> {
        let Self { rows, cols } = *self;
        match rows.checked_mul(cols) {
            Some(n) if n > 0 && n <= MAX_PIXELS => Ok(()),
            _ => Err(ImageError::AbsurdSize { rows, cols }),
        }
    }
}

impl std::fmt::Display for ImageSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} rows × {} columns", self.rows, self.cols)
    }
}

/// Largest accepted image, in pixels. Chosen by hand: four times the largest terrestrial scans in
/// use. A header with a larger size counts as damaged. Doubled, a damaged header may take twice
/// the memory (8 GiB) before it is refused.
pub const MAX_PIXELS: usize = 1 << 30;

/// Why values cannot make a range image.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// No rows or no columns, or more than [`MAX_PIXELS`].
    #[error(
        "an image of {rows} rows × {cols} columns is empty or absurdly large: it must have 1 to \
         {MAX_PIXELS} pixels. Check the stated size"
    )]
    AbsurdSize {
        /// The number of rows.
        rows: usize,
        /// The number of columns.
        cols: usize,
    },
    /// The number of values is not rows × columns.
    #[error(
        "{found} values do not fill {size}, which need {}. Check the stated size",
        size.pixels()
    )]
    WrongCount {
        /// The stated size.
        size: ImageSize,
        /// The number of values.
        found: usize,
    },
    /// An image and its sensor have different sizes.
    #[error("the image has {found}, but the sensor {size}")]
    OtherSize {
        /// The sensor's size.
        size: ImageSize,
        /// The image's size.
        found: ImageSize,
    },
}

/// A grid of range-related values `d3`, one per ray of a sensor, some of them missing.
///
/// Row-major: row 0 first. Values are positive and finite, in the unit of the device frame's scale:
/// a range or depth in the model's length unit for most sensors. They are stored as `f32`.
/// A missing pixel is `None` through [`RangeImage::get`].
#[derive(Debug, Clone)]
pub struct RangeImage {
    size: ImageSize,
    /// NaN where missing; every other value is positive and finite.
    values: Vec<f32>,
    census: Census,
}

/// Properties of all values, counted once.
#[derive(Debug, Clone, Copy)]
struct Census {
    valid: usize,
    /// Smallest and largest value; infinity and −infinity if there is no value.
    extremes: (f32, f32),
}

impl Census {
    /// Makes unusable values NaN and counts the others. Sixteen lanes run side by side, because
    /// this pass is most of the cost of making an image.
    fn take(values: &mut [f32]) -> Self {
        const LANES: usize = 16;
        let mut low = [f32::INFINITY; LANES];
        let mut high = [f32::NEG_INFINITY; LANES];
        let mut valid = 0;
        for values in values.chunks_mut(LANES) {
            let mut found = 0;
            for ((value, low), high) in values.iter_mut().zip(&mut low).zip(&mut high) {
                // Comparisons with NaN are false.
                let useful = (*value > 0.0) & (*value < f32::INFINITY);
                *value = if useful { *value } else { f32::NAN };
                *low = if *value < *low { *value } else { *low };
                *high = if *value > *high { *value } else { *high };
                found += u32::from(useful);
            }
            valid += found as usize;
        }
        let low = low.into_iter().fold(f32::INFINITY, f32::min);
        let high = high.into_iter().fold(f32::NEG_INFINITY, f32::max);
        Self { valid, extremes: (low, high) }
    }
}

impl RangeImage {
    /// An image from row-major values; zero, negative, infinite and NaN values become missing.
    ///
    /// # Errors
    /// [`ImageError`] if the size is absurd or the number of values differs from it.
    pub fn from_values(size: ImageSize, mut values: Vec<f32>) -> Result<Self, ImageError> {
        size.check()?;
        if values.len() != size.pixels() {
            return Err(ImageError::WrongCount { size, found: values.len() });
        }
        let census = Census::take(&mut values);
        Ok(Self { size, values, census })
    }

    /// Every other row and column, from row 0 and column 0 on.
    #[must_use]
    pub fn halved(&self) -> Self {
        let size = self.size.halved();
        let rows = (0..size.rows).map(|row| self.row(2 * row));
        let mut values: Vec<f32> = rows.flat_map(|row| row.iter().step_by(2).copied()).collect();
        let census = Census::take(&mut values);
        Self { size, values, census }
    }

    /// Number of rows and columns.
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// The value at a pixel; `None` where it is missing or outside the image.
    #[inline]
    pub fn get(&self, pixel: Pixel) -> Option<f32> {
        self.values.get(self.size.index(pixel)?).copied().filter(|v| !v.is_nan())
    }

    /// All values for inner loops, row by row, **NaN where missing**.
    #[inline]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The values of one row for inner loops, **NaN where missing**; empty outside the image.
    #[inline]
    pub fn row(&self, row: usize) -> &[f32] {
        let start = row.saturating_mul(self.size.cols);
        let end = start.saturating_add(self.size.cols);
        self.values.get(start..end).unwrap_or(&[])
    }

    /// Number of pixels that are not missing.
    pub fn valid_count(&self) -> usize {
        self.census.valid
    }

    /// Smallest and largest value; `None` if every pixel is missing.
    pub fn extremes(&self) -> Option<(f32, f32)> {
        (self.census.valid > 0).then_some(self.census.extremes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: ImageSize = ImageSize { rows: 2, cols: 3 };

    #[test]
    fn useless_samples_become_missing() {
        let values = vec![1.0, 0.0, -2.0, f32::INFINITY, f32::NAN, 3.0];
        let image = RangeImage::from_values(SIZE, values).unwrap();
        assert_eq!(image.valid_count(), 2);
        assert_eq!(image.get(Pixel::new(0, 0)), Some(1.0));
        assert_eq!(image.get(Pixel::new(0, 1)), None);
        assert_eq!(image.get(Pixel::new(1, 2)), Some(3.0));
        assert_eq!(image.get(Pixel::new(0, 3)), None, "the next row is not column 3");
        assert_eq!(image.extremes(), Some((1.0, 3.0)));
        assert_eq!(image.get(Pixel::new(usize::MAX, 0)), None);
        assert!(image.row(usize::MAX).is_empty() && image.row(2).is_empty());
    }

    #[test]
    fn extremes_and_count_are_those_of_the_valid_values_alone() {
        let image = |values: &[f32]| {
            let size = ImageSize { rows: 1, cols: values.len() };
            RangeImage::from_values(size, values.to_vec()).unwrap()
        };
        assert_eq!(image(&[f32::NAN; 40]).extremes(), None);
        for len in [1, 15, 16, 17, 50] {
            for at in 0..len {
                let mut values = vec![2.0; len];
                values[at] = -3.0;
                let expected = if len == 1 { None } else { Some((2.0, 2.0)) };
                assert_eq!(image(&values).extremes(), expected);
                values[at] = 0.5;
                values[(at + 1) % len] = f32::INFINITY;
                values[(at + 2) % len] = 7.0;
                let valid = values.iter().filter(|v| v.is_finite()).copied();
                let found = image(&values);
                assert_eq!(found.valid_count(), valid.clone().count());
                let low = valid.clone().fold(f32::INFINITY, f32::min);
                let high = valid.fold(f32::NEG_INFINITY, f32::max);
                assert_eq!(found.extremes(), Some((low, high)), "{len} {at}");
            }
        }
    }

    #[test]
    fn sizes_are_checked_before_use() {
        let wrong = RangeImage::from_values(SIZE, vec![1.0; 5]).unwrap_err();
        assert_eq!(
            wrong.to_string(),
            "5 values do not fill 2 rows × 3 columns, which need 6. Check the stated size"
        );
        for (rows, cols) in [(0, 3), (1 << 20, 1 << 20), (usize::MAX, 2)] {
            let absurd = RangeImage::from_values(ImageSize { rows, cols }, Vec::new());
            let error = absurd.unwrap_err();
            assert_eq!(error, ImageError::AbsurdSize { rows, cols });
            let limit = ": it must have 1 to 1073741824 pixels. Check the stated size";
            assert!(error.to_string().ends_with(limit), "{error}");
        }
    }
}
