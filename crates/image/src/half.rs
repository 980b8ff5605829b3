//! A view at half its resolution, with the missing pixels that its other half tells.
//!
//! **Problem.** A camera that misses single pixels misses as many of those that a half keeps.
//! Curves break there, although samples all around tell where the surface is.
//!
//! **Idea.** A kept pixel that is missing takes the mean of its neighbours on opposite sides, which
//! the half would not use. Where neighbours share most of their noise, so does the mean.
//!
//! **Steps**, for each missing pixel of the half that has a ray. Of the four lines through it,
//! those count on which
//! 1. both neighbours have a sample,
//! 2. their ranges differ by no more than one surface allows, and
//! 3. at least one neighbour on either side of the line has a sample. So the rims of holes stay,
//!    where depth cameras err most.
//!
//! A line gives the mean of its neighbours, in the quantity in which planes are flat. The pixel
//! takes the mean of its lines.
//!
//! **Worth.** Of two simulated rooms, seen by depth cameras that miss 40 % of their pixels at
//! random, 77 and 83 % are found within 0.2 % of the size, and with this step 91 and 97 %. The
//! medians fall from 1.33 and 1.22 mm to 0.76 and 0.71 mm. A simulated kitchen gains 1.5 % in its
//! median, and the halves of the red kitchen lose 1.2 %, both of which may be chance. Without
//! rule 3 these lose 4.5 %.

use crate::BreakRule;
use crate::smooth::Quantity;
use transect_device::{Pixel, RangeImage, View};

/// Rows and columns from a pixel to the eight around it, in order.
const AROUND: [(isize, isize); 8] =
    [(0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1), (-1, 0), (-1, 1)];

/// The half of a view with its missing pixels filled where `rule` allows it.
///
/// `half` is the view [halved](View::halved).
pub(crate) fn filled(half: View, view: &View, rule: &BreakRule) -> View {
    let quantity = Quantity::of(view);
    let size = half.image().size();
    let values = size.all_pixels().map(|pixel| {
        let in_view = Pixel::new(2 * pixel.row, 2 * pixel.col);
        let sample = half.image().get(pixel);
        sample.or_else(|| between(view, in_view, quantity, rule)).unwrap_or(f32::NAN)
    });
    let image = RangeImage::from_values(size, values.collect());
    image.ok().and_then(|image| half.with_image(image).ok()).unwrap_or(half)
}

/// The value of a missing pixel from its neighbours, if there are enough.
fn between(view: &View, pixel: Pixel, quantity: Quantity, rule: &BreakRule) -> Option<f32> {
    view.frame().ray(pixel)?;
    let around = AROUND.map(|(rows, cols)| {
        let row = pixel.row.checked_add_signed(rows)?;
        let pixel = Pixel::new(row, pixel.col.checked_add_signed(cols)?);
        let value = view.image().get(pixel)?;
        Some((pixel, quantity.of_value(f64::from(value))))
    });
    let inside = |k: usize| (1..4).any(|step| around[(k + step) % 8].is_some());
    let means = (0..4).filter_map(|k| {
        let ((a, value_a), (b, value_b)) = around[k].zip(around[k + 4])?;
        let pair = view.frame().pair(view.image(), a, b)?;
        let counts = inside(k) && inside(k + 4) && rule.allows_step(&pair);
        counts.then_some(0.5 * (value_a + value_b))
    });
    let (sum, count) = means.fold((0.0, 0_u8), |(sum, count), mean| (sum + mean, count + 1));
    (count > 0).then(|| quantity.value(sum / f64::from(count)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use transect_device::{DeviceFrame, ImageSize, Isometry3, SensorPlane, Vector3};
    use transect_sensors::{Intrinsics, Pinhole};

    const SIZE: ImageSize = ImageSize { rows: 32, cols: 40 };

    /// An oblique wall, a nearer one in the columns from `edge` on, and missing pixels.
    fn view(edge: usize, missing: &[Pixel]) -> View {
        let k = Intrinsics { fx: 120.0, fy: 120.0, cx: 19.5, cy: 15.5 };
        let camera = Pinhole::new(SIZE, k).unwrap();
        let normal = Vector3::new(0.6, 0.0, 0.8);
        let values = SIZE.all_pixels().map(|pixel| {
            let offset = if pixel.col < edge { 2.0 } else { 1.6 };
            let value = camera.plane_value(pixel, &SensorPlane { normal, offset }).unwrap();
            if missing.contains(&pixel) { f32::NAN } else { value as f32 }
        });
        let image = RangeImage::from_values(SIZE, values.collect()).unwrap();
        View::new("walls", image, Arc::new(camera), Isometry3::identity(), None).unwrap()
    }

    /// The value of pixel (4, 4) of a view, which is pixel (2, 2) of its half.
    fn filled_value(edge: usize, missing: &[(usize, usize)]) -> Option<f32> {
        let missing: Vec<Pixel> = missing.iter().map(|(r, c)| Pixel::new(*r, *c)).collect();
        let view = view(edge, &missing);
        let rule = BreakRule::new(78_f64.to_radians(), 0.001);
        filled(view.halved().unwrap(), &view, &rule).image().get(Pixel::new(2, 2))
    }

    fn wall() -> f32 {
        view(SIZE.cols, &[]).image().get(Pixel::new(4, 4)).unwrap()
    }

    #[test]
    fn a_missing_pixel_lies_on_the_plane_of_its_neighbours() {
        let holes: [&[(usize, usize)]; 2] = [&[(4, 4)], &[(4, 4), (3, 3), (3, 4), (5, 4), (5, 5)]];
        for missing in holes {
            let value = filled_value(SIZE.cols, missing).unwrap();
            assert!((value / wall() - 1.0).abs() < 1e-6, "{value}, not {}", wall());
        }
        assert_eq!(filled_value(SIZE.cols, &[(3, 3)]), Some(wall()), "samples stay");
    }

    #[test]
    fn nothing_is_filled_across_a_jump() {
        let column = [(3, 4), (4, 4), (5, 4)];
        assert_eq!(filled_value(4, &column), None);
        assert!(filled_value(SIZE.cols, &column).is_some());
    }

    #[test]
    fn the_rims_of_holes_stay() {
        let right: Vec<_> = (3..6).flat_map(|row| (5..10).map(move |col| (row, col))).collect();
        assert_eq!(filled_value(SIZE.cols, &[&right[..], &[(4, 4)]].concat()), None);
        assert!(filled_value(SIZE.cols, &[&right[1..], &[(4, 4)]].concat()).is_some());
    }
}
