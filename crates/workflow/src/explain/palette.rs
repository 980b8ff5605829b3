//! The colours of the figures, after Okabe and Ito: readable for the colour-blind, too.

/// A pixel, or a place, over the plane.
pub const HIGH: &str = "#f6d9a8";
/// A pixel below the plane.
pub const LOW: &str = "#cfe3f2";
/// A missing pixel.
pub const MISSING: &str = "#bdbdbd";
/// Results of a step.
pub const FOUND: &str = "#c2410c";
/// Refusals of a step, and ends.
pub const REFUSED: &str = "#b5179e";
/// Lines of the drawing's own frame.
pub const FRAME: &str = "#222222";
/// The state before a step.
pub const FORMER: &str = "#8a8a8a";
/// The first curve of a pair, and the second. Source: blue and vermilion of Okabe and Ito (2008),
/// which the colour-blind tell apart.
pub const PAIR: [&str; 2] = ["#0072b2", "#d55e00"];
/// The result of a pair.
pub const RESULT: &str = "#00785a";
/// Views, and curves that are to be told apart. Chosen by hand: dark on white;
/// the first two are those of a pair.
pub const MANY: [&str; 8] =
    ["#0072b2", "#d55e00", "#00785a", "#b5179e", "#7a5c00", "#4361ee", "#9b2226", "#444444"];

/// The colour of a number.
pub fn of_many(number: usize) -> &'static str {
    MANY[number % MANY.len()]
}

/// Red, green and blue of a colour of this file.
pub fn rgb(colour: &str) -> [u8; 3] {
    let part = |at: usize| {
        colour.get(at..at + 2).and_then(|hex| u8::from_str_radix(hex, 16).ok()).unwrap_or(0)
    };
    [part(1), part(3), part(5)]
}
