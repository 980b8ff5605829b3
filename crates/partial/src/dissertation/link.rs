//! Which contour pixel follows which: adjacent ones first, then across gaps (3.5.1).
//!
//! The source links pixels while it walks. Here every contour pixel's two ends are linked before,
//! closest first, so that a curve is the same whichever of its pixels is found first.

use super::code::{Code, CodeImage, Surface};
use super::label::{Label, LabelImage};
use super::search::{SearchOrder, SearchStep, Side, sides};
use crate::pixel_grid::Grid;
use transect_device::{Neighbour, Pixel};

/// One of the two ends of a contour pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct End {
    /// Number of the contour pixel, in the order of rows and columns.
    pub pixel: usize,
    /// 0 or 1: which of the [`sides`] of its code.
    pub slot: usize,
}

impl End {
    /// The pixel's other end.
    pub fn opposite(self) -> Self {
        Self { slot: 1 - self.slot, ..self }
    }
}

/// The link from an end to the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Link {
    /// The end on which the next pixel is entered.
    pub to: End,
    /// Whether pixels are missing in between.
    pub bridged: bool,
}

/// The contour pixels of a plane.
#[derive(Debug)]
pub(super) struct Contour<'a> {
    pub grid: Grid,
    pub labels: &'a LabelImage,
    pub codes: &'a CodeImage,
    pub surface: &'a Surface<'a>,
    /// Contour pixels in the order of rows and columns.
    pub pixels: Vec<Pixel>,
}

impl<'a> Contour<'a> {
    pub fn new(
        grid: Grid,
        labels: &'a LabelImage,
        codes: &'a CodeImage,
        surface: &'a Surface<'a>,
    ) -> Self {
        let pixels = grid.pixels().filter(|p| codes.get(*p) != Code::NONE).collect();
        Self { grid, labels, codes, surface, pixels }
    }

    pub fn code(&self, pixel: usize) -> Code {
        self.pixels.get(pixel).map_or(Code::NONE, |p| self.codes.get(*p))
    }

    pub fn side(&self, end: End) -> Side {
        sides(self.code(end.pixel).number())[end.slot]
    }

    /// Number of a contour pixel.
    fn number(&self, p: Pixel) -> Option<usize> {
        self.pixels.binary_search(&p).ok()
    }

    /// Whether the high pixel is on the left, seen with rows running down, when the curve leaves
    /// through an end.
    pub fn high_on_left(&self, end: End) -> bool {
        let (p, side) = (self.pixels[end.pixel], self.side(end));
        let left_is_this_pixel = matches!(side, Side::West | Side::South);
        let this_is_high = self.labels.get(p) == Some(Label::High);
        // Both pixels of a border have labels, and different ones.
        left_is_this_pixel == this_is_high
    }

    /// Links all adjacent ends.
    pub fn link_adjacent(&self, order: &SearchOrder) -> Links {
        let mut links = Links { links: vec![[None; 2]; self.pixels.len()] };
        for pixel in 0..self.pixels.len() {
            for slot in 0..2 {
                let from = End { pixel, slot };
                if links.of(from).is_none()
                    && let Some(to) = self.adjacent(from, order, &links)
                {
                    links.join(from, to, false);
                }
            }
        }
        links
    }

    fn adjacent(&self, from: End, order: &SearchOrder, links: &Links) -> Option<End> {
        let steps = order.of(self.code(from.pixel).number()).iter();
        let mut found = steps.filter(|s| s.adjacent).filter_map(|s| self.reach(from, s));
        found.find(|to| links.of(*to).is_none() && self.same_surface(from, *to))
    }

    /// The end that a step leads to: its code is the expected one, and high stays on its side.
    pub fn reach(&self, from: End, step: &SearchStep) -> Option<End> {
        if self.side(from) != step.leaves {
            return None;
        }
        let p = self.grid.step(self.pixels[from.pixel], step.rows, step.cols)?;
        if self.codes.get(p).number() != step.expected {
            return None;
        }
        let slot = sides(step.expected).iter().position(|s| *s == step.enters)?;
        let to = End { pixel: self.number(p)?, slot };
        (self.high_on_left(from) != self.high_on_left(to)).then_some(to)
    }

    /// Whether a curve may pass a cell from border to opposite border: not if both pairs beside it
    /// are range jumps, since then the borders are of two surfaces.
    fn same_surface(&self, from: End, to: End) -> bool {
        let (a, b) = (self.pixels[from.pixel], self.pixels[to.pixel]);
        let (side, border) = (self.side(from), self.side(from).border());
        if border != self.side(to).border() {
            // Borders around a corner share its pixel.
            return true;
        }
        let (later, across) = match side {
            Side::East => (b, Neighbour::Left),
            Side::West => (a, Neighbour::Left),
            Side::South => (b, Neighbour::Up),
            Side::North => (a, Neighbour::Up),
        };
        let other = self.grid.before(later, border);
        self.surface.joined(later, across)
            || other.is_some_and(|other| self.surface.joined(other, across))
    }
}

/// The links of both ends of every contour pixel.
#[derive(Debug, Clone)]
pub(super) struct Links {
    links: Vec<[Option<Link>; 2]>,
}

impl Links {
    pub fn of(&self, end: End) -> Option<Link> {
        self.links.get(end.pixel).and_then(|l| l[end.slot])
    }

    /// Joins two ends, both ways.
    pub fn join(&mut self, a: End, b: End, bridged: bool) {
        for (from, to) in [(a, b), (b, a)] {
            if let Some(links) = self.links.get_mut(from.pixel) {
                links[from.slot] = Some(Link { to, bridged });
            }
        }
    }

    /// Ends that nothing follows.
    pub fn open_ends(&self) -> Vec<End> {
        let ends = (0..self.links.len()).flat_map(|pixel| [0, 1].map(|slot| End { pixel, slot }));
        ends.filter(|e| self.of(*e).is_none()).collect()
    }
}
