//! The steps of chapter 5 for one pair of curves.

use super::PlaneOfViews;
use super::page::Builder;
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_fusion::pairwise::{
    MergeOutcome, MergeSteps, VerifiedOverlap, merge_steps, pairwise_watched,
};
use transect_fusion::pattern::{CurveRange, Fork, Overlaps, Parts, Pattern, Relation, Verdict};
use transect_fusion::{FusedPlane, PairwiseOptions};
use transect_geometry::{Curve, CurveUnit, Envelope, LengthUnit, Point2};

/// Units of the basis curve that the close-up shows. Chosen by hand: an overlap with some units on
/// both sides. Doubled, units lie too close together.
const CLOSE_UP_UNITS: f64 = 12.0;

/// Thresholds from the middle of the close-up to its upper edge. Chosen by hand: curves at one
/// threshold stay inside. Doubled, the curves seem to coincide.
const CLOSE_UP_THRESHOLDS: f64 = 1.8;

/// A pair that is merged when a view arrives.
struct Pair {
    view: usize,
    partial: Curve,
    global: Curve,
    /// All global curves at that time.
    plane: Vec<Curve>,
    common: Envelope,
    /// Distance by which envelopes are grown: the threshold.
    threshold: f64,
    steps: MergeSteps,
}

/// Draws the merge of one curve of a view, or of the nearest later view that has one. Returns the
/// fused curves.
pub(super) fn draw(
    of_views: &PlaneOfViews<'_>,
    view: usize,
    options: &PairwiseOptions,
    pages: &mut Builder,
) -> Vec<Curve> {
    let (pairs, fused) = merged_pairs(of_views, options);
    count_growth(&fused, pages);
    draw_pair(of_views, view, &pairs, &fused, pages);
    fused.curves
}

/// Draws the merge of the pair that tells most, and the plane after all views.
fn draw_pair(
    of_views: &PlaneOfViews<'_>,
    view: usize,
    pairs: &[Pair],
    fused: &FusedPlane,
    pages: &mut Builder,
) {
    // The view itself, else the first one after it, else any; of its pairs the longest.
    let views = of_views.names.len();
    let by_view = |p: &&Pair| (p.view + views * usize::from(p.view < view)).abs_diff(view);
    // Two curves that both go on tell more than one that lies on another.
    let lies_on_other = |p: &Pair| {
        let mut parts = p.steps.overlaps.as_slice().iter().flat_map(|o| [o.parts_a, o.parts_b]);
        parts.any(|parts| parts == Parts::WHOLE)
    };
    let length =
        |p: &Pair| -> f64 { p.steps.overlaps.as_slice().iter().map(|o| o.on_a.length()).sum() };
    let best = pairs.iter().min_by(|a, b| {
        let by_kind = lies_on_other(a).cmp(&lies_on_other(b));
        by_view(a).cmp(&by_view(b)).then(by_kind).then(length(b).total_cmp(&length(a)))
    });
    let Some(pair) = best else { return };
    let Some(verified) = &pair.steps.verified else { return };
    let name = &of_views.names[pair.view];
    envelopes(of_views, pair, name, pages);
    overlap(of_views, pair, pages);
    let close_up = CloseUp::new(pair, verified, of_views.setup.unit);
    verification(&close_up, of_views.setup.unit, pages);
    averaging(&close_up, pages);
    merged(of_views, pair, pages);
    result(of_views, fused, pages);
}

/// Every pair of a view's curve and a global one that would merge when the view arrives.
fn merged_pairs(of_views: &PlaneOfViews<'_>, options: &PairwiseOptions) -> (Vec<Pair>, FusedPlane) {
    let mut pairs = Vec::new();
    let fused = pairwise_watched(&of_views.views(), options, &mut |view, curves, plane| {
        for partial in curves {
            for meeting in plane.envelopes().meeting(partial) {
                let Some(global) = plane.curve(meeting.curve) else { continue };
                let steps = merge_steps([partial, global], plane.tolerance());
                if matches!(steps.outcome, MergeOutcome::Merged(_)) && steps.verified.is_some() {
                    pairs.push(Pair {
                        view,
                        partial: partial.clone(),
                        global: global.clone(),
                        plane: plane.curves().cloned().collect(),
                        common: meeting.common,
                        threshold: plane.tolerance().distance(),
                        steps,
                    });
                }
            }
        }
    });
    (pairs, fused)
}

/// The counts of a plane's growth, for the terminal.
pub(super) fn count_growth(fused: &FusedPlane, pages: &mut Builder) {
    let Some(growth) = &fused.growth else { return };
    let cases = ["new plane", "appended", "merged"];
    for (k, case) in cases.iter().enumerate() {
        pages.count(format!("views of case {} ({case})", k + 1), growth.cases[k]);
    }
    for pattern in Pattern::ALL {
        pages.count(
            format!("merges of pattern {}", name_of(pattern)),
            growth.patterns[pattern as usize],
        );
    }
    pages.count("rings closed", growth.rings);
    pages.count("curves cut at forks", growth.cut);
    pages.count("merges refused", growth.refused());
}

/// A pattern as Figure 5.7 calls it.
pub(super) fn name_of(pattern: Pattern) -> &'static str {
    [
        "(a) end to beginning",
        "(b) both whole",
        "(c) whole and end",
        "(d) whole and beginning",
        "(e) whole and middle",
    ][pattern as usize]
}

/// A verdict in words.
pub(super) fn words_of(verdict: Verdict) -> String {
    match verdict {
        Verdict::Valid(pattern) => format!("valid, pattern {}", name_of(pattern)),
        Verdict::Fork(Fork::AtBeginning) => "not valid: a fork at the beginning (1)".to_owned(),
        Verdict::Fork(Fork::AtEnd) => "not valid: a fork at the end (2)".to_owned(),
        Verdict::Fork(Fork::AtBothEnds) => "not valid: a fork at both ends (3)".to_owned(),
    }
}

fn envelopes(of_views: &PlaneOfViews<'_>, pair: &Pair, name: &str, pages: &mut Builder) {
    let around = envelope_of(pair.plane.iter().chain([&pair.partial]));
    let Some(around) = around else { return };
    let map = PlaneMap::fit(&around.grown(pair.threshold), of_views.setup.unit);
    let caption = format!(
        "View {name} arrives. Envelopes that meet may belong to curves that overlap; the common \
         rectangle limits the search (5.3, Figures 5.2 and 5.3)."
    );
    pages.step("envelopes", ("Envelopes", &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            let common = format!("fill=\"{}\" fill-opacity=\"0.45\"", palette::HIGH);
            map.rectangle(figure, &pair.common, &common);
            let dashes = "fill=\"none\" stroke-width=\"1.5\" stroke-dasharray=\"6 4\"";
            for curve in &pair.plane {
                let style = format!("{dashes} stroke=\"{}\"", palette::FORMER);
                map.rectangle(figure, &curve.envelope().grown(pair.threshold), &style);
                map.curve(figure, curve, palette::FORMER, 1.6);
            }
            for (curve, colour) in
                [(&pair.partial, palette::PAIR[0]), (&pair.global, palette::PAIR[1])]
            {
                let style = format!("{dashes} stroke=\"{colour}\"");
                map.rectangle(figure, &curve.envelope().grown(pair.threshold), &style);
                map.curve(figure, curve, colour, 2.6);
            }
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::PAIR[0]), "a curve of the view that arrives");
        figure.legend(Mark::Line(palette::PAIR[1]), "a global curve whose envelope meets its own");
        figure.legend(Mark::Line(palette::FORMER), "the other global curves");
        figure.legend(Mark::Dashed(palette::FORMER), "envelope, grown by the threshold");
        figure.legend(Mark::Area(palette::HIGH), "the common rectangle of the pair");
    });
}

fn overlap(of_views: &PlaneOfViews<'_>, pair: &Pair, pages: &mut Builder) {
    let Some(around) = envelope_of([&pair.partial, &pair.global]) else { return };
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    let overlaps = &pair.steps.overlaps;
    let verdict = match overlaps.relation() {
        Relation::Ring => "The two curves form a ring (Rule 3).".to_owned(),
        _ => overlaps.as_slice().first().map_or(String::new(), |overlap| {
            let parts = [string_of(overlap.parts_a, 'a'), string_of(overlap.parts_b, 'A')];
            format!("{} {} is {}.", parts[0], parts[1], words_of(overlap.verdict))
        }),
    };
    let caption = format!(
        "Where the two curves run beside each other, they overlap; the rest of each decides \
         whether they can be merged (5.4, Table 5.1). {verdict}"
    );
    pages.step("overlap", ("Overlap pattern", &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            draw_parts(figure, &map, ([&pair.partial, &pair.global], 2.4), overlaps);
        });
        map.frame(figure);
        parts_legend(figure);
    });
}

/// The legend of [`draw_parts`].
pub(super) fn parts_legend(figure: &mut Figure) {
    figure.legend(Mark::Line(palette::PAIR[0]), "first curve; its parts are a, b, c");
    figure.legend(Mark::Line(palette::PAIR[1]), "second curve; its parts are A, B, C");
    figure.legend(Mark::Area(palette::HIGH), "enclosed part of both: the overlap (b, B)");
    figure.legend(Mark::Text("a, A"), "before the overlap; â: nothing is there");
    figure.legend(Mark::Text("c, C"), "behind the overlap; ĉ: nothing is there");
}

/// The parts of a curve as Table 5.1 writes them, with the first letter of its alphabet.
pub(super) fn string_of(parts: Parts, first: char) -> String {
    let [a, b, c] = if first == 'a' { ["a", "b", "c"] } else { ["A", "B", "C"] };
    let hat = |is_there: bool| if is_there { "" } else { "\u{302}" };
    format!("{a}{}{b}{c}{}", hat(parts.begins_unenclosed), hat(parts.ends_unenclosed))
}

/// Both curves of a pair in a width, their enclosed parts, and the letters of all parts.
pub(super) fn draw_parts(
    figure: &mut Figure,
    map: &PlaneMap,
    (pair, width): ([&Curve; 2], f64),
    overlaps: &Overlaps,
) {
    let ranges = |side: usize| {
        overlaps.as_slice().iter().map(move |o| if side == 0 { o.on_a } else { o.on_b })
    };
    for (side, curve) in pair.iter().enumerate() {
        for range in ranges(side) {
            let style = format!(
                "stroke=\"{}\" stroke-width=\"15\" stroke-linecap=\"round\"",
                palette::HIGH
            );
            map.line(figure, &stretch(curve, &range), false, &style);
        }
    }
    for (side, curve) in pair.iter().enumerate() {
        map.curve(figure, curve, palette::PAIR[side], width);
        let letters = [["a", "b", "c"], ["A", "B", "C"]][side];
        let Some(range) = ranges(side).next() else { continue };
        let length = curve.length();
        let parts = [
            CurveRange { from: 0.0, to: range.from },
            range,
            CurveRange { from: range.to, to: length },
        ];
        for (part, letter) in parts.iter().zip(letters).filter(|(p, _)| p.length() > 0.02 * length)
        {
            let places: Vec<Point2> = stretch(curve, part).iter().map(|p| map.place(p)).collect();
            let last = (places.len() / 2).max(1);
            let Some([from, to]) = places.get(last - 1..=last) else { continue };
            // The first curve's letters are on its left, the second one's on its right.
            let along = (to - from).try_normalize(0.0).unwrap_or_default();
            let left = transect_geometry::Vector2::new(along.y, -along.x);
            let at = from + (to - from) * 0.5 + left * if side == 0 { 22.0 } else { -22.0 };
            let at = Point2::new(at.x, at.y + 6.0);
            figure.text(at, Anchor::Middle, 20.0, palette::PAIR[side], letter);
        }
    }
}

/// The points of a curve between two arc lengths.
fn stretch(curve: &Curve, range: &CurveRange) -> Vec<Point2> {
    let (mut points, mut from) = (Vec::new(), 0.0);
    let rounds = if curve.is_closed() { 2 } else { 1 };
    for unit in (0..rounds).flat_map(|_| curve.units()) {
        let to = from + unit.vector().norm();
        let share =
            |at: f64| if to > from { ((at - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
        if to >= range.from && from <= range.to {
            if points.is_empty() {
                points.push(unit.at(share(range.from)));
            }
            points.push(unit.at(share(range.to)));
        }
        from = to;
    }
    points
}

/// The place where a pair was verified: the start of its overlap.
struct CloseUp<'a> {
    pair: &'a Pair,
    verified: &'a VerifiedOverlap,
    map: PlaneMap,
}

impl<'a> CloseUp<'a> {
    /// The map runs in the direction of the basis curve's unit.
    fn new(pair: &'a Pair, verified: &'a VerifiedOverlap, length_unit: LengthUnit) -> Self {
        let unit = verified.unit;
        let along = unit.vector().try_normalize(0.0).unwrap_or_default();
        let basis = &verified.enclosed[verified.basis];
        let spacing = basis.windows(2).map(|w| (w[1].position - w[0].position).norm()).sum::<f64>()
            / (basis.len().max(2) - 1) as f64;
        let width = CLOSE_UP_UNITS * spacing.max(unit.vector().norm()).max(f64::MIN_POSITIVE);
        let scale = SIZE[0] / width;
        let across = 0.5 * SIZE[1] / (CLOSE_UP_THRESHOLDS * pair.threshold);
        let origin = unit.start + along * (0.42 * width);
        let map = PlaneMap::along(origin, along, [scale, across.max(scale)], length_unit);
        Self { pair, verified, map }
    }
}

fn verification(close_up: &CloseUp<'_>, unit: LengthUnit, pages: &mut Builder) {
    let CloseUp { pair, verified, map } = close_up;
    let text = (
        "Basis and distant curve",
        "The first point of one curve projects into a unit of the other, nearer than the threshold: \
         the first is the distant curve, the other the basis curve (5.5.1, Figure 5.8).",
    );
    pages.step("verification", text, SIZE, |figure| {
        map.inside(figure, |figure| {
            band(figure, map, &verified.unit, pair.threshold);
            both_curves(figure, map, pair, true);
            let CurveUnit { start, end } = verified.unit;
            let colour = palette::PAIR[verified.basis];
            let style = format!("stroke=\"{colour}\" stroke-width=\"6\"");
            map.line(figure, &[start, end], false, &style);
            let foot = verified.unit.at(verified.unit.parameter(&verified.point).clamp(0.0, 1.0));
            let style = "stroke=\"#222\" stroke-width=\"2\" stroke-dasharray=\"5 3\"";
            map.line(figure, &[verified.point, foot], false, style);
            let at = map.place(&verified.point);
            figure.circle(at, 8.0, "fill=\"none\" stroke=\"#222\" stroke-width=\"2.5\"");
            let at = Point2::new(at.x, at.y - 15.0);
            figure.text(at, Anchor::Middle, 17.0, palette::FRAME, "q₁");
        });
        map.frame(figure);
        let roles = |side: usize| if side == verified.basis { "basis" } else { "distant" };
        let what = ["curve of the view", "global curve"];
        for side in [0, 1] {
            let text = format!("{} curve: the {}", roles(side), what[side]);
            figure.legend(Mark::Line(palette::PAIR[side]), text);
        }
        figure.legend(Mark::Dashed(palette::FRAME), "distance y of the first point q₁");
        figure
            .legend(Mark::Area("#eef3e6"), "0 ≤ x ≤ x_end and |y| ≤ threshold for the thick unit");
        figure.legend(
            Mark::Remark,
            format!("threshold: {} {}", crate::table::digits(pair.threshold), unit),
        );
    });
}

/// The place where a unit holds points.
fn band(figure: &mut Figure, map: &PlaneMap, unit: &CurveUnit, threshold: f64) {
    let along = unit.vector().try_normalize(0.0).unwrap_or_default();
    let across = transect_geometry::Vector2::new(-along.y, along.x) * threshold;
    let corners = [unit.start + across, unit.end + across, unit.end - across, unit.start - across];
    let places = corners.map(|p| map.place(&p));
    figure.line(&places, true, "fill=\"#eef3e6\" stroke=\"#b7c7a0\"");
}

fn both_curves(figure: &mut Figure, map: &PlaneMap, pair: &Pair, strong: bool) {
    for (curve, colour) in [(&pair.partial, palette::PAIR[0]), (&pair.global, palette::PAIR[1])] {
        let nodes: Vec<Point2> = curve.nodes().iter().map(|n| n.position).collect();
        let opacity = if strong { 1.0 } else { 0.45 };
        let style = format!("stroke=\"{colour}\" stroke-width=\"2\" opacity=\"{opacity}\"");
        map.line(figure, &nodes, curve.is_closed(), &style);
        for node in &nodes {
            let style = format!("fill=\"{colour}\" opacity=\"{opacity}\"");
            figure.circle(map.place(node), 4.0, &style);
        }
    }
}

fn averaging(close_up: &CloseUp<'_>, pages: &mut Builder) {
    let CloseUp { pair, verified, map } = close_up;
    let text = (
        "Averaging",
        "Each unit of the basis curve gives one node: half of its length along, and half of the mean \
         distance of the distant points across (5.5.2, Figures 5.10 and 5.11).",
    );
    pages.step("averaging", text, SIZE, |figure| {
        map.inside(figure, |figure| {
            both_curves(figure, map, pair, false);
            let nodes: Vec<Point2> = verified.averaged.iter().map(|n| n.position).collect();
            let style = format!("stroke=\"{}\" stroke-width=\"3\"", palette::RESULT);
            map.line(figure, &nodes, false, &style);
            nodes.iter().for_each(|node| map.dot(figure, node, 6.0, palette::RESULT));
            for point in &verified.noise {
                let style =
                    format!("fill=\"none\" stroke=\"{}\" stroke-width=\"2.5\"", palette::REFUSED);
                figure.circle(map.place(point), 8.0, &style);
            }
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::PAIR[0]), "the view's curve before");
        figure.legend(Mark::Line(palette::PAIR[1]), "the global curve before");
        figure.legend(Mark::Line(palette::RESULT), "the averaged curve");
        figure.legend(Mark::Text("○"), "point left out as noise (Figure 5.12)");
        figure.legend(
            Mark::Remark,
            format!(
                "{} and {} enclosed nodes become {}.",
                verified.enclosed[0].len(),
                verified.enclosed[1].len(),
                verified.averaged.len()
            ),
        );
    });
}

fn merged(of_views: &PlaneOfViews<'_>, pair: &Pair, pages: &mut Builder) {
    let MergeOutcome::Merged(curve) = &pair.steps.outcome else { return };
    let Some(around) = envelope_of([&pair.partial, &pair.global, curve]) else { return };
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    let text = (
        "The merged curve",
        "The averaged part takes the place of the overlap; the unenclosed parts stay as they were. \
         The merged curve goes on to the next global curve (5.2.2, 5.3.1).",
    );
    pages.step("merged", text, SIZE, |figure| {
        map.inside(figure, |figure| {
            map.curve(figure, &pair.partial, palette::PAIR[0], 7.0);
            map.curve(figure, &pair.global, palette::PAIR[1], 5.0);
            map.curve(figure, curve, palette::FRAME, 1.8);
        });
        map.frame(figure);
        figure.legend(Mark::Line(palette::PAIR[0]), "the view's curve before");
        figure.legend(Mark::Line(palette::PAIR[1]), "the global curve before");
        figure.legend(Mark::Line(palette::FRAME), "the merged curve");
    });
}

fn result(of_views: &PlaneOfViews<'_>, fused: &FusedPlane, pages: &mut Builder) {
    let Some(around) = envelope_of(&fused.curves) else { return };
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    let caption = format!(
        "The fused curves of this plane after {} views: {} curves.",
        of_views.names.len(),
        fused.curves.len()
    );
    pages.step("plane", ("The plane after all views", &caption), SIZE, |figure| {
        curves_apart(figure, &map, &fused.curves);
    });
}

/// Curves in colours of their own, with their directions and their open ends.
pub(super) fn curves_apart(figure: &mut Figure, map: &PlaneMap, curves: &[Curve]) {
    map.inside(figure, |figure| {
        for (number, curve) in curves.iter().enumerate() {
            map.curve(figure, curve, palette::of_many(number), 2.2);
            if let (false, [first, .., last]) = (curve.is_closed(), curve.nodes()) {
                for end in [first, last] {
                    let style =
                        format!("fill=\"#fff\" stroke=\"{}\" stroke-width=\"2\"", palette::REFUSED);
                    figure.circle(map.place(&end.position), 4.5, &style);
                }
            }
        }
    });
    map.frame(figure);
    figure.legend(Mark::Line(palette::MANY[0]), "curve, with heads in its direction");
    figure.legend(Mark::Text("○"), "open end: no view saw how the boundary goes on");
}
