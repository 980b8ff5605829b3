//! The results of each room of the consensus, on one plane.

use super::PlaneOfViews;
use super::page::Builder;
use super::pairwise::curves_apart;
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of, is_outside};
use transect_exchange::svg::{Figure, Mark};
use transect_fusion::consensus::{ConsensusSteps, consensus_steps};
use transect_fusion::{ConsensusOptions, FusedPlane};
use transect_geometry::{Curve, Point2, Vector2};

/// Footprints that the close-up shows. Chosen by hand: single nodes can be told apart. Doubled,
/// they are half as far apart in the figure.
const CLOSE_UP_FOOTPRINTS: f64 = 14.0;

/// Largest factor by which the close-up stretches lengths across the curve. Chosen by hand: noise
/// shows, and bends keep their look. Doubled, smooth curves look rough.
const MOST_STRETCH: f64 = 12.0;

/// Draws observations, groups, nodes, chains and curves. Returns the fused curves.
pub(super) fn draw(
    of_views: &PlaneOfViews<'_>,
    options: &ConsensusOptions,
    pages: &mut Builder,
) -> Vec<Curve> {
    let (fused, steps) = consensus_steps(&of_views.views(), options);
    pages.count("observations", steps.observations.len());
    pages.count("nodes", steps.nodes.len());
    pages.count("chains", steps.chains.len());
    let all = of_views.curves.iter().flatten();
    let (Some(around), Some(near)) = (envelope_of(all), close_up(of_views, &steps, &fused)) else {
        return fused.curves;
    };
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    observations(of_views, &steps, (&map, &near), pages);
    groups(&steps, &near, pages);
    nodes(&steps, &near, pages);
    chains(&steps, &map, pages);
    let caption = format!(
        "Rings are round, corners are sharp, and no curve crosses another one: {} curves. The solid \
         is on the left.",
        fused.curves.len()
    );
    pages.step("fused", ("Fused curves", &caption), SIZE, |figure| {
        curves_apart(figure, &map, &fused.curves);
    });
    fused.curves
}

/// The map around the node that most views measured.
fn close_up(
    of_views: &PlaneOfViews<'_>,
    steps: &ConsensusSteps,
    fused: &FusedPlane,
) -> Option<PlaneMap> {
    let mut counts = vec![0; steps.nodes.len()];
    for node in steps.observations.iter().filter_map(|o| o.node) {
        counts[node as usize] += 1;
    }
    let order = |k: &usize| (steps.nodes[*k].views, counts[*k]);
    let best = steps.nodes.get((0..steps.nodes.len()).max_by_key(order)?)?;
    let near = |o: &&_| distance(o, &best.position);
    let footprint = steps.observations.iter().min_by(|a, b| near(a).total_cmp(&near(b)))?.footprint;
    let scale = SIZE[0] / (CLOSE_UP_FOOTPRINTS * footprint);
    let across = 0.5 * SIZE[1] / (1.2 * fused.threshold).max(f64::MIN_POSITIVE);
    let across = across.clamp(scale, MOST_STRETCH * scale);
    Some(PlaneMap::along(best.position, best.direction, [scale, across], of_views.setup.unit))
}

fn distance(o: &transect_fusion::consensus::ObservationStep, p: &Point2) -> f64 {
    (o.position - p).norm()
}

/// A short line through a place, along a direction.
fn needle(figure: &mut Figure, map: &PlaneMap, at: &Point2, along: &Vector2, colour: &str) {
    let place = map.place(at);
    if is_outside(&[place]) {
        return;
    }
    let way = (map.place(&(at + along)) - place).try_normalize(0.0).unwrap_or_default();
    let style = format!("stroke=\"{colour}\" stroke-width=\"1.6\"");
    figure.line(&[place - way * 9.0, place + way * 9.0], false, &style);
}

fn observations(
    of_views: &PlaneOfViews<'_>,
    steps: &ConsensusSteps,
    (map, near): (&PlaneMap, &PlaneMap),
    pages: &mut Builder,
) {
    let caption = format!(
        "The nodes of all views are observations: {} of them. Each has a place, a direction and an \
         error.",
        steps.observations.len()
    );
    pages.step("observations", ("Observations", &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            for o in &steps.observations {
                map.dot(figure, &o.position, 2.2, palette::of_many(o.view));
            }
            // The corners of what the close-up shows.
            let corner = |x: f64, y: f64| near.inverse(&Point2::new(x * SIZE[0], y * SIZE[1]));
            let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
            let style = format!("stroke=\"{}\" stroke-width=\"2.5\"", palette::FOUND);
            map.line(figure, &corners, true, &style);
            let middle = near.inverse(&Point2::new(0.5 * SIZE[0], 0.5 * SIZE[1]));
            figure.circle(map.place(&middle), 16.0, &format!("fill=\"none\" {style}"));
        });
        map.frame(figure);
        view_legend(of_views, figure);
        figure.legend(Mark::Line(palette::FOUND), "part that the close-ups show");
    });
    let text = (
        "Observations, close up",
        "Views differ by noise, by sampling and by systematic errors. All three are measured before \
         the observations are weighed.",
    );
    pages.step("observations-close", text, SIZE, |figure| {
        near.inside(figure, |figure| {
            for o in &steps.observations {
                needle(figure, near, &o.position, &o.direction, palette::of_many(o.view));
                near.dot(figure, &o.position, 4.5, palette::of_many(o.view));
            }
        });
        near.frame(figure);
        view_legend(of_views, figure);
        figure.legend(Mark::Remark, "The stroke through a dot is its direction.");
    });
}

/// The colours of the views.
fn view_legend(of_views: &PlaneOfViews<'_>, figure: &mut Figure) {
    for (number, name) in of_views.names.iter().enumerate().take(palette::MANY.len()) {
        figure.legend(Mark::Dot(palette::of_many(number)), name.as_str());
    }
    if of_views.names.len() > palette::MANY.len() {
        figure.legend(Mark::Remark, "Colours repeat for further views.");
    }
}

fn groups(steps: &ConsensusSteps, near: &PlaneMap, pages: &mut Builder) {
    let text = (
        "Groups",
        "Observations close to each other are one group, so that rough fits cost the same for any \
         number of views. Lines join the observations of a group.",
    );
    pages.step("groups", text, SIZE, |figure| {
        near.inside(figure, |figure| {
            let groups = steps.observations.iter().map(|o| o.group).max().map_or(0, |g| g + 1);
            let mut middles = vec![(Vector2::zeros(), 0.0); groups as usize];
            for o in &steps.observations {
                let (sum, count) = &mut middles[o.group as usize];
                *sum += o.position.coords;
                *count += 1.0;
            }
            for o in &steps.observations {
                let (sum, count) = middles[o.group as usize];
                let colour = palette::of_many(o.group as usize);
                let style = format!("stroke=\"{colour}\" stroke-width=\"1.4\"");
                near.line(figure, &[o.position, Point2::from(sum / count)], false, &style);
                near.dot(figure, &o.position, 4.0, colour);
            }
        });
        near.frame(figure);
        figure.legend(Mark::Dot(palette::MANY[0]), "observation, in the colour of its group");
        figure.legend(Mark::Remark, "Neighbouring groups differ in colour.");
    });
}

fn nodes(steps: &ConsensusSteps, near: &PlaneMap, pages: &mut Builder) {
    let text = (
        "Nodes",
        "Few groups are kept; each takes in the observations around it. A fit in a window gives the \
         node its place, and the weights give its error.",
    );
    pages.step("nodes", text, SIZE, |figure| {
        near.inside(figure, |figure| {
            for o in &steps.observations {
                if let Some(node) = o.node.and_then(|k| steps.nodes.get(k as usize)) {
                    let style = format!("stroke=\"{}\" stroke-width=\"1\"", palette::FORMER);
                    near.line(figure, &[o.position, node.position], false, &style);
                }
                near.dot(figure, &o.position, 3.0, palette::FORMER);
            }
            for node in &steps.nodes {
                let across = Vector2::new(-node.direction.y, node.direction.x) * node.sigma;
                let style = format!("stroke=\"{}\" stroke-width=\"3\"", palette::RESULT);
                near.line(figure, &[node.position - across, node.position + across], false, &style);
                near.dot(figure, &node.position, 6.0, palette::RESULT);
            }
        });
        near.frame(figure);
        figure.legend(Mark::Dot(palette::FORMER), "observation, with a line to its node");
        figure.legend(Mark::Dot(palette::RESULT), "node at its final place");
        figure.legend(Mark::Line(palette::RESULT), "its standard deviation across the curve, ±σ");
    });
}

fn chains(steps: &ConsensusSteps, map: &PlaneMap, pages: &mut Builder) {
    let caption = format!(
        "Nodes are linked in the direction of the curves; chains cover the plane once, and their \
         ends are joined where curves go on: {} chains.",
        steps.chains.len()
    );
    pages.step("chains", ("Chains", &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            for node in &steps.nodes {
                map.dot(figure, &node.position, 2.6, palette::MISSING);
            }
            for (number, chain) in steps.chains.iter().enumerate() {
                let place = |k: &u32| steps.nodes.get(*k as usize).map(|n| n.position);
                let places: Vec<Point2> = chain.nodes.iter().filter_map(place).collect();
                let colour = palette::of_many(number);
                let style = format!("stroke=\"{colour}\" stroke-width=\"2\"");
                map.line(figure, &places, chain.closed, &style);
                map.heads(figure, &places, colour, 2.0);
            }
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::MANY[0]), "chain, with heads in its direction");
        figure.legend(Mark::Dot(palette::MISSING), "node; those beside a chain were left out");
    });
}
