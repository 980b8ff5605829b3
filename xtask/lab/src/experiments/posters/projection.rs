//! Parallel projections of the world onto a part of a poster.

use super::FAINT;
use transect_exchange::svg::Figure;
use transect_geometry::{Curve, Envelope, PlaneFrame, Point2, Point3, Vector2, Vector3};

/// Draws lines of a part in a frame, with a scale bar below it.
pub fn panel(
    figure: &mut Figure,
    (at, size): (Point2, [f64; 2]),
    (scale, unit): (f64, &str),
    draw: impl FnOnce(&mut Figure),
) {
    figure.clipped(at, size, draw);
    figure.rectangle(at, size, &stroke(FAINT));
    let bar = Point2::new(at.x, at.y + size[1] + 22.0);
    figure.scale_bar(bar, [scale, 120.0], unit);
}

/// The style of a line without an area.
pub fn stroke(colour: &str) -> String {
    format!("fill=\"none\" stroke=\"{colour}\"")
}

/// Lines of a poster, each with whether it is closed.
pub type Lines = Vec<(Vec<Point2>, bool)>;

/// A parallel projection from the world to pixels, y down.
#[derive(Debug, Clone)]
pub struct Projection {
    right: Vector3,
    up: Vector3,
    /// Pixels per length unit.
    pub scale: f64,
    offset: Vector2,
}

impl Projection {
    /// An observer at an azimuth and an elevation in degrees; z points up.
    pub fn from_side(azimuth: f64, elevation: f64) -> Self {
        let (sin, cos) = azimuth.to_radians().sin_cos();
        let (sin_up, cos_up) = elevation.to_radians().sin_cos();
        let up = Vector3::new(-cos * sin_up, -sin * sin_up, cos_up);
        Self::along(Vector3::new(-sin, cos, 0.0), up)
    }

    /// A look along the normal of a plane.
    pub fn onto(frame: &PlaneFrame) -> Self {
        Self::along(frame.x_axis(), frame.y_axis())
    }

    fn along(right: Vector3, up: Vector3) -> Self {
        Self { right, up, scale: 1.0, offset: Vector2::zeros() }
    }

    /// Stretches heights over the projected plane, which opens a stack of sections.
    pub fn exploded(mut self, factor: f64) -> Self {
        self.up.z *= factor;
        self
    }

    /// Fits points into a rectangle by its upper left corner and its size.
    pub fn fitting(
        mut self,
        points: impl Iterator<Item = Point3>,
        at: Point2,
        [width, height]: [f64; 2],
    ) -> Self {
        let places = points.map(|p| self.place(&p)).map(|p| Envelope { min: p, max: p });
        let Some(around) = places.reduce(|a, b| a.merged(&b)) else { return self };
        let size = around.size();
        self.scale = (width / size.x).min(height / size.y);
        let middle = nalgebra::center(&around.min, &around.max);
        self.offset =
            at.coords + Vector2::new(0.5 * width, 0.5 * height) - self.scale * middle.coords;
        self
    }

    /// The place of a point.
    pub fn place(&self, p: &Point3) -> Point2 {
        let flat = Vector2::new(self.right.dot(&p.coords), -self.up.dot(&p.coords));
        Point2::from(self.scale * flat + self.offset)
    }

    /// The curves of a plane.
    pub fn lines<'a>(
        &self,
        frame: &PlaneFrame,
        curves: impl IntoIterator<Item = &'a Curve>,
    ) -> Lines {
        let place = |p: &Point2| self.place(&frame.world_from_plane(p));
        let line = |curve: &Curve| {
            let nodes = curve.nodes().iter().map(|n| place(&n.position)).collect();
            (nodes, curve.is_closed())
        };
        curves.into_iter().map(line).collect()
    }
}
