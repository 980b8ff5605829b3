//! The steps of chapter 3 on one plane.

use super::image::{WINDOW, Window, shades};
use super::page::Builder;
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use transect::Setup;
use transect_device::{Neighbour, Pixel};
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_geometry::{Curve, EndReason, Point2};
use transect_partial::dissertation::{CurveSteps, Label, PlaneSteps};

/// Rows and columns of the window that shows subpixel places. Chosen by hand: cells have room
/// for the marks in them. Doubled, cells are half as wide.
const CLOSE_UP: [usize; 2] = [8, 13];

/// Distance between the marks of the inside, in crossings. Chosen by hand: marks do not touch.
/// Doubled, short curves have one mark.
const MARK_EVERY: usize = 4;

/// Draws all steps of one plane.
pub(super) fn draw(steps: &PlaneSteps, setup: &Setup, pages: &mut Builder) {
    let size = steps.view.image().size();
    let (whole, window) = (Window::whole(size), Window::best(size, WINDOW, |p| interest(steps, p)));
    range_images(steps, &whole, &window, pages);
    labels(steps, &whole, &window, pages);
    codes(steps, &window, pages);
    thinning(steps, &window, pages);
    traces(steps, &window, pages);
    let near = |p| if window.contains(p) { interest(steps, p) } else { [0.0; 2] };
    subpixel(steps, &Window::best(size, CLOSE_UP, near), pages);
    directions(steps, setup, pages);
    pages.count("contour pixels", size.all_pixels().filter(|p| code(steps, *p) > 0).count());
    let thinned = size.all_pixels().filter(|p| is_thinned(steps, *p)).count();
    pages.count("pixels whose label thinning changed", thinned);
    pages.count("curves of the view", steps.curves.iter().filter(|c| c.curve.is_some()).count());
}

fn code(steps: &PlaneSteps, p: Pixel) -> u8 {
    steps.codes.get(p).number()
}

/// How much a pixel shows of both kinds of intersection, and of range jumps.
fn interest(steps: &PlaneSteps, p: Pixel) -> [f64; 2] {
    let jump = if jumps(steps, p).is_empty() { 0.0 } else { 0.05 };
    [Neighbour::Up, Neighbour::Left]
        .map(|n| jump + f64::from(u8::from(steps.codes.get(p).crosses(n))))
}

/// The borders of a pixel at which labels differ without an intersection.
fn jumps(steps: &PlaneSteps, p: Pixel) -> Vec<Neighbour> {
    let (labels, code) = (&steps.labels[1], steps.codes.get(p));
    let differs = |n: &Neighbour| {
        let other = steps.view.frame().neighbour(p, *n).and_then(|other| labels.get(other));
        let here = labels.get(p);
        here.is_some() && other.is_some() && here != other && !code.crosses(*n)
    };
    [Neighbour::Up, Neighbour::Left].into_iter().filter(differs).collect()
}

fn is_thinned(steps: &PlaneSteps, p: Pixel) -> bool {
    steps.labels[0].get(p) != steps.labels[1].get(p)
}

fn label_colour(label: Option<Label>) -> [u8; 3] {
    palette::rgb(match label {
        Some(Label::High) => palette::HIGH,
        Some(Label::Low) => palette::LOW,
        None => palette::MISSING,
    })
}

fn label_legend(figure: &mut Figure) {
    figure.legend(Mark::Area(palette::HIGH), "high: the sample lies over the plane");
    figure.legend(Mark::Area(palette::LOW), "low: the sample lies on the plane or below");
    figure.legend(Mark::Area(palette::MISSING), "missing pixel, without a label");
}

fn range_images(steps: &PlaneSteps, whole: &Window, window: &Window, pages: &mut Builder) {
    let view = &steps.view;
    let value = |p: Pixel| view.image().get(p).map(f64::from);
    let size = view.image().size();
    let shade = shades(size.all_pixels().filter_map(value));
    let legend = |figure: &mut Figure| {
        figure.legend(Mark::Area("#440154"), "near");
        figure.legend(Mark::Area("#9fc928"), "far");
        figure.legend(Mark::Line(palette::FOUND), "part that the following figures show");
    };
    let text = (
        "Object range image",
        "What the sensor measured: one range per pixel (3.4.1, Figure 3.2 d).",
    );
    pages.step("object-range-image", text, whole.size(), |figure| {
        whole.fill(figure, |p| shade(value(p)));
        whole.outline(figure, window);
        whole.frame(figure);
        legend(figure);
        figure.legend(Mark::Area(palette::MISSING), "missing pixel");
    });
    let text = (
        "Plane range image",
        "What the sensor would measure of the plane alone: the inverse mapping F gives it, with the \
         shades of figure 1 (3.4.1, Figure 3.2 e).",
    );
    pages.step("plane-range-image", text, whole.size(), |figure| {
        whole.fill(figure, |p| shade(Some(steps.plane_image.get(p))));
        whole.outline(figure, window);
        whole.frame(figure);
        legend(figure);
        figure.legend(Mark::Area(palette::MISSING), "no ray, or it never meets the plane");
    });
}

fn labels(steps: &PlaneSteps, whole: &Window, window: &Window, pages: &mut Builder) {
    let text = (
        "Label image Ω",
        "Each sample is high or low by its signed height over the plane (Eq. 3.2 to 3.4, errata). \
         The plane crosses the surface where the labels change.",
    );
    pages.step("label-image", text, whole.size(), |figure| {
        whole.fill(figure, |p| label_colour(steps.labels[0].get(p)));
        whole.outline(figure, window);
        whole.frame(figure);
        label_legend(figure);
        figure.legend(Mark::Line(palette::FOUND), "part that the following figures show");
    });
}

/// Borders of the pixels of a window, in a colour by whether they are intersections.
fn borders(steps: &PlaneSteps, window: &Window, figure: &mut Figure) {
    for p in window.pixels() {
        for (neighbour, is_up) in [(Neighbour::Up, true), (Neighbour::Left, false)] {
            if steps.codes.get(p).crosses(neighbour) {
                let style = format!("stroke=\"{}\" stroke-width=\"2.5\"", palette::FOUND);
                figure.line(&window.border(p, is_up), false, &style);
            }
        }
        for jump in jumps(steps, p) {
            let dashes = "stroke-width=\"2.5\" stroke-dasharray=\"5 3\"";
            let style = format!("stroke=\"{}\" {dashes}", palette::REFUSED);
            figure.line(&window.border(p, jump == Neighbour::Up), false, &style);
        }
    }
}

fn codes(steps: &PlaneSteps, window: &Window, pages: &mut Builder) {
    let text = (
        "Codes",
        "A pixel whose label differs from that of its neighbour, on the same surface, is a contour \
         pixel (3.4.2, Figures 3.4 and 3.5). Its code says which neighbour differs.",
    );
    pages.step("codes", text, window.size(), |figure| {
        window.fill(figure, |p| label_colour(steps.labels[1].get(p)));
        window.grid(figure);
        borders(steps, window, figure);
        for p in window.pixels().filter(|p| code(steps, *p) > 0) {
            let at = window.centre(p) + transect_geometry::Vector2::new(0.0, 0.2 * window.cell());
            let text = code(steps, p).to_string();
            figure.text(at, Anchor::Middle, 0.55 * window.cell(), palette::FRAME, &text);
        }
        window.frame(figure);
        figure.legend(Mark::Text("1"), "the row before differs");
        figure.legend(Mark::Text("2"), "the column before differs");
        figure.legend(Mark::Text("3"), "both differ");
        label_legend(figure);
        figure.legend(Mark::Line(palette::FOUND), "intersection of plane and surface");
        figure.legend(Mark::Dashed(palette::REFUSED), "range jump: two surfaces, no intersection");
    });
}

fn thinning(steps: &PlaneSteps, window: &Window, pages: &mut Builder) {
    let size = steps.view.image().size();
    let changed = |p: Pixel| [f64::from(u8::from(is_thinned(steps, p))); 2];
    let thinned = size.all_pixels().find(|p| is_thinned(steps, *p));
    let best = thinned.map(|_| Window::best(size, WINDOW, changed));
    let (window, caption) = match &best {
        Some(best) => (
            best,
            "Where labels alternate across a curve, the border in the middle stays (3.5.2). Pixels \
             with a mark got the label of their side.",
        ),
        None => (window, "No curve of this plane is several pixels thick, so no label changes."),
    };
    pages.step("thinning", ("Thinning", caption), window.size(), |figure| {
        window.fill(figure, |p| label_colour(steps.labels[0].get(p)));
        window.grid(figure);
        borders(steps, window, figure);
        for p in window.pixels().filter(|p| is_thinned(steps, *p)) {
            let style = format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"", palette::FRAME);
            figure.circle(window.centre(p), 0.28 * window.cell(), &style);
        }
        window.frame(figure);
        label_legend(figure);
        figure.legend(Mark::Line(palette::FOUND), "intersection after thinning");
        figure.legend(Mark::Text("○"), "pixel whose label thinning changed");
    });
}

fn traces(steps: &PlaneSteps, window: &Window, pages: &mut Builder) {
    let text = (
        "Tracing",
        "Contour pixels that share a cell of four pixels follow each other (3.5.1, Figure 3.6). \
         Missing pixels are bridged where range and direction continue.",
    );
    pages.step("tracing", text, window.size(), |figure| {
        window.fill(figure, |p| label_colour(steps.labels[1].get(p)));
        window.grid(figure);
        figure.clipped(Point2::origin(), window.size(), |figure| {
            for (number, curve) in steps.curves.iter().enumerate() {
                trace(curve, palette::of_many(number), window, figure);
            }
        });
        window.frame(figure);
        figure.legend(Mark::Line(palette::MANY[0]), "traced pixels; each curve has a colour");
        figure.legend(Mark::Dashed(palette::FRAME), "bridged missing pixels");
        figure.legend(Mark::Dot(palette::FRAME), "first pixel of a curve");
        figure.legend(Mark::Text("B"), "ends at the border of the image");
        figure.legend(Mark::Text("M"), "ends at a missing pixel");
        figure.legend(Mark::Text("J"), "ends at a range jump");
        label_legend(figure);
    });
}

fn trace(curve: &CurveSteps, colour: &str, window: &Window, figure: &mut Figure) {
    let pixels = &curve.pixels;
    for (k, &(pixel, bridged)) in pixels.iter().enumerate() {
        let next = match (pixels.get(k + 1), curve.ends) {
            (Some((next, _)), _) => *next,
            (None, None) => pixels[0].0,
            (None, Some(_)) => continue,
        };
        if !window.contains(pixel) && !window.contains(next) || pixel.col.abs_diff(next.col) > 60 {
            continue;
        }
        let style = if bridged {
            format!("stroke=\"{}\" stroke-width=\"3\" stroke-dasharray=\"6 4\"", palette::FRAME)
        } else {
            format!("stroke=\"{colour}\" stroke-width=\"4\" stroke-linecap=\"round\"")
        };
        figure.line(&[window.centre(pixel), window.centre(next)], false, &style);
    }
    let (Some(first), Some(last)) = (pixels.first(), pixels.last()) else { return };
    figure.circle(window.centre(first.0), 0.2 * window.cell(), "fill=\"#222\"");
    for (reason, (pixel, _)) in curve.ends.into_iter().flatten().zip([first, last]) {
        let letter = match reason {
            EndReason::ImageBorder => "B",
            EndReason::MissingPixel => "M",
            EndReason::RangeJump => "J",
            _ => "?",
        };
        let at = window.centre(*pixel) + transect_geometry::Vector2::new(0.0, -0.3 * window.cell());
        figure.text(at, Anchor::Middle, 0.6 * window.cell(), palette::FRAME, letter);
    }
}

fn subpixel(steps: &PlaneSteps, window: &Window, pages: &mut Builder) {
    let text = (
        "Subpixel places",
        "Between the two pixels of an intersection, the surface is interpolated; the node is where \
         it meets the plane (3.6, Figure 3.7).",
    );
    pages.step("subpixel", text, window.size(), |figure| {
        window.fill(figure, |p| label_colour(steps.labels[1].get(p)));
        window.grid(figure);
        figure.clipped(Point2::origin(), window.size(), |figure| {
            for (number, curve) in steps.curves.iter().enumerate() {
                let crossings = curve.crossings.iter();
                let near = crossings.filter(|c| c.pair.iter().any(|p| window.contains(*p)));
                let places: Vec<Point2> =
                    near.clone().filter_map(|c| window.between(c.pair, c.parameter)).collect();
                let colour = palette::of_many(number);
                let style = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\"");
                for pair in places.windows(2).filter(|w| (w[1] - w[0]).norm() < 2.0 * window.cell())
                {
                    figure.line(pair, false, &style);
                }
                for crossing in near {
                    let pair = crossing.pair.map(|p| window.centre(p));
                    figure.line(&pair, false, "stroke=\"#555\" stroke-dasharray=\"3 3\"");
                }
                for place in &places {
                    figure.circle(*place, 5.0, &format!("fill=\"{colour}\" stroke=\"#fff\""));
                }
            }
            for p in window.pixels().filter(|p| steps.labels[1].get(*p).is_some()) {
                figure.circle(window.centre(p), 2.5, "fill=\"#222\"");
            }
        });
        window.frame(figure);
        figure.legend(Mark::Dot(palette::FRAME), "sample: the centre of a pixel (the small dots)");
        figure.legend(Mark::Dashed("#555"), "the pair of pixels of an intersection");
        figure.legend(Mark::Dot(palette::MANY[0]), "node, in the colour of its curve");
        label_legend(figure);
    });
}

fn directions(steps: &PlaneSteps, setup: &Setup, pages: &mut Builder) {
    let curves: Vec<&Curve> =
        steps.curves.iter().filter_map(|c| c.curve.as_ref()).map(|c| &c.curve).collect();
    let Some(around) = envelope_of(curves.iter().copied()) else { return };
    let in_world = steps.view.world_from_sensor().translation.vector;
    let sensor = setup.planes.frame(steps.plane).plane_from_world(&in_world.into());
    let seen_from = transect_geometry::Envelope { min: sensor, max: sensor };
    let map = PlaneMap::fit(&around.merged(&seen_from), setup.unit);
    let turned = steps.curves.iter().filter(|c| c.votes < 0.0).count();
    let caption = format!(
        "The solid is on the left of every curve, seen against the normal of the plane (3.7, \
         Figure 3.8). {turned} of {} traces were turned round.",
        steps.curves.len()
    );
    pages.step("directions", ("Directed curves on the plane", &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            for crossing in steps.curves.iter().flat_map(|c| c.crossings.iter().step_by(MARK_EVERY))
            {
                let Some(inside) = crossing.towards_inside else { continue };
                let from = map.place(&crossing.position);
                let to = from + transect_geometry::Vector2::new(inside.x, -inside.y) * 14.0;
                let style = format!("stroke=\"{}\" stroke-width=\"1\"", palette::RESULT);
                figure.line(&[from, to], false, &style);
            }
            for curve in &curves {
                map.curve(figure, curve, palette::PAIR[0], 2.0);
            }
            map.dot(figure, &sensor, 6.0, palette::FRAME);
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::PAIR[0]), "curve, with heads in its direction");
        figure.legend(
            Mark::Line(palette::RESULT),
            "from free space into the solid, by the rays of \
                                                    both pixels",
        );
        figure.legend(Mark::Dot(palette::FRAME), "the sensor, projected onto the plane");
    });
}
