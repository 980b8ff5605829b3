//! The parts of `docs/overlap-rules.md` that the rules themselves write.

use crate::table::{self, capitals, cell, number, symbols};
use transect_fusion::pattern::{
    Fork, OverlapTolerance, Parts, Pattern, TABLE_5_1, Verdict, classify, verdict,
};
use transect_geometry::{Curve, Node, Point2};

/// The generated blocks of the page: name and text, in the order of the page.
///
/// On the page each stands between `<!-- generated: name -->` and `<!-- end of name -->`.
pub fn generated_blocks() -> [(&'static str, String); 3] {
    let text = |drawings: Vec<String>| format!("```text\n{}\n```\n", drawings.join("\n\n"));
    [
        ("table", table_as_markdown()),
        ("patterns", text(Pattern::ALL.iter().map(|p| drawing_of_pattern(*p)).collect())),
        ("forks", text(Fork::ALL.iter().map(|f| drawing_of_fork(*f)).collect())),
    ]
}

/// Table 5.1 in Markdown, as the documentation shows it.
fn table_as_markdown() -> String {
    let heads = Parts::ALL.map(|p| format!(" {:<7} |", capitals(p))).concat();
    let mut table = format!("|     |{heads}\n|-----|{}\n", "---------|".repeat(4));
    for (&parts, row) in Parts::ALL.iter().zip(TABLE_5_1) {
        let cells = row.map(|verdict| format!(" {:<7} |", cell(verdict))).concat();
        table += &format!("| {} |{cells}\n", symbols(parts));
    }
    table
}

/// Columns of a drawing's name, and characters of a curve's parts.
const NAME: usize = 25;
const UNENCLOSED: usize = 10;
const ENCLOSED: usize = 6;

/// The names of the patterns, in the order of Figure 5.7.
const NAMES: [&str; 5] = [
    "(a) end to beginning",
    "(b) both whole",
    "(c) whole and end",
    "(d) whole and beginning",
    "(e) whole and middle",
];

/// Figure 5.7: two curves of the first combination with a pattern, both running to the right.
fn drawing_of_pattern(pattern: Pattern) -> String {
    let name = NAMES[pattern as usize].to_owned();
    let combinations = combinations(Verdict::Valid(pattern));
    let Some(&(a, b)) = combinations.first() else { return name };
    let (first, second) = (drawn_curve(a), drawn_curve(b));
    let list = listed(&combinations);
    let below = format!("{:NAME$}b {second}", "");
    format!("{name:<NAME$}a {first}  {list}\n{}", below.trim_end())
}

/// A curve whose overlap is drawn with `=`, and what is around it with a line.
fn drawn_curve(parts: Parts) -> String {
    let outside = |there: bool| if there { "─" } else { " " }.repeat(UNENCLOSED);
    let enclosed = "=".repeat(ENCLOSED);
    outside(parts.begins_unenclosed) + &enclosed + &outside(parts.ends_unenclosed)
}

/// Two curves that come together, part, or both.
fn drawing_of_fork(fork: Fork) -> String {
    let words = ["at the beginning", "at the end", "at both ends"][fork as usize];
    let name = format!("({}) {words}", number(fork));
    let combinations = combinations(Verdict::Fork(fork));
    let begins = combinations.iter().all(|(a, b)| a.begins_unenclosed && b.begins_unenclosed);
    let ends = combinations.iter().all(|(a, b)| a.ends_unenclosed && b.ends_unenclosed);
    let wing = |there: bool, drawn: &str| if there { drawn.to_owned() } else { " ".repeat(6) };
    let (list, space) = (listed(&combinations), " ".repeat(ENCLOSED));
    let upper = wing(begins, "─────╲") + &space + &wing(ends, "╱─────");
    let lower = wing(begins, "─────╱") + &space + &wing(ends, "╲─────");
    let middle = format!("{:NAME$}{:6}{}", "", "", "=".repeat(ENCLOSED));
    let below = format!("{:NAME$}{lower}", "");
    format!("{name:<NAME$}{upper}  {list}\n{middle}\n{}", below.trim_end())
}

/// All combinations with a verdict, in the order of the table.
fn combinations(wanted: Verdict) -> Vec<(Parts, Parts)> {
    table::combinations().filter(|&(a, b)| verdict(a, b) == wanted).collect()
}

fn listed(combinations: &[(Parts, Parts)]) -> String {
    let names = combinations.iter().map(|(a, b)| format!("{} {}", symbols(*a), capitals(*b)));
    let word = if combinations.len() == 1 { "combination: " } else { "combinations:" };
    let names = names.collect::<Vec<_>>().join(", ");
    format!("{} {word} {names}", combinations.len())
}

/// The curves of a drawing: a node for each of its characters.
fn curves(drawing: &str) -> Vec<Curve> {
    let curve = |line: &str| {
        let drawn = line.chars().skip(NAME + 2).take(2 * UNENCLOSED + ENCLOSED).enumerate();
        let drawn = drawn.filter(|(_, c)| *c != ' ');
        let nodes = drawn.map(|(x, _)| Node::at(Point2::new(x as f64, 0.0)));
        Curve::new(nodes.collect(), false).unwrap()
    };
    drawing.lines().map(curve).collect()
}

#[test]
fn the_drawings_show_their_patterns() {
    let tolerance = OverlapTolerance::within(0.1).unwrap();
    for pattern in Pattern::ALL {
        let [a, b] = curves(&drawing_of_pattern(pattern)).try_into().unwrap();
        let found = classify(&a, &b, &tolerance);
        assert_eq!(found.as_slice()[0].verdict, Verdict::Valid(pattern));
        assert_eq!(found.as_slice()[0].on_a.length(), (ENCLOSED - 1) as f64);
    }
}
