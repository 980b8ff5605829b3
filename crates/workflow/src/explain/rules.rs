//! A drawn example of each pattern and of each fork of Table 5.1, and of a ring.

use super::pairwise::{draw_parts, name_of, parts_legend, string_of, words_of};
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use transect_exchange::svg::{Anchor, Figure, Mark};
use transect_fusion::pairwise::{MergeOutcome, merge_steps};
use transect_fusion::pattern::{Fork, OverlapTolerance, Parts, Pattern, Verdict, verdict};
use transect_geometry::{Curve, Envelope, LengthUnit, Node, Point2};

/// Half the distance between the curves of an overlap, in the drawings' unit. Chosen by hand: two
/// lines are seen as two. Doubled, they do not look like an overlap.
const APART: f64 = 0.25;

/// Where the overlap begins and ends along both curves, in the drawings' unit. Chosen by hand:
/// about as long as the parts outside. Doubled, these are small in the drawing.
const OVERLAP: [f64; 2] = [-5.0, 5.0];

/// Length of an unenclosed part, in the drawings' unit. Chosen by hand: about as long as the
/// overlap. Doubled, the overlap is small in the drawing.
const OUTSIDE: f64 = 9.0;

/// The figures by name: five patterns, three forks, one ring. `None` if the drawings are wrong: a
/// curve of too few nodes, or a verdict without parts.
pub fn rule_figures() -> Option<Vec<(String, Figure)>> {
    let tolerance = OverlapTolerance::within(3.0 * APART).ok()?;
    let valid = Pattern::ALL.map(|p| (Verdict::Valid(p), ["a", "b", "c", "d", "e"][p as usize]));
    let forks = Fork::ALL.map(|f| (Verdict::Fork(f), ["1", "2", "3"][f as usize]));
    let mut figures = Vec::new();
    for (wanted, name) in valid.into_iter().chain(forks) {
        let combinations = combinations(wanted);
        let (a, b) = *combinations.first()?;
        let pair = [curve(a, 1.0)?, curve(b, -1.0)?];
        let kind = if wanted.is_valid() { "pattern" } else { "fork" };
        let title = match wanted {
            Verdict::Valid(pattern) => format!("Pattern {}", name_of(pattern)),
            Verdict::Fork(fork) => {
                let where_to = ["at the beginning", "at the end", "at both ends"][fork as usize];
                format!("Fork ({name}) {where_to}")
            }
        };
        let all = combinations.iter().map(|(a, b)| combination(*a, *b)).collect::<Vec<_>>();
        let caption = format!(
            "{} is {}. All combinations: {}.",
            combination(a, b),
            words_of(wanted),
            all.join(", ")
        );
        let figure = figure(&title, &caption, [&pair[0], &pair[1]], &tolerance)?;
        figures.push((format!("{kind}-{name}"), figure));
    }
    figures.push(("ring".to_owned(), ring(&tolerance)?));
    Some(figures)
}

fn combination(a: Parts, b: Parts) -> String {
    format!("{} {}", string_of(a, 'a'), string_of(b, 'A'))
}

/// The combinations of a verdict in the order of Table 5.1.
fn combinations(wanted: Verdict) -> Vec<(Parts, Parts)> {
    let all = Parts::ALL.iter().flat_map(|a| Parts::ALL.iter().map(|b| (*a, *b)));
    all.filter(|(a, b)| verdict(*a, *b) == wanted).collect()
}

/// A curve from left to right through the overlap, whose unenclosed parts lead away to one side.
fn curve(parts: Parts, side: f64) -> Option<Curve> {
    let begin = if parts.begins_unenclosed { OVERLAP[0] - OUTSIDE } else { OVERLAP[0] };
    let end = if parts.ends_unenclosed { OVERLAP[1] + OUTSIDE } else { OVERLAP[1] };
    let node = |k: i64| {
        let x = 0.5 * k as f64;
        let beyond = (OVERLAP[0] - x).max(x - OVERLAP[1]).max(0.0);
        Node::at(Point2::new(x, side * (APART + 0.045 * beyond * beyond)))
    };
    let nodes = ((2.0 * begin) as i64..=(2.0 * end) as i64).map(node);
    Curve::new(nodes.collect(), false).ok()
}

/// A pair as the rules see it, and what becomes of it.
fn figure(
    title: &str,
    caption: &str,
    pair: [&Curve; 2],
    tolerance: &OverlapTolerance,
) -> Option<Figure> {
    let steps = merge_steps(pair, tolerance);
    let reach = Point2::new(OVERLAP[1] + OUTSIDE, 8.0);
    let around = Envelope { min: -reach, max: reach };
    let around = around.merged(&envelope_of(pair)?);
    let map = PlaneMap::fit(&around, LengthUnit::Metre);
    let mut figure = Figure::new(title, caption, SIZE);
    map.inside(&mut figure, |figure| {
        draw_parts(figure, &map, (pair, 5.0), &steps.overlaps);
        if let MergeOutcome::Merged(merged) = &steps.outcome {
            map.curve(figure, merged, palette::FRAME, 1.6);
        }
    });
    figure.rectangle(Point2::origin(), SIZE, "fill=\"none\" stroke=\"#222\"");
    parts_legend(&mut figure);
    match &steps.outcome {
        MergeOutcome::Merged(_) => {
            figure.legend(Mark::Line(palette::FRAME), "the curve that both become");
        }
        MergeOutcome::Cut(side) => {
            let text = format!(
                "No merge: curve {} is cut at the fork, and the rest of it can be merged.",
                ["a b c", "A B C"][*side]
            );
            figure.legend(Mark::Remark, text);
        }
        MergeOutcome::Refused(_) => figure.legend(Mark::Remark, "No merge."),
        MergeOutcome::Apart => figure.legend(Mark::Remark, "No overlap."),
    }
    let at = Point2::new(SIZE[0] - 12.0, SIZE[1] - 14.0);
    let side =
        if steps.overlaps.as_slice().len() > 1 { "inside the ring" } else { "above the curves" };
    let text = &format!("the solid is on the left: {side}");
    figure.text(at, Anchor::End, 14.0, "#555", text);
    Some(figure)
}

/// Two arcs that go round a solid together.
fn ring(tolerance: &OverlapTolerance) -> Option<Figure> {
    let arc = |from: i32, to: i32, radius: f64| {
        let node = |k: i32| {
            let angle = f64::from(5 * k).to_radians();
            Node::at(Point2::new(radius * angle.cos(), radius * angle.sin()))
        };
        Curve::new((from..=to).map(node).collect(), false).ok()
    };
    let pair = [arc(-4, 40, 7.0)?, arc(33, 75, 7.0 + APART)?];
    let caption = "The end of each curve lies on the beginning of the other: two overlaps, and the \
                   curves become one closed curve (Rule 3).";
    figure("Ring", caption, [&pair[0], &pair[1]], tolerance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The drawings of docs/overlap-rules.md are those that the code makes, and all are shown.
    #[test]
    fn the_drawings_of_the_page_are_those_of_the_code() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
        let page = std::fs::read_to_string(docs.join("overlap-rules.md")).unwrap();
        let figures = rule_figures().unwrap();
        assert_eq!(figures.len(), Pattern::ALL.len() + Fork::ALL.len() + 1);
        for (name, figure) in figures {
            let file = format!("images/rules/{name}.svg");
            let mut drawn = Vec::new();
            figure.write(&mut drawn).unwrap();
            let there = std::fs::read(docs.join(&file)).unwrap_or_default();
            let help = "run: cargo xtask experiments rules --write-docs";
            assert!(there == drawn, "docs/{file} is not what the code draws; {help}");
            assert!(page.contains(&format!("]({file})")), "overlap-rules.md does not show {file}");
        }
    }
}
