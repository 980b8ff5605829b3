//! Laws of the tables that give whole images at once, and the names of the kinds of sensors.

use crate::laws::{
    SIZE, cameras, directions, frames_with_tables, frames_without_tables, grid_of, images, lenses,
    radars, stripes, valid,
};
use crate::tables::tables;
use proptest::prelude::*;
use transect_device::{DeviceFrame, LinearForm, Neighbour, RangeImage};

proptest! {
    #[test]
    fn tables_of_rows_and_columns_give_the_forms(
        frame in frames_with_tables(), image in images(), gradient in directions(),
        constant in -5.0..5.0,
    ) {
        let form = LinearForm { gradient, constant };
        let tables = frame.separable_form(&form);
        prop_assert!(tables.is_some(), "no tables of {frame:?}");
        let tables = tables.unwrap();
        for (pixel, d3) in valid(&image) {
            let [factor, addend] = tables.rows[pixel.row];
            let fast = d3 * (factor * tables.columns[pixel.col] + addend) + tables.constant;
            let p = frame.point(pixel, f64::from(d3)).unwrap();
            let bound = 2_f64.powi(-22) * (p.coords.norm() * gradient.norm() + constant.abs());
            prop_assert!((f64::from(fast) - form.at(&p)).abs() <= bound);
        }
    }

    #[test]
    fn products_of_neighbouring_rays_give_the_geometry_of_pairs(
        frame in frames_with_tables(), image in images(),
    ) {
        for neighbour in [Neighbour::Left, Neighbour::Up] {
            let products = frame.ray_products(neighbour);
            prop_assert!(products.is_some(), "no products of {frame:?}");
            let products = products.unwrap();
            for (pixel, a) in valid(&image) {
                let Some(other) = frame.neighbour(pixel, neighbour) else { continue };
                let (Some(b), Some(slow)) = (image.get(other), frame.pair(&image, pixel, other))
                else { continue };
                let row = products.rows[pixel.row];
                let column = products.columns.get(pixel.col).copied().unwrap_or_default();
                let here = row.here + column.here;
                let along = (b * (row.other + column.other) - a * here).abs() / here.sqrt();
                let lateral = b * (row.across + column.across) / here.sqrt();
                let size = frame.point(pixel, f64::from(a)).unwrap().coords.norm() as f32;
                let size = size.max(frame.point(other, f64::from(b)).unwrap().coords.norm() as f32);
                prop_assert!((along - slow.range_step).abs() <= 1e-6 * size);
                prop_assert!((lateral - slow.lateral).abs() <= 1e-6 * size);
            }
        }
    }

    #[test]
    fn kinds_of_sensors_have_the_names_that_stores_hold(
        radar in radars(), camera in cameras(), lens in lenses(), stripe in stripes(),
        table in tables(),
    ) {
        let flat = RangeImage::from_values(SIZE, vec![3.0; SIZE.pixels()]).unwrap();
        if let Some((grid, _)) = grid_of(&camera, &flat) {
            prop_assert_eq!(grid.kind(), "PointGrid");
        }
        prop_assert_eq!(radar.kind(), "ImagingRadar");
        prop_assert_eq!(camera.kind(), "Pinhole");
        prop_assert_eq!(lens.kind(), "RayTable");
        prop_assert_eq!(stripe.kind(), "LightStripe");
        prop_assert_eq!(table.kind(), "LookupTable");
    }

    #[test]
    fn frames_that_are_not_separable_state_no_tables(
        frame in frames_without_tables(), gradient in directions(),
    ) {
        let form = LinearForm { gradient, constant: 1.0 };
        prop_assert!(frame.separable_form(&form).is_none());
        prop_assert!(frame.ray_products(Neighbour::Left).is_none());
        prop_assert!(frame.ray_products(Neighbour::Up).is_none());
    }
}
