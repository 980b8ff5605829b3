//! Figures of a section plane: curves with their directions in a part of the plane.

use super::palette;
use transect_exchange::svg::{Anchor, Figure};
use transect_geometry::{Curve, Envelope, LengthUnit, Point2, Vector2};

/// Width and height of a drawing, in pixels of the figure. Chosen by hand: figure and legend fit on
/// a screen of 1280 × 720 px. Doubled, they do not.
pub const SIZE: [f64; 2] = [880.0, 600.0];

/// Free space inside the drawing's frame, in pixels. Chosen by hand: heads and dots of outer curves
/// stay inside. Doubled, drawings are about a tenth smaller.
const MARGIN: f64 = 34.0;

/// Distance between the heads of a curve's direction, in pixels. Chosen by hand: short curves have
/// one and long ones some. Doubled, most curves have none or one.
const HEADS: f64 = 110.0;

/// A part of a plane in the drawing, x to the right and y up. It may be stretched in one direction.
#[derive(Debug, Clone, Copy)]
pub struct PlaneMap {
    origin: Point2,
    /// The direction that the drawing has to its right.
    right: Vector2,
    /// Pixels per length along both directions of the drawing.
    scale: [f64; 2],
    unit: LengthUnit,
}

impl PlaneMap {
    /// The map on which an envelope fills the drawing.
    pub fn fit(envelope: &Envelope, unit: LengthUnit) -> Self {
        let (size, middle) = (envelope.size(), envelope.min + 0.5 * envelope.size());
        let room = [SIZE[0] - 2.0 * MARGIN, SIZE[1] - 2.0 * MARGIN];
        let scale = (room[0] / size.x).min(room[1] / size.y);
        let scale = if scale.is_finite() { scale } else { 1.0 };
        Self { origin: middle, right: Vector2::x(), scale: [scale; 2], unit }
    }

    /// The map of a place in which a direction runs to the right, with pixels per length along and
    /// across it.
    pub fn along(origin: Point2, right: Vector2, scale: [f64; 2], unit: LengthUnit) -> Self {
        Self { origin, right, scale, unit }
    }

    /// How many times longer lengths across are drawn than lengths along.
    pub fn stretch(&self) -> f64 {
        self.scale[1] / self.scale[0]
    }

    pub fn place(&self, p: &Point2) -> Point2 {
        let d = p - self.origin;
        let (x, y) = (self.right.dot(&d), self.right.perp(&d));
        Point2::new(0.5 * SIZE[0] + x * self.scale[0], 0.5 * SIZE[1] - y * self.scale[1])
    }

    /// The point of the plane at a place of the drawing.
    pub fn inverse(&self, place: &Point2) -> Point2 {
        let x = (place.x - 0.5 * SIZE[0]) / self.scale[0];
        let y = (0.5 * SIZE[1] - place.y) / self.scale[1];
        self.origin + self.right * x + Vector2::new(-self.right.y, self.right.x) * y
    }

    /// Draws inside the frame only.
    pub fn inside(&self, figure: &mut Figure, draw: impl FnOnce(&mut Figure)) {
        figure.clipped(Point2::origin(), SIZE, draw);
    }

    pub fn line<'a>(
        &self,
        figure: &mut Figure,
        points: impl IntoIterator<Item = &'a Point2>,
        closed: bool,
        style: &str,
    ) {
        let places: Vec<Point2> = points.into_iter().map(|p| self.place(p)).collect();
        if !is_outside(&places) {
            let style = format!("fill=\"none\" stroke-linejoin=\"round\" {style}");
            figure.line(&places, closed, &style);
        }
    }

    /// A curve, with heads in its direction.
    pub fn curve(&self, figure: &mut Figure, curve: &Curve, colour: &str, width: f64) {
        let style = format!("stroke=\"{colour}\" stroke-width=\"{width}\"");
        let nodes: Vec<Point2> = curve.nodes().iter().map(|n| n.position).collect();
        self.line(figure, &nodes, curve.is_closed(), &style);
        self.heads(figure, &nodes, colour, width);
    }

    /// Heads along a line, in its direction.
    pub fn heads(&self, figure: &mut Figure, nodes: &[Point2], colour: &str, width: f64) {
        let places: Vec<Point2> = nodes.iter().map(|p| self.place(p)).collect();
        let mut ahead = 0.5 * HEADS;
        for pair in places.windows(2) {
            let way = (pair[1] - pair[0]).norm();
            ahead -= way;
            if ahead <= 0.0 && way > 0.0 {
                let along = (pair[1] - pair[0]) / way;
                let across = Vector2::new(-along.y, along.x);
                let half = 1.5 + 1.5 * width.min(2.5);
                let tip = pair[0] + (pair[1] - pair[0]) * 0.5 + along * half;
                let back = tip - along * (2.2 * half);
                let head = [tip, back + across * half, back - across * half];
                figure.line(&head, true, &format!("fill=\"{colour}\""));
                ahead = HEADS;
            }
        }
    }

    pub fn dot(&self, figure: &mut Figure, p: &Point2, radius: f64, colour: &str) {
        let place = self.place(p);
        if !is_outside(&[place]) {
            figure.circle(place, radius, &format!("fill=\"{colour}\""));
        }
    }

    /// A rectangle of the plane; only on maps that are not turned.
    pub fn rectangle(&self, figure: &mut Figure, envelope: &Envelope, style: &str) {
        let a = self.place(&Point2::new(envelope.min.x, envelope.max.y));
        let b = self.place(&Point2::new(envelope.max.x, envelope.min.y));
        figure.rectangle(a, [b.x - a.x, b.y - a.y], style);
    }

    /// The frame of the drawing, with a bar for lengths along it.
    pub fn frame(&self, figure: &mut Figure) {
        figure.rectangle(Point2::origin(), SIZE, "fill=\"none\" stroke=\"#222\"");
        let unit = self.unit.to_string();
        let at = Point2::new(0.0, SIZE[1] + 20.0);
        figure.scale_bar(at, [self.scale[0], 130.0], &unit);
        if self.stretch() >= 1.5 {
            let text = format!("lengths upwards are drawn {:.0} times larger", self.stretch());
            let at = Point2::new(SIZE[0], SIZE[1] + 22.0);
            figure.text(at, Anchor::End, 14.0, palette::FOUND, &text);
        }
    }
}

/// Whether places are all beyond one side of the drawing, so that nothing of them can be seen.
pub fn is_outside(places: &[Point2]) -> bool {
    let [width, height] = SIZE;
    places.iter().all(|p| p.x < -MARGIN)
        || places.iter().all(|p| p.x > width + MARGIN)
        || places.iter().all(|p| p.y < -MARGIN)
        || places.iter().all(|p| p.y > height + MARGIN)
}

/// The envelope of curves; `None` without any.
pub fn envelope_of<'a>(curves: impl IntoIterator<Item = &'a Curve>) -> Option<Envelope> {
    curves.into_iter().map(Curve::envelope).reduce(|a, b| a.merged(&b))
}
