//! Range images of a scene: one ray per pixel of any device frame (dissertation, section 4.5.3).
//!
//! 1. The pixel's ray, moved into the world, meets the scene at some distance.
//! 2. A triangulation sensor must see the spot as well: the way from its second viewpoint to the
//!    hit must be free. A place that either path cannot reach is in shadow (Figure 1.6).
//!    So must a depth camera's projector.
//! 3. Noise moves the hit along the ray, or drops it.
//! 4. The value `d3` is the one that a plane through the hit, perpendicular to the ray, would have
//!    at the pixel ([`DeviceFrame::plane_value`]). On the pixel's own ray that is exact for every
//!    scale a frame may have. It needs no inverse `F` and no arc tangent, and makes noise mean an
//!    error along the ray for depths just as for ranges. A depth camera states the hit's own depth
//!    with its errors.
//!
//! The code is serial on purpose: the caller may cast views in parallel. A row depends on itself
//! and, for mixed pixels, on its two neighbours.

use crate::noise::{Field, Optics, PixelNoise, RowNoise};
use crate::parry::{self, Motion};
use crate::scene::WorldRay;
use crate::{Noise, Scene};
use parry3d_f64::math::Vector;
use std::sync::Arc;
use transect_device::{
    DeviceFrame, ImageError, ImageSize, Isometry3, PairGeometry, Pixel, Point3, RangeImage, Ray,
    SensorPlane, View, ViewError,
};

/// Why a scene cannot give a view.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CastError {
    /// The device frame has an impossible size.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// No ray hit a solid, or the pose is not finite.
    #[error(transparent)]
    View(#[from] ViewError),
}

impl Scene {
    /// The range image of a perfect sensor.
    ///
    /// A pixel is missing if its ray meets no solid, or starts inside one.
    ///
    /// # Errors
    /// [`ImageError`] if the frame's size is absurd.
    pub fn cast(
        &self,
        frame: &dyn DeviceFrame,
        world_from_sensor: &Isometry3,
    ) -> Result<RangeImage, ImageError> {
        self.scan(frame, world_from_sensor, &Noise::NONE, 0)
    }

    /// The range image of a noisy sensor. `view` is the view's number: together with the noise's
    /// seed it decides every random number, so that views may be cast in any order.
    ///
    /// # Errors
    /// [`ImageError`] if the frame's size is absurd.
    pub fn scan(
        &self,
        frame: &dyn DeviceFrame,
        world_from_sensor: &Isometry3,
        noise: &Noise,
        view: u64,
    ) -> Result<RangeImage, ImageError> {
        let size = frame.size();
        // Before memory is taken for it.
        size.check()?;
        let caster = Caster::new(self, frame, world_from_sensor, (noise, view));
        let mut field = Field::new(noise, view, size.cols);
        let mut values = Vec::with_capacity(size.pixels());
        let mut window = Window::new(&caster);
        for row in 0..size.rows {
            let mut row_noise = noise.row(view, row, field.as_mut().map(Field::next_row));
            let valued = |d3: Option<f64>| d3.map_or(f32::NAN, |d3| d3 as f32);
            values.extend((0..size.cols).map(|col| valued(window.value(col, &mut row_noise))));
            window.advance();
        }
        RangeImage::from_values(size, values)
    }

    /// A whole view of the scene, ready for modelling, with the noise's sigma on record: that at
    /// the mean range if it grows. Without it if the errors of pixels depend on each other, or are
    /// those of a depth camera.
    ///
    /// The ranges are measured from the given pose. The view states that pose with the pose noise
    /// ([`Noise::stated_pose`]).
    ///
    /// # Errors
    /// [`CastError`] if the frame's size is absurd, no ray hit a solid, or the pose is not finite.
    pub fn view(
        &self,
        name: impl Into<String>,
        frame: Arc<dyn DeviceFrame>,
        world_from_sensor: Isometry3,
        noise: &Noise,
        view: u64,
    ) -> Result<View, CastError> {
        let image = self.scan(frame.as_ref(), &world_from_sensor, noise, view)?;
        let growing = noise.sigma_growth != 0.0 || noise.sigma_square != 0.0;
        let range = if growing { mean_range(frame.as_ref(), &image) } else { 0.0 };
        let stated = noise.stated_pose(&world_from_sensor, view);
        let sigma = noise.is_white().then(|| noise.sigma_at(range));
        Ok(View::new(name, image, frame, stated, sigma)?)
    }
}

fn mean_range(frame: &dyn DeviceFrame, image: &RangeImage) -> f64 {
    let size = image.size();
    let pixels = size.all_pixels();
    let range = |pixel| {
        let point = frame.point(pixel, f64::from(image.get(pixel)?))?;
        Some((point - frame.ray(pixel)?.start).norm())
    };
    pixels.filter_map(range).sum::<f64>() / image.valid_count().max(1) as f64
}

/// The echo on a pixel's ray.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Echo {
    /// The pixel's ray, in the sensor's frame.
    pub ray: Ray,
    /// Distance of the surface along it.
    pub distance: f64,
    /// Reflectivity times cosine of incidence; 1 if the light is not computed.
    pub light: f64,
}

impl Echo {
    /// The point of the surface, in the sensor's frame.
    fn point(&self) -> Point3 {
        self.ray.start + self.ray.direction * self.distance
    }

    /// The extra distance of the neighbour's surface along this ray, if there is a range jump
    /// between.
    fn jump_to(&self, other: &Self) -> Option<f64> {
        let (here, there) = (self.point(), other.point());
        let pair = PairGeometry::between(&here, &there, &self.ray.direction);
        let along = (there - here).dot(&self.ray.direction);
        (pair.range_step > pair.lateral * JUMP_SLOPE).then_some(along)
    }
}

/// Tangent of the incidence beyond which two neighbours no longer belong to one surface: tan 85°.
const JUMP_SLOPE: f32 = 11.430_052;

/// Tolerance of a free path at its end, relative to its length. Chosen by hand: far above rounding,
/// far below any thickness. Doubling it changes nothing visible.
const END_TOLERANCE: f64 = 1e-7;

/// Data that all pixels of a view share.
pub(crate) struct Caster<'a> {
    scene: &'a Scene,
    frame: &'a dyn DeviceFrame,
    noise: &'a Noise,
    /// The number of the view.
    view: u64,
    /// The errors of a depth camera.
    optics: Option<Optics>,
    world_from_sensor: Motion,
    least_cosine: Option<f64>,
    /// Whether echoes have their light.
    light: bool,
}

impl<'a> Caster<'a> {
    pub fn new(
        scene: &'a Scene,
        frame: &'a dyn DeviceFrame,
        world_from_sensor: &Isometry3,
        (noise, view): (&'a Noise, u64),
    ) -> Self {
        let world_from_sensor = Motion::new(world_from_sensor);
        let (least_cosine, light) = (noise.least_cosine(), noise.needs_light());
        let optics = Optics::of(noise, frame);
        Self { scene, frame, noise, view, optics, world_from_sensor, least_cosine, light }
    }

    /// The same, with the light of every echo.
    pub fn with_light(self) -> Self {
        Self { light: true, ..self }
    }

    /// The echoes of a row; empty outside the image.
    pub fn row(&self, row: usize) -> Vec<Option<Echo>> {
        let ImageSize { rows, cols } = self.frame.size();
        let cols = if row < rows { cols } else { 0 };
        let optics = self.optics.as_ref();
        let mut turned = optics.map(|optics| (optics, self.noise.shuffling(self.view, row)));
        let echo = |col| {
            let pixel = Pixel::new(row, col);
            let ray = self.frame.ray(pixel)?;
            let turned = turned.as_mut().map(|(optics, numbers)| optics.shuffled(&ray, numbers));
            self.echo(pixel, turned.unwrap_or(ray))
        };
        (0..cols).map(echo).collect()
    }

    /// The first surface that a pixel's ray meets, if the sensor can see it.
    fn echo(&self, pixel: Pixel, in_sensor: Ray) -> Option<Echo> {
        let start = self.world_from_sensor.point(parry::point(&in_sensor.start));
        let direction = self.world_from_sensor.rotation * parry::vector(&in_sensor.direction);
        let ray = WorldRay::new(start, direction);
        let (solid, distance) = self.scene.nearest(&ray)?;
        if distance <= 0.0 {
            return None;
        }
        let light = self.light(&ray, direction, solid, distance)?;
        let seen = self.watches(pixel, start + direction * distance);
        seen.then_some(Echo { ray: in_sensor, distance, light })
    }

    /// The light that a surface returns, where it matters; `None` if it is met too obliquely.
    fn light(&self, ray: &WorldRay, along: Vector, solid: usize, distance: f64) -> Option<f64> {
        if !self.light && self.least_cosine.is_none() {
            return Some(1.0);
        }
        let cosine = -self.scene.normal(ray, solid, distance)?.dot(along);
        let returns = self.least_cosine.is_none_or(|least| cosine >= least);
        let reflectivity = self.scene.solids().get(solid)?.reflectivity();
        returns.then_some(cosine.max(0.0) * reflectivity)
    }

    /// Whether a spot on a pixel's ray can be seen from the sensor's second viewpoint, if any.
    fn watches(&self, pixel: Pixel, spot: Vector) -> bool {
        let projector = self.optics.as_ref().and_then(Optics::projector);
        let Some(viewpoint) = self.frame.second_viewpoint(pixel).or(projector) else { return true };
        let viewpoint = self.world_from_sensor.point(parry::point(&viewpoint));
        let way = spot - viewpoint;
        // From the viewpoint to the spot, so that the spot's own surface is met last.
        let Some(direction) = way.try_normalize() else { return true };
        !self
            .scene
            .blocks(&WorldRay::new(viewpoint, direction), way.length() * (1.0 - END_TOLERANCE))
    }

    /// The value of a pixel whose surface is at a distance along its ray.
    pub fn value(&self, pixel: Pixel, ray: &Ray, distance: f64) -> Option<f64> {
        if distance <= 0.0 {
            return None;
        }
        if let Some(optics) = &self.optics {
            return optics.stated(pixel, (ray.start + ray.direction * distance).z);
        }
        let normal = ray.direction;
        let offset = normal.dot(&ray.start.coords) + distance;
        self.frame.plane_value(pixel, &SensorPlane { normal, offset })
    }
}

/// The echoes of a row between those of its two neighbours, each cast once.
struct Window<'a> {
    caster: &'a Caster<'a>,
    row: usize,
    above: Vec<Option<Echo>>,
    here: Vec<Option<Echo>>,
    below: Vec<Option<Echo>>,
}

impl<'a> Window<'a> {
    fn new(caster: &'a Caster<'a>) -> Self {
        let (here, below) = (caster.row(0), caster.row(1));
        Self { caster, row: 0, above: Vec::new(), here, below }
    }

    fn advance(&mut self) {
        self.row += 1;
        let next = self.caster.row(self.row + 1);
        self.above = std::mem::replace(&mut self.here, std::mem::replace(&mut self.below, next));
    }

    /// A pixel's `d3`; `None` without an echo.
    fn value(&self, col: usize, noise: &mut RowNoise) -> Option<f64> {
        // Drawn even if the ray misses, so that a pixel's noise does not depend on its neighbours'
        // hits.
        let drawn = noise.next_pixel();
        let echo = (*self.here.get(col)?)?;
        let settings = self.caster.noise;
        if !drawn.returns(settings, echo.light) {
            return None;
        }
        let range = drawn.range(settings, echo.distance + self.mixture(col, &echo, &drawn));
        let d3 = self.caster.value(Pixel::new(self.row, col), &echo.ray, range)?;
        Some(settings.quantised(d3))
    }

    /// The distance by which a pixel at a jump moves towards its other surface: the largest of its
    /// four neighbours'.
    fn mixture(&self, col: usize, echo: &Echo, drawn: &PixelNoise) -> f64 {
        let Some(share) = drawn.mixture(self.caster.noise) else { return 0.0 };
        let around = [
            self.above.get(col),
            self.below.get(col),
            self.beside(col, col.checked_sub(1)),
            self.beside(col, Some(col + 1)),
        ];
        let steps = around.into_iter().flatten().flatten().filter_map(|other| echo.jump_to(other));
        share * steps.max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0)
    }

    /// The echo in the same row; across the seam if the columns go round in a full circle.
    fn beside(&self, col: usize, other: Option<usize>) -> Option<&Option<Echo>> {
        let last = self.here.len().checked_sub(1)?;
        let other = match other {
            Some(other) if other <= last => other,
            _ if !self.caster.frame.columns_wrap() => return None,
            _ => last - col,
        };
        self.here.get(other)
    }
}

#[cfg(test)]
mod tests;
