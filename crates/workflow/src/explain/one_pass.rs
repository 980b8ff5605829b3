//! The steps of the sweep on one plane.

use super::image::{WINDOW, Window, range_image};
use super::page::Builder;
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use transect::Setup;
use transect_device::{Pixel, View};
use transect_exchange::svg::{Figure, Mark};
use transect_geometry::{Envelope, PlaneIndex, Point2};
use transect_image::smooth::Smoothing;
use transect_image::{Instructions, PreparedView, RangeNoise};
use transect_partial::one_pass::{
    Contours, Effort, OnePassOptions, Polyline, Seen, Workspace, contours, partial_model, seen,
};
use transect_partial::{PartialError, SectionAxes};

/// Rows and columns of the window that shows links. Chosen by hand: cells have room for the links
/// in them. Doubled, cells are half as wide.
const CLOSE_UP: [usize; 2] = [10, 16];

/// The data of the sweep of a view, for one plane.
struct Swept<'a> {
    view: &'a View,
    level: f64,
    seen: Seen,
    contours: Contours<'a>,
    plane: PlaneIndex,
}

/// The plane that is drawn, in the image of a view.
#[derive(Clone, Copy)]
pub(super) struct Drawn<'a> {
    pub view: &'a View,
    pub setup: &'a Setup,
    pub plane: PlaneIndex,
    pub options: &'a OnePassOptions,
}

/// Draws all steps of one plane.
pub(super) fn draw(drawn: &Drawn<'_>, pages: &mut Builder) -> Result<(), PartialError> {
    let Drawn { view, setup, plane, options } = *drawn;
    let noisy = options.resolved(view);
    let rule = |noise: &RangeNoise| options.break_rule(noisy.view(), noise);
    let smoothing = Smoothing { pixels: None, ..Smoothing::default() };
    let prepared = PreparedView::new(&noisy, options.smooth.then_some(&smoothing), rule);
    let (view, rule) = (prepared.view(), rule(prepared.noise()));
    let axes = SectionAxes::new(view, &setup.planes)?;
    let mut work = Workspace::default();
    let swept = Swept {
        view,
        level: plane.0 as f64 - axes.base().0 as f64,
        seen: seen(view, &axes, &rule, Instructions::Best),
        contours: contours(view, &axes, &rule, &Effort::default(), &mut work)?,
        plane,
    };
    let size = view.image().size();
    let whole = Window::whole(size);
    let window = Window::best(size, WINDOW, |p| swept.interest(p));
    heights(&swept, &whole, &window, pages);
    pairs(&swept, &window, pages);
    let near = |p| if window.contains(p) { swept.interest(p) } else { [0.0; 2] };
    links(&swept, &Window::best(size, CLOSE_UP, near), pages);
    curves(drawn, pages)
}

impl Swept<'_> {
    /// Height of a pixel over the plane, in intervals; `None` where it is missing.
    fn height(&self, p: Pixel) -> Option<f64> {
        let at = self.view.image().size().index(p)?;
        let level = self.seen.levels.get(at).filter(|level| !level.is_nan())?;
        Some(f64::from(*level) - self.level)
    }

    /// The pairs of a pixel with the ones above and to its left: the other pixel, whether the plane
    /// passes between the two, and whether they are of one surface.
    fn pairs(&self, p: Pixel) -> [Option<(Pixel, bool, bool)>; 2] {
        let joined = |pairs: &[bool]| {
            let at = self.view.image().size().index(p);
            at.and_then(|at| pairs.get(at)).copied().unwrap_or(false)
        };
        let pair = |other: Option<Pixel>, joined| {
            let other = other?;
            let crossed = (self.height(p)? > 0.0) != (self.height(other)? > 0.0);
            Some((other, crossed, joined))
        };
        let up = p.row.checked_sub(1).map(|row| Pixel::new(row, p.col));
        let left = p.col.checked_sub(1).map(|col| Pixel::new(p.row, col));
        [pair(up, joined(&self.seen.up)), pair(left, joined(&self.seen.left))]
    }

    /// How much a pixel shows of crossed pairs in both directions.
    fn interest(&self, p: Pixel) -> [f64; 2] {
        self.pairs(p).map(|pair| match pair {
            Some((_, true, true)) => 1.0,
            Some((_, true, false)) => 0.2,
            _ => 0.0,
        })
    }

    fn lines(&self) -> impl Iterator<Item = Polyline<'_>> {
        self.contours.polylines().filter(|line| line.plane == self.plane)
    }

    fn side(&self, p: Pixel) -> [u8; 3] {
        palette::rgb(match self.height(p) {
            Some(height) if height > 0.0 => palette::HIGH,
            Some(_) => palette::LOW,
            None => palette::MISSING,
        })
    }
}

fn side_legend(figure: &mut Figure) {
    figure.legend(Mark::Area(palette::HIGH), "over the plane");
    figure.legend(Mark::Area(palette::LOW), "on the plane or below");
    figure.legend(Mark::Area(palette::MISSING), "missing pixel");
}

fn heights(swept: &Swept<'_>, whole: &Window, window: &Window, pages: &mut Builder) {
    let text = ("Range image", "What the sensor measured: one value per pixel that is read.");
    pages.step("range-image", text, whole.size(), |figure| {
        range_image(figure, swept.view);
        whole.outline(figure, window);
        figure.legend(Mark::Line(palette::FOUND), "part that the following figures show");
    });
    let text = (
        "Heights",
        "The height of every sample, in intervals: one scalar image for all planes. The curves of \
         plane k are its level lines at k. Bands change at every plane.",
    );
    pages.step("heights", text, whole.size(), |figure| {
        whole.fill(figure, |p| match swept.height(p) {
            Some(height) => {
                let dark = if height.floor() as i64 % 2 == 0 { 0.0 } else { 0.16 };
                swept.side(p).map(|c| (f64::from(c) * (1.0 - dark)) as u8)
            }
            None => palette::rgb(palette::MISSING),
        });
        whole.outline(figure, window);
        whole.frame(figure);
        side_legend(figure);
        figure.legend(Mark::Remark, "Neighbouring bands differ in their shade.");
        figure.legend(Mark::Line(palette::FOUND), "part that the following figures show");
    });
}

fn pairs(swept: &Swept<'_>, window: &Window, pages: &mut Builder) {
    let text = (
        "Crossed pairs",
        "A pair of neighbours of one surface with heights of different signs gets a vertex, by \
         linear interpolation. A range jump breaks a pair.",
    );
    pages.step("pairs", text, window.size(), |figure| {
        window.fill(figure, |p| swept.side(p));
        window.grid(figure);
        for p in window.pixels() {
            for (other, crossed, joined) in swept.pairs(p).into_iter().flatten() {
                if !joined {
                    let style = format!(
                        "stroke=\"{}\" stroke-width=\"2\" stroke-dasharray=\"4 3\"",
                        palette::REFUSED
                    );
                    figure.line(&window.border(p, other.row != p.row), false, &style);
                } else if crossed && window.contains(other) {
                    let (here, there) = (swept.height(p), swept.height(other));
                    let share = here.zip(there).map_or(0.5, |(h, o)| o / (o - h));
                    if let Some(at) = window.between([other, p], share) {
                        figure.circle(at, 4.0, &format!("fill=\"{}\"", palette::FOUND));
                    }
                }
            }
        }
        window.frame(figure);
        figure.legend(Mark::Dot(palette::FOUND), "vertex on a crossed pair");
        figure.legend(Mark::Dashed(palette::REFUSED), "broken pair: a range jump");
        side_legend(figure);
    });
}

fn links(swept: &Swept<'_>, window: &Window, pages: &mut Builder) {
    let text = (
        "Links through cells",
        "Each cell of four pixels links the curves that enter it to those that leave it, with high \
         on the left. A link is known as soon as its cell is read.",
    );
    pages.step("links", text, window.size(), |figure| {
        window.fill(figure, |p| swept.side(p));
        window.grid(figure);
        figure.clipped(Point2::origin(), window.size(), |figure| {
            for (number, line) in swept.lines().enumerate() {
                let colour = palette::of_many(number);
                let place = |v| {
                    let (_, pair) = swept.contours.pair(v);
                    let near = pair.iter().any(|p| window.contains(*p));
                    near.then(|| window.between(pair, f64::from(v.t))).flatten()
                };
                let mut places: Vec<Option<Point2>> = line.vertices.iter().map(place).collect();
                places.extend(places.first().copied().filter(|_| line.closed));
                for pair in places.windows(2) {
                    if let [Some(from), Some(to)] = pair {
                        figure.arrow(*from, *to, 2.0, colour);
                    }
                }
                for place in places.iter().flatten() {
                    figure.circle(*place, 4.0, &format!("fill=\"{colour}\" stroke=\"#fff\""));
                }
            }
            for p in window.pixels().filter(|p| swept.height(*p).is_some()) {
                figure.circle(window.centre(p), 2.5, "fill=\"#222\"");
            }
        });
        window.frame(figure);
        figure.legend(Mark::Dot(palette::MANY[0]), "vertex, in the colour of its line");
        figure.legend(Mark::Line(palette::MANY[0]), "link, in the direction of the curve");
        figure.legend(Mark::Dot(palette::FRAME), "sample: the centre of a pixel (the small dots)");
        side_legend(figure);
    });
    pages.count("level lines of the view", swept.lines().count());
}

fn curves(drawn: &Drawn<'_>, pages: &mut Builder) -> Result<(), PartialError> {
    let Drawn { view, setup, plane, options } = *drawn;
    let model = partial_model(view, &setup.planes, options)?;
    let found = model.planes.iter().find(|p| p.plane == plane);
    let curves: Vec<_> = found.into_iter().flat_map(|p| &p.curves).map(|c| &c.curve).collect();
    pages.count("curves of the view", curves.len());
    let Some(around) = envelope_of(curves.iter().copied()) else { return Ok(()) };
    let in_world = view.world_from_sensor().translation.vector;
    let sensor = setup.planes.frame(plane).plane_from_world(&in_world.into());
    let map = PlaneMap::fit(&around.merged(&Envelope { min: sensor, max: sensor }), setup.unit);
    let text = (
        "Curves of the view on the plane",
        "Nodes with places, errors and reasons for ends. The solid is on the left of every curve, \
         seen against the normal of the plane.",
    );
    pages.step("curves", text, SIZE, |figure| {
        map.inside(figure, |figure| {
            for (number, curve) in curves.iter().enumerate() {
                map.curve(figure, curve, palette::of_many(number), 2.0);
            }
            map.dot(figure, &sensor, 6.0, palette::FRAME);
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::MANY[0]), "curve, with heads in its direction");
        figure.legend(Mark::Dot(palette::FRAME), "the sensor, projected onto the plane");
    });
    Ok(())
}
