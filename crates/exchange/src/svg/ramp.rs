//! Colours by station, and their legend.

use super::canvas;
use super::options::OverviewOptions;
use super::ruler::{round_up, tidy};
use std::io::{self, Write};
use transect_geometry::LengthUnit;

/// A colour by red, green and blue from 0 to 255.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Colour([f64; 3]);

/// Viridis (van der Walt and Smith, 2015) without its light end, which would vanish on white: equal
/// steps look equally large, also to the colour-blind.
const RAMP: [[f64; 3]; 8] = [
    [68.0, 1.0, 84.0],
    [70.0, 50.0, 127.0],
    [54.0, 92.0, 141.0],
    [39.0, 127.0, 142.0],
    [31.0, 161.0, 135.0],
    [74.0, 194.0, 109.0],
    [122.0, 209.0, 81.0],
    [159.0, 201.0, 40.0],
];

impl Colour {
    /// The colour at a place of the ramp, from 0 to 1.
    pub(super) fn ramp(at: f64) -> Self {
        let at = at.clamp(0.0, 1.0) * (RAMP.len() - 1) as f64;
        let below = (at.floor() as usize).min(RAMP.len() - 2);
        let pair = RAMP.get(below).zip(RAMP.get(below + 1));
        let (low, high) = pair.unwrap_or((&[0.0; 3], &[0.0; 3]));
        let share = at - below as f64;
        let mut mixed = [0.0; 3];
        for (m, (a, b)) in mixed.iter_mut().zip(low.iter().zip(high)) {
            *m = a + (b - a) * share;
        }
        Self(mixed)
    }

    /// Red, green and blue in whole steps.
    pub(super) fn bytes(self) -> [u8; 3] {
        self.0.map(|c| c.round() as u8)
    }

    pub(super) fn lightened(self, share: f64) -> Self {
        Self(self.0.map(|c| c + (255.0 - c) * share))
    }
}

impl std::fmt::Display for Colour {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [r, g, b] = self.bytes();
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// The first and the last station of a picture. The label of a single one is rounded to `step`.
pub(super) struct Stations {
    pub(super) first: f64,
    pub(super) last: f64,
    pub(super) step: f64,
}

impl Stations {
    /// The place of a station between the first (0) and the last (1).
    pub(super) fn share(&self, station: f64) -> f64 {
        if self.last > self.first { (station - self.first) / (self.last - self.first) } else { 0.0 }
    }

    /// Round stations between the first and the last one, two to six of them, with their labels.
    fn labels(&self) -> impl Iterator<Item = (f64, String)> {
        let &Self { first, last, step } = self;
        let is_range = last > first;
        let between = if is_range { round_up((last - first) / 5.0) } else { step };
        // Rounding may put an end slightly beyond a round number.
        let (low, high) = ((first / between - 1e-9).ceil(), (last / between + 1e-9).floor());
        let round = (low as i64..=high as i64).filter(move |_| is_range);
        let stations = round.map(move |k| k as f64 * between);
        let only = (!is_range).then_some(first);
        stations.chain(only).map(move |station| (station, tidy(station, between)))
    }
}

/// The colours by station, at the right edge.
pub(super) fn write_ramp(
    stations: &Stations,
    unit: LengthUnit,
    options: &OverviewOptions,
    out: &mut dyn Write,
) -> io::Result<()> {
    let (x, top, height) = (options.width - 150.0, 140.0, options.height - 280.0);
    writeln!(out, "<linearGradient id=\"r\" x1=\"0\" y1=\"1\" x2=\"0\" y2=\"0\">")?;
    for stop in 0..RAMP.len() {
        let at = stop as f64 / (RAMP.len() - 1) as f64;
        writeln!(out, "<stop offset=\"{at:.4}\" stop-color=\"{}\"/>", Colour::ramp(at))?;
    }
    writeln!(
        out,
        "</linearGradient><rect x=\"{x}\" y=\"{top}\" width=\"18\" height=\"{height}\" \
         fill=\"url(#r)\"/>"
    )?;
    canvas::text(out, (x, top - 16.0), "", &format!("station [{unit}]"))?;
    for (station, label) in stations.labels() {
        let y = top + height * (1.0 - stations.share(station));
        canvas::line(out, (x + 18.0, y), (x + 24.0, y), "stroke=\"#222\"")?;
        canvas::text(out, (x + 30.0, y + 5.5), "", &label)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_numbers() {
        let labels = |first: f64, last: f64| -> Vec<String> {
            Stations { first, last, step: 0.001 }.labels().map(|(_, label)| label).collect()
        };
        assert_eq!(labels(0.0537, 2.7837), ["1", "2"]);
        assert_eq!(labels(0.0537, 2.2), ["0.5", "1", "1.5", "2"]);
        assert_eq!(labels(-40.0, 60.0), ["\u{2212}40", "\u{2212}20", "0", "20", "40", "60"]);
        assert_eq!(labels(0.0537, 0.0537), ["0.054"]);
    }
}
