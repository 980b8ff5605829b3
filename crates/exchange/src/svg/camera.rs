//! The parallel projection that pictures of space share.

use super::canvas::{self, Margins};
use super::options::OverviewOptions;
use super::ruler::{round_down, tidy};
use std::io::{self, Write};
use transect_geometry::{
    Envelope, Guide, LengthUnit, PlaneFamily, PlaneFrame, PlaneIndex, Point2, Point3, Vector2,
    Vector3,
};

/// Free space between the picture's edges and the drawing, in pixels.
const MARGINS: Margins = Margins { left: 40.0, top: 92.0, right: 200.0, bottom: 60.0 };

/// A parallel projection from the world to the picture.
pub(super) struct Camera {
    /// World directions of the picture's right and up, and towards the viewer.
    right: Vector3,
    up: Vector3,
    pub(super) towards: Vector3,
    /// World point drawn at `middle`.
    centre: Point3,
    middle: Point2,
    /// Pixels per length unit across the direction of view.
    scale: f64,
}

impl Camera {
    fn looking(planes: &PlaneFamily, centre: Point3, options: &OverviewOptions) -> Self {
        // Along a curved guide the planes have no common normal: the world's up is upright there.
        let frame = match planes.guide() {
            Guide::Straight(_) => planes.frame(PlaneIndex(0)),
            Guide::Curved(_) => PlaneFrame::WORLD,
        };
        let (sin, cos) = options.azimuth_deg.to_radians().sin_cos();
        let (sin_up, cos_up) = options.elevation_deg.to_radians().sin_cos();
        let level = frame.x_axis() * cos + frame.y_axis() * sin;
        Self {
            right: frame.y_axis() * cos - frame.x_axis() * sin,
            up: frame.normal() * cos_up - level * sin_up,
            towards: level * cos_up + frame.normal() * sin_up,
            centre,
            middle: Point2::origin(),
            scale: 1.0,
        }
    }

    /// The camera for which points in the world fill the picture, the planes' guide upright.
    pub(super) fn fitting(
        planes: &PlaneFamily,
        points: impl Iterator<Item = Point3>,
        options: &OverviewOptions,
    ) -> Self {
        let mut points = points.peekable();
        let centre = points.peek().copied().unwrap_or(Point3::origin());
        let mut camera = Self::looking(planes, centre, options);
        let places = points.map(|p| camera.place(&p)).map(|p| Envelope { min: p, max: p });
        let Some(around) = places.reduce(|a, b| a.merged(&b)) else { return camera };
        let Margins { left, top, right, bottom } = MARGINS;
        let (width, height) = (options.width - left - right, options.height - top - bottom);
        let size = around.size();
        let scale = (width / size.x).min(height / size.y);
        camera.scale = if scale.is_finite() && scale > 0.0 { scale } else { 1.0 };
        let drawn_middle = (around.min.coords + around.max.coords) * (0.5 * camera.scale);
        let middle = Point2::new(left + 0.5 * width, top + 0.5 * height);
        camera.middle = middle - drawn_middle;
        camera
    }

    /// Place in the picture, in pixels, y down.
    pub(super) fn place(&self, in_world: &Point3) -> Point2 {
        // Relative to a point of the model, because differences stay exact far from the origin.
        let d = in_world - self.centre;
        self.middle + self.scale * Vector2::new(self.right.dot(&d), -self.up.dot(&d))
    }

    /// The nearness of a point to the viewer; it grows towards the viewer.
    pub(super) fn nearness(&self, in_world: &Point3) -> f64 {
        self.towards.dot(&(in_world - self.centre))
    }

    /// A width that fits between neighbouring planes.
    pub(super) fn line_width(&self, planes: &PlaneFamily) -> f64 {
        // Along a curved guide the shortest spacing is anywhere; half of the longest is a fair
        // guess.
        let shown = planes.guide().straight().map_or(0.5, |g| self.up.dot(&g.direction()));
        let spacing = planes.interval() * self.scale * shown;
        (0.3 * spacing).clamp(0.5, 1.8)
    }

    /// The world's axes in the lower left corner, with their true length.
    pub(super) fn write_axes(
        &self,
        unit: LengthUnit,
        options: &OverviewOptions,
        out: &mut dyn Write,
    ) -> io::Result<()> {
        let length = round_down(80.0 / self.scale);
        let origin = Point2::new(110.0, options.height - 110.0);
        let mut lowest = origin.y;
        let axes = [("X", Vector3::x()), ("Y", Vector3::y()), ("Z", Vector3::z())];
        for (name, axis) in axes {
            let d = axis * (length * self.scale);
            let tip = (origin.x + d.dot(&self.right), origin.y - d.dot(&self.up));
            let style = "stroke=\"#222\" stroke-width=\"1.4\"";
            canvas::line(out, (origin.x, origin.y), tip, style)?;
            let beyond = |from: f64, to: f64| from + 1.18 * (to - from);
            let at = (beyond(origin.x, tip.0), beyond(origin.y, tip.1) + 5.0);
            canvas::text(out, at, "text-anchor=\"middle\"", name)?;
            lowest = lowest.max(at.1);
        }
        let label = format!("each {} {}", tidy(length, length), unit);
        let at = (origin.x, lowest + 24.0);
        canvas::text(out, at, "text-anchor=\"middle\" font-size=\"14\" fill=\"#666\"", &label)
    }
}
