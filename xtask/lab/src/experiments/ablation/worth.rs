//! The worth of a step, from the figures with and without it.

use super::super::lab::Lab;
use crate::failure::Failure;
use crate::statistics::median;
use crate::table::{digits, line};
use std::collections::BTreeMap;
use transect::evaluate::Accuracy;

/// The figures of a set.
#[derive(Debug, Clone, Copy)]
pub struct Figures {
    median: f64,
    p95: f64,
    completeness: f64,
    closed: f64,
    open: f64,
    crossings: f64,
    pub seconds: f64,
}

/// Figures of a step: median, p95, completeness, loops, crossings, time.
const COLUMNS: usize = 6;

impl Figures {
    /// The means of some evaluations of one set.
    pub fn new(accuracies: &[Accuracy], crossings: usize, seconds: f64) -> Self {
        let mean = |f: &dyn Fn(&Accuracy) -> f64| {
            accuracies.iter().map(f).sum::<f64>() / accuracies.len() as f64
        };
        Self {
            median: mean(&|a| a.median.unwrap_or(f64::NAN)),
            p95: mean(&|a| a.p95.unwrap_or(f64::NAN)),
            completeness: mean(&|a| a.completeness.unwrap_or(f64::NAN)),
            closed: mean(&|a| a.closed as f64),
            open: mean(&|a| a.open as f64),
            crossings: crossings as f64 / accuracies.len() as f64,
            seconds,
        }
    }

    /// By how much figures without a step are worse, in per cent, by column.
    fn worse(&self, without: &Self) -> [f64; COLUMNS] {
        let more = |of: f64, than: f64| if than > 0.0 { 100.0 * (of / than - 1.0) } else { 0.0 };
        let curves = (self.closed + self.open).max(1.0);
        [
            more(without.median, self.median),
            more(without.p95, self.p95),
            -more(without.completeness, self.completeness),
            100.0 * (self.closed - without.closed) / curves,
            100.0 * (without.crossings - self.crossings) / curves,
            more(without.seconds, self.seconds),
        ]
    }

    /// The cells of a set, without its time.
    fn line(&self, set: &str) -> Vec<String> {
        let complete = format!("{:.2} %", 100.0 * self.completeness);
        let counts = [self.closed, self.open, self.crossings].map(|x| format!("{x:.0}"));
        let lengths = [self.median, self.p95].map(digits);
        line(set, lengths.into_iter().chain([complete]).chain(counts))
    }
}

/// The worth of all steps on all sets.
#[derive(Debug, Default)]
pub struct Worth {
    full: BTreeMap<String, Figures>,
    order: Vec<&'static str>,
    sets: Vec<String>,
    changes: BTreeMap<(&'static str, String), [f64; COLUMNS]>,
    /// The figures of sets that change without the step [`SETTLE`].
    settled: Vec<(String, Figures)>,
}

/// The step that averages the surfaces of views which differ by more than a footprint.
const SETTLE: &str = "settle";

impl Worth {
    pub fn add_full(&mut self, set: &str, figures: Figures) {
        self.sets.push(set.to_owned());
        self.full.insert(set.to_owned(), figures);
    }

    pub fn add(&mut self, set: &str, step: &'static str, without: Figures) {
        if !self.order.contains(&step) {
            self.order.push(step);
        }
        if let Some(full) = self.full.get(set) {
            let worse = full.worse(&without);
            if step == SETTLE && worse[..2] != [0.0; 2] {
                self.settled.push((set.to_owned(), without));
            }
            let shown = worse.map(|w| format!("{w:+.2}")).join("\t");
            eprintln!("{set}\t{step}\t{shown}\topen {:+.0}", without.open - full.open);
            self.changes.insert((step, set.to_owned()), worse);
        }
    }

    /// Prints the figures with all steps, what each step is worth, and the times of both.
    pub fn print(&self, lab: &Lab) -> Result<(), Failure> {
        let heads = "set | median | p95 | completeness | loops | open | crossings";
        let full: Vec<_> =
            self.sets.iter().filter_map(|set| Some((set, self.full.get(set)?))).collect();
        lab.table("sets", heads, full.iter().map(|(set, f)| f.line(set)))?;
        let settled = self.settled.iter().filter_map(|(set, without)| {
            let with = self.full.get(set)?;
            Some([
                without.line(&format!("{set}, as it is")),
                with.line(&format!("{set}, averaged")),
            ])
        });
        lab.table(SETTLE, heads, settled.flatten())?;
        let mut lines: Vec<_> = self.order.iter().map(|step| self.line(step)).collect();
        let of_sets =
            full.iter().map(|(set, f)| vec![(*set).clone(), format!("{:.3} s", f.seconds)]);
        let of_steps = lines.iter_mut().map(|line| {
            let time = line.pop().unwrap_or_default();
            vec![line[0].clone(), format!("{time} %")]
        });
        let times: Vec<_> = of_sets.chain(of_steps).collect();
        lab.table("steps", "step | median | p95 | completeness | loops | crossings", lines)?;
        lab.times("set, or step left out | time", times)
    }

    fn line(&self, step: &'static str) -> Vec<String> {
        let cell = |column: usize| {
            let changes = || {
                let of = |set: &String| {
                    self.changes.get(&(step, set.clone())).map(|c| (c[column], set.clone()))
                };
                self.sets.iter().filter_map(of)
            };
            let most = changes().max_by(|a, b| a.0.total_cmp(&b.0));
            if column + 1 == COLUMNS {
                // Times scatter: their median over the sets says more than the largest.
                let times: Vec<f64> = changes().map(|c| c.0).collect();
                return format!("{:+.0}", median(&times));
            }
            let least = changes().map(|c| c.0).min_by(f64::total_cmp).unwrap_or(0.0);
            match most {
                Some((gain, set)) if gain >= 0.05 => format!("{gain:+.1} {set}; {least:+.1}"),
                _ => format!("0; {least:+.1}"),
            }
        };
        line(step, (0..COLUMNS).map(cell))
    }
}
