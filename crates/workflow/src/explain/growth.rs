//! How a plane grows with every view (5.2.2).

use super::PlaneOfViews;
use super::image::{Window, range_image};
use super::page::Builder;
use super::pairwise::{count_growth, name_of};
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use super::seen_through;
use crate::WorkflowError;
use transect::Setup;
use transect_device::View;
use transect_exchange::svg::{Figure, Mark};
use transect_fusion::pairwise::{GrowthCounts, pairwise_watched};
use transect_fusion::pattern::Pattern;
use transect_fusion::{FusionMethod, PairwiseOptions};
use transect_geometry::Curve;
use transect_model::Section;

/// Seconds that the animation shows each view. Chosen by hand: long enough to see what is new.
/// Doubled, eleven views take half a minute.
const SECONDS: f64 = 1.5;

/// A plane after a view.
struct State {
    view: usize,
    /// Curves that the view changed or brought, and the others.
    changed: Vec<Curve>,
    same: Vec<Curve>,
    counts: GrowthCounts,
}

impl State {
    /// All curves.
    fn curves(&self) -> Vec<Curve> {
        self.same.iter().chain(&self.changed).cloned().collect()
    }
}

/// The options of `pairwise`, which alone has a plane after every view.
pub(super) fn options(setup: &Setup) -> Result<PairwiseOptions, WorkflowError> {
    match setup.fusion {
        FusionMethod::Pairwise(options) => Ok(options),
        FusionMethod::Consensus(_) => {
            let problem = "consensus fuses all views at once, so no plane grows view by view; leave \
                           out --fusion for pairwise, or draw the steps of consensus: transect \
                           explain";
            Err(WorkflowError::setting("fusion", problem))
        }
    }
}

/// Draws the range image of every view that crosses the plane, the plane after it, and all of these
/// planes in turn.
pub(super) fn draw(
    of_views: &PlaneOfViews<'_>,
    options: &PairwiseOptions,
    load: &dyn Fn(usize) -> Result<View, WorkflowError>,
    pages: &mut Builder,
) -> Result<(), WorkflowError> {
    let states = states(of_views, options, pages);
    let around = envelope_of(of_views.curves.iter().flatten());
    let (Some(around), Some(last)) = (around, states.last()) else {
        let problem =
            format!("no view has a curve on plane {}; choose another one", of_views.plane);
        return Err(WorkflowError::setting("plane", problem));
    };
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    for (k, state) in states.iter().enumerate() {
        let before = k.checked_sub(1).and_then(|k| states.get(k)).map(|s| s.counts);
        let title = format!("View {}", of_views.names[state.view]);
        let caption = caption(state, &before.unwrap_or_default());
        let image = load(state.view)?;
        let text = (format!("Range image of view {}", image.name()), "What the sensor measured.");
        let size = Window::whole(image.image().size()).size();
        pages.step(&format!("image-{:03}", state.view), (&text.0, text.1), size, |figure| {
            range_image(figure, &image);
        });
        pages.step(&format!("view-{:03}", state.view), (&title, &caption), SIZE, |figure| {
            plane(figure, &map, state);
            legend(&map, figure);
        });
    }
    let caption = format!(
        "All {} views in turn, {SECONDS} seconds each, again and again. {} gaps are left.",
        states.len(),
        gaps(&last.curves()).0.len()
    );
    pages.step("growth", ("The plane grows", &caption), SIZE, |figure| {
        let of = SECONDS * states.len() as f64;
        for (k, state) in states.iter().enumerate() {
            figure.appearing([SECONDS * k as f64, of], |figure| {
                figure.rectangle(transect_geometry::Point2::origin(), SIZE, "fill=\"#fff\"");
                plane(figure, &map, state);
                let at = transect_geometry::Point2::new(14.0, 26.0);
                let text = format!("view {}", of_views.names[state.view]);
                figure.text(at, transect_exchange::svg::Anchor::Start, 18.0, palette::FRAME, &text);
            });
        }
        legend(&map, figure);
    });
    let curves = seen_through::draw(of_views, last.curves(), pages);
    let (gaps, open) = gaps(&curves);
    pages.count("curves of the plane", curves.len());
    pages.count("gaps left", gaps.len());
    let longest = format!("{} {}", crate::table::digits(open), of_views.setup.unit);
    pages.count("longest gap", longest);
    Ok(())
}

/// The plane after each view that has curves on it.
fn states(
    of_views: &PlaneOfViews<'_>,
    options: &PairwiseOptions,
    pages: &mut Builder,
) -> Vec<State> {
    let mut planes: Vec<(Vec<Curve>, GrowthCounts)> = Vec::new();
    let fused = pairwise_watched(&of_views.views(), options, &mut |_, _, plane| {
        planes.push((plane.curves().cloned().collect(), *plane.counts()));
    });
    count_growth(&fused, pages);
    planes.push((fused.curves, fused.growth.unwrap_or_default()));
    let views =
        planes.windows(2).enumerate().filter(|(view, _)| !of_views.curves[*view].is_empty());
    let state = |(view, pair): (usize, &[(Vec<Curve>, GrowthCounts)])| {
        let (before, after) = (&pair[0].0, &pair[1].0);
        // The last step marks and cuts the curves, so places alone are compared.
        let places = |c: &Curve| c.nodes().iter().map(|n| n.position).collect::<Vec<_>>();
        let former: Vec<_> = before.iter().map(places).collect();
        let is_former = |c: &&Curve| former.contains(&places(c));
        let (same, changed): (Vec<&Curve>, Vec<&Curve>) = after.iter().partition(is_former);
        let owned = |curves: Vec<&Curve>| curves.into_iter().cloned().collect();
        State { view, changed: owned(changed), same: owned(same), counts: pair[1].1 }
    };
    views.map(state).collect()
}

/// The case of a view, and the patterns of its merges.
fn caption(state: &State, before: &GrowthCounts) -> String {
    let now = &state.counts;
    let mut text = if now.cases[0] > before.cases[0] {
        "Case 1: the plane was empty, and the curves of the view are its first.".to_owned()
    } else if now.cases[1] > before.cases[1] {
        "Case 2: no curve of the view overlaps one of the plane; all are put beside them."
            .to_owned()
    } else {
        let merged = now.merged - before.merged;
        format!("Case 3: curves of the view overlap curves of the plane; {merged} were merged.")
    };
    let patterns = Pattern::ALL.iter().filter_map(|pattern| {
        let count = now.patterns[*pattern as usize] - before.patterns[*pattern as usize];
        (count > 0).then(|| format!("{count} × {}", name_of(*pattern)))
    });
    let mut found: Vec<String> = patterns.collect();
    let others = [
        (now.rings - before.rings, "ring closed"),
        (now.cut - before.cut, "curve cut at a fork"),
        (now.refused() - before.refused(), "merge refused"),
    ];
    let others = others.iter().filter(|(count, _)| *count > 0);
    found.extend(others.map(|(count, what)| format!("{count} × {what}")));
    if !found.is_empty() {
        text.push_str(&format!(" {}.", found.join(", ")));
    }
    text.push_str(&format!(" Gaps left: {}.", gaps(&state.curves()).0.len()));
    text
}

/// The gaps between curves, each with its ends, and the length of the longest.
fn gaps(curves: &[Curve]) -> (Vec<[transect_geometry::Point2; 2]>, f64) {
    let gaps = Section::new(curves.to_vec()).map(|section| section.gaps()).unwrap_or_default();
    let longest = gaps.iter().map(|gap| gap.width()).fold(0.0, f64::max);
    (gaps.iter().map(|gap| gap.ends).collect(), longest)
}

fn plane(figure: &mut Figure, map: &PlaneMap, state: &State) {
    map.inside(figure, |figure| {
        let dashes = "stroke-width=\"2\" stroke-dasharray=\"3 4\"";
        for ends in gaps(&state.curves()).0 {
            map.line(figure, &ends, false, &format!("stroke=\"{}\" {dashes}", palette::REFUSED));
        }
        for curve in &state.same {
            map.curve(figure, curve, palette::FORMER, 2.0);
        }
        for curve in &state.changed {
            map.curve(figure, curve, palette::PAIR[0], 2.6);
        }
    });
}

fn legend(map: &PlaneMap, figure: &mut Figure) {
    map.frame(figure);
    figure.legend(Mark::Line(palette::PAIR[0]), "curve that this view brought or changed");
    figure.legend(Mark::Line(palette::FORMER), "curve of the views before");
    figure.legend(Mark::Dashed(palette::REFUSED), "gap that is left: from an open end to the next");
}
