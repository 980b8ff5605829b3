//! Steps from pixel to pixel, across the seam of a full circle if there is one.

use transect_device::{DeviceFrame, ImageSize, Neighbour, Pixel};

/// The pixels of a view as a grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Grid {
    size: ImageSize,
    wraps: bool,
}

impl Grid {
    pub fn new(frame: &dyn DeviceFrame) -> Self {
        Self { size: frame.size(), wraps: frame.columns_wrap() }
    }

    #[cfg(test)]
    pub fn plain(rows: usize, cols: usize) -> Self {
        Self { size: ImageSize { rows, cols }, wraps: false }
    }

    pub fn size(&self) -> ImageSize {
        self.size
    }

    pub fn wraps(&self) -> bool {
        self.wraps
    }

    /// Row-major number of a pixel inside the image.
    pub fn index(&self, p: Pixel) -> usize {
        p.row * self.size.cols + p.col
    }

    /// All pixels, row 0 first.
    pub fn pixels(self) -> impl Iterator<Item = Pixel> {
        let ImageSize { rows, cols } = self.size;
        (0..rows).flat_map(move |row| (0..cols).map(move |col| Pixel::new(row, col)))
    }

    /// The pixel some rows down and some columns to the right; `None` outside the image.
    pub fn step(&self, from: Pixel, rows: i32, cols: i32) -> Option<Pixel> {
        let row = from.row.checked_add_signed(rows as isize)?;
        let col = from.col.checked_add_signed(cols as isize).filter(|c| *c < self.size.cols);
        let col = match col {
            Some(col) => col,
            None if self.wraps => {
                (from.col as i64 + i64::from(cols)).rem_euclid(self.size.cols as i64) as usize
            }
            None => return None,
        };
        (row < self.size.rows).then_some(Pixel::new(row, col))
    }

    /// The neighbour that a pixel's code compares it with.
    pub fn before(&self, p: Pixel, neighbour: Neighbour) -> Option<Pixel> {
        match neighbour {
            Neighbour::Up => self.step(p, -1, 0),
            Neighbour::Left => self.step(p, 0, -1),
        }
    }

    /// Rows and columns from one pixel to another, the short way round a full circle.
    pub fn offset(&self, from: Pixel, to: Pixel) -> (f64, f64) {
        let (rows, mut cols) = (to.row as f64 - from.row as f64, to.col as f64 - from.col as f64);
        let circle = self.size.cols as f64;
        if self.wraps && cols.abs() > 0.5 * circle {
            cols -= circle.copysign(cols);
        }
        (rows, cols)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_borders_and_pass_the_seam() {
        let plain = Grid::plain(4, 6);
        assert_eq!(plain.step(Pixel::new(0, 0), 3, 5), Some(Pixel::new(3, 5)));
        assert_eq!(plain.step(Pixel::new(0, 0), -1, 0), None);
        assert_eq!(plain.step(Pixel::new(0, 0), 0, -1), None);
        assert_eq!(plain.step(Pixel::new(3, 5), 1, 0), None);
        assert_eq!(plain.step(Pixel::new(3, 5), 0, 1), None);
        let circle = Grid { wraps: true, ..plain };
        assert_eq!(circle.step(Pixel::new(1, 0), 0, -2), Some(Pixel::new(1, 4)));
        assert_eq!(circle.step(Pixel::new(1, 5), 1, 1), Some(Pixel::new(2, 0)));
        assert_eq!(circle.offset(Pixel::new(1, 5), Pixel::new(1, 0)), (0.0, 1.0));
        assert_eq!(circle.offset(Pixel::new(1, 0), Pixel::new(2, 4)), (1.0, -2.0));
    }
}
