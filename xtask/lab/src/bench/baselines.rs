//! What one pass is compared with: lower bounds, and the dissertation's ways plane by plane.
//!
//! All of it is written for the same vector instructions as one pass, on `f32`, with its tables
//! made in advance and untimed, as are the masks of pairs that belong to one surface.

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, dispatch, f32x8, i32x8};
use transect_device::{LinearForm, SeparableForm, View};
use transect_partial::SectionAxes;
use transect_partial::one_pass::Seen;

/// Tables of a view whose width is a multiple of 64.
pub struct Baselines {
    cols: usize,
    rows: usize,
    level: SeparableForm,
    places: [SeparableForm; 3],
    /// One bit per pixel: its left and its upward pair belong to one surface.
    left: Vec<u64>,
    up: Vec<u64>,
    instructions: Level,
    values: Vec<f32>,
    ranges: Vec<f32>,
    labels: Vec<u64>,
    codes: Vec<u8>,
    points: [Vec<f32>; 3],
    found: Vec<u32>,
    segments: Vec<[[f32; 3]; 2]>,
    /// Change of the level along the sensor's axes.
    gradient: [f32; 3],
    ceilings: Vec<i32>,
}

impl Baselines {
    pub fn new(view: &View, axes: &SectionAxes, seen: &Seen) -> Option<Self> {
        let (frame, size) = (view.frame(), view.image().size());
        let axis =
            |k| LinearForm { gradient: transect_device::Vector3::ith(k, 1.0), constant: 0.0 };
        let place = |k| frame.separable_form(&axis(k));
        let bits = |pairs: &[bool]| {
            let word = |w: &[bool]| w.iter().enumerate().map(|(k, b)| u64::from(*b) << k).sum();
            pairs.chunks(64).map(word).collect::<Vec<u64>>()
        };
        if size.cols % 64 != 0 {
            return None;
        }
        Some(Self {
            cols: size.cols,
            rows: size.rows,
            level: frame.separable_form(axes.level())?,
            places: [place(0)?, place(1)?, place(2)?],
            left: bits(&seen.left),
            up: bits(&seen.up),
            instructions: Level::new(),
            values: (0..size.rows).flat_map(|row| view.image().row(row).to_vec()).collect(),
            ranges: Vec::new(),
            labels: Vec::new(),
            codes: Vec::new(),
            points: Default::default(),
            found: Vec::new(),
            segments: Vec::new(),
            gradient: axes.level().gradient.cast().into(),
            ceilings: Vec::new(),
        })
    }

    /// Reads every value.
    pub fn read(&self) -> f32 {
        dispatch!(self.instructions, simd => read(simd, &self.values))
    }

    /// Reads every value and finds its level.
    pub fn heights(&self) -> f32 {
        dispatch!(self.instructions, simd => self.heights_with(simd))
    }

    /// The same, and rounds it up into a buffer of one row.
    pub fn levels(&mut self) -> i32 {
        self.ceilings.resize(self.cols, 0);
        dispatch!(self.instructions, simd => self.levels_with(simd))
    }

    #[inline(always)]
    fn heights_with<S: Simd>(&self, simd: S) -> f32 {
        let mut sum = f32x8::splat(simd, 0.0);
        let form = &self.level;
        for (row, &[factor, addend]) in self.values.chunks_exact(self.cols).zip(&form.rows) {
            for (value, column) in row.chunks_exact(8).zip(form.columns.chunks_exact(8)) {
                let per_value = f32x8::from_slice(simd, column) * factor + addend;
                sum += f32x8::from_slice(simd, value) * per_value + form.constant;
            }
        }
        sum.as_slice().iter().sum()
    }

    #[inline(always)]
    fn levels_with<S: Simd>(&mut self, simd: S) -> i32 {
        let form = &self.level;
        let mut last = 0;
        for (row, &[factor, addend]) in self.values.chunks_exact(self.cols).zip(&form.rows) {
            let samples = row.chunks_exact(8).zip(form.columns.chunks_exact(8));
            for ((value, column), ceiling) in samples.zip(self.ceilings.chunks_exact_mut(8)) {
                let per_value = f32x8::from_slice(simd, column) * factor + addend;
                let level = f32x8::from_slice(simd, value) * per_value + form.constant;
                let toward_zero: i32x8<S> = level.to_int();
                let below: f32x8<S> = toward_zero.to_float();
                (toward_zero - below.simd_lt(level).to_vector()).store_slice(ceiling);
            }
            last ^= self.ceilings[row.len() / 2];
        }
        last
    }

    /// The dissertation's way (3.4), row by row with nothing stored but one row of labels: for each
    /// plane the range it has at every pixel, the label, the codes, the list of coded pixels. No
    /// points, no linking. Returns how many pixels have a code.
    pub fn fused(&mut self, planes: &[f32]) -> usize {
        dispatch!(self.instructions, simd => self.fused_with(simd, planes))
    }

    #[inline(always)]
    fn fused_with<S: Simd>(&mut self, simd: S, planes: &[f32]) -> usize {
        let words = self.cols / 64;
        let (mut above, mut labels) = (vec![0_u64; words], vec![0_u64; words]);
        let mut count = 0;
        for &plane in planes {
            self.found.clear();
            for i in 0..self.rows {
                let row = &self.values[i * self.cols..][..self.cols];
                for (w, (label, values)) in labels.iter_mut().zip(row.chunks_exact(64)).enumerate()
                {
                    let columns = &self.level.columns[64 * w..][..64];
                    *label = self.labels_of(simd, i, plane, values, columns);
                }
                let at = i * words;
                let (left, up) = (&self.left[at..][..words], &self.up[at..][..words]);
                collect(i * self.cols, (&above, &labels), (left, up), &mut self.found);
                std::mem::swap(&mut above, &mut labels);
            }
            count += self.found.len();
        }
        count
    }

    /// Labels of 64 pixels: whether the plane comes before the surface.
    #[inline(always)]
    fn labels_of<S: Simd>(
        &self,
        simd: S,
        i: usize,
        plane: f32,
        values: &[f32],
        columns: &[f32],
    ) -> u64 {
        let [factor, addend] = self.level.rows[i];
        let offset = f32x8::splat(simd, plane - self.level.constant);
        let zero = f32x8::splat(simd, 0.0);
        let mut labels = 0;
        for (k, (value, column)) in values.chunks_exact(8).zip(columns.chunks_exact(8)).enumerate()
        {
            let range = offset / (f32x8::from_slice(simd, column) * factor + addend);
            let seen = range.simd_lt(f32x8::from_slice(simd, value)) & range.simd_ge(zero);
            labels |= seen.to_bitmask() << (8 * k);
        }
        labels
    }

    /// The same with the plane range image, the label image and the code image stored.
    pub fn stored(&mut self, planes: &[f32]) -> usize {
        dispatch!(self.instructions, simd => self.stored_with(simd, planes))
    }

    #[inline(always)]
    fn stored_with<S: Simd>(&mut self, simd: S, planes: &[f32]) -> usize {
        let (words, pixels) = (self.cols / 64, self.rows * self.cols);
        let (mut ranges, mut labels) =
            (std::mem::take(&mut self.ranges), std::mem::take(&mut self.labels));
        ranges.resize(pixels, 0.0);
        labels.resize(self.rows * words, 0);
        self.codes.resize(pixels, 0);
        let mut count = 0;
        for &plane in planes {
            for (i, ranges) in ranges.chunks_exact_mut(self.cols).enumerate() {
                let offset = f32x8::splat(simd, plane - self.level.constant);
                let [factor, addend] = self.level.rows[i];
                for (range, column) in
                    ranges.chunks_exact_mut(8).zip(self.level.columns.chunks_exact(8))
                {
                    (offset / (f32x8::from_slice(simd, column) * factor + addend))
                        .store_slice(range);
                }
            }
            let zero = f32x8::splat(simd, 0.0);
            for (label, (range, value)) in
                labels.iter_mut().zip(ranges.chunks_exact(64).zip(self.values.chunks_exact(64)))
            {
                *label = 0;
                for (k, (range, value)) in
                    range.chunks_exact(8).zip(value.chunks_exact(8)).enumerate()
                {
                    let range = f32x8::from_slice(simd, range);
                    let seen = range.simd_lt(f32x8::from_slice(simd, value)) & range.simd_ge(zero);
                    *label |= seen.to_bitmask() << (8 * k);
                }
            }
            self.found.clear();
            for (i, codes) in self.codes.chunks_exact_mut(self.cols).enumerate() {
                let here = &labels[i * words..][..words];
                let above = &labels[i.saturating_sub(1) * words..][..words];
                let (left, up) = (&self.left[i * words..][..words], &self.up[i * words..][..words]);
                let mut before = 0;
                for (w, codes) in codes.chunks_exact_mut(64).enumerate() {
                    let code2 = (here[w] ^ (here[w] << 1 | before)) & left[w];
                    let code1 = (here[w] ^ above[w]) & up[w];
                    before = here[w] >> 63;
                    for (k, code) in codes.iter_mut().enumerate() {
                        *code = (code1 >> k & 1) as u8 | ((code2 >> k & 1) as u8) << 1;
                    }
                }
                collect(i * self.cols, (above, here), (left, up), &mut self.found);
            }
            count += self.found.len();
        }
        (self.ranges, self.labels) = (ranges, labels);
        count
    }

    /// The Cartesian way (Appendix A), once every sample is a point: for each plane the side of
    /// every point, and the segments of every cell that the plane cuts, as points. Not linked.
    pub fn cartesian(&mut self, planes: &[f32]) -> usize {
        if self.points[0].is_empty() {
            self.points_of_all();
        }
        let mut count = 0;
        for &plane in planes {
            count += dispatch!(self.instructions, simd => self.cartesian_plane(simd, plane));
        }
        count
    }

    /// The points, made once for all planes.
    pub fn points_of_all(&mut self) -> usize {
        dispatch!(self.instructions, simd => self.points_with(simd))
    }

    #[inline(always)]
    fn points_with<S: Simd>(&mut self, simd: S) -> usize {
        for (points, form) in self.points.iter_mut().zip(&self.places) {
            points.resize(self.rows * self.cols, 0.0);
            for i in 0..self.rows {
                let [factor, addend] = form.rows[i];
                let row = self.values[i * self.cols..][..self.cols].chunks_exact(8);
                let out = points[i * self.cols..][..self.cols].chunks_exact_mut(8);
                for ((value, column), point) in row.zip(form.columns.chunks_exact(8)).zip(out) {
                    let per_value = f32x8::from_slice(simd, column) * factor + addend;
                    (f32x8::from_slice(simd, value) * per_value).store_slice(point);
                }
            }
        }
        0
    }

    #[inline(always)]
    fn cartesian_plane<S: Simd>(&mut self, simd: S, plane: f32) -> usize {
        let normal = self.gradient;
        let words = self.cols / 64;
        let (mut above, mut labels) = (vec![0_u64; words], vec![0_u64; words]);
        self.segments.clear();
        for i in 0..self.rows {
            for (w, label) in labels.iter_mut().enumerate() {
                *label = 0;
                for k in 0..8 {
                    let at = i * self.cols + 64 * w + 8 * k;
                    let of = |axis: usize| f32x8::from_slice(simd, &self.points[axis][at..at + 8]);
                    let height = of(0) * normal[0] + of(1) * normal[1] + of(2) * normal[2];
                    let high = height.simd_gt(plane - self.level.constant);
                    *label |= high.to_bitmask() << (8 * k);
                }
            }
            if i > 0 {
                self.cut_cells(i, plane, &above, &labels);
            }
            std::mem::swap(&mut above, &mut labels);
        }
        self.segments.len()
    }

    /// The segments of the cells of row `i` that a plane cuts.
    fn cut_cells(&mut self, i: usize, plane: f32, above: &[u64], labels: &[u64]) {
        let words = self.cols / 64;
        let (mut up_before, mut high_before) = (0, [0; 2]);
        for w in 0..words {
            let at = i * words + w;
            let (top, bottom, right) = (self.left[at - words], self.left[at], self.up[at]);
            let whole = top & bottom & right & (right << 1 | up_before);
            let corners = [
                above[w] << 1 | high_before[0],
                above[w],
                labels[w] << 1 | high_before[1],
                labels[w],
            ];
            (up_before, high_before) = (right >> 63, [above[w] >> 63, labels[w] >> 63]);
            let all = corners.iter().fold(u64::MAX, |all, c| all & c);
            let any = corners.iter().fold(0, |any, c| any | c);
            let mut cut = any & !all & whole;
            while cut != 0 {
                let j = 64 * w + cut.trailing_zeros() as usize;
                cut &= cut - 1;
                self.cut_cell(i * self.cols + j, plane);
            }
        }
    }

    /// The segments of one cell: between the crossings of its sides.
    fn cut_cell(&mut self, at: usize, plane: f32) {
        let up = at - self.cols;
        let ring = [up - 1, up, at, at - 1].map(|k| {
            let p = [self.points[0][k], self.points[1][k], self.points[2][k]];
            (p, self.height(p) - plane)
        });
        let mut crossings = [[0.0_f32; 3]; 4];
        let mut count = 0;
        for k in 0..4 {
            let ((p, a), (q, b)) = (ring[k], ring[(k + 1) % 4]);
            if (a > 0.0) != (b > 0.0) {
                let t = a / (a - b);
                crossings[count] = [0, 1, 2].map(|axis| p[axis] + t * (q[axis] - p[axis]));
                count += 1;
            }
        }
        for pair in crossings[..count].chunks_exact(2) {
            self.segments.push([pair[0], pair[1]]);
        }
    }

    #[inline(always)]
    fn height(&self, p: [f32; 3]) -> f32 {
        let [x, y, z] = self.gradient;
        p[0] * x + p[1] * y + p[2] * z + self.level.constant
    }
}

#[inline(always)]
fn read<S: Simd>(simd: S, values: &[f32]) -> f32 {
    let mut sums = [f32x8::splat(simd, 0.0); 4];
    for block in values.chunks_exact(32) {
        for (sum, part) in sums.iter_mut().zip(block.chunks_exact(8)) {
            *sum += f32x8::from_slice(simd, part);
        }
    }
    sums.iter().flat_map(|sum| sum.as_slice().to_vec()).sum()
}

/// Appends the pixels of a row that have a code.
#[inline(always)]
fn collect(
    first: usize,
    (above, here): (&[u64], &[u64]),
    (left, up): (&[u64], &[u64]),
    found: &mut Vec<u32>,
) {
    let mut before = 0;
    for w in 0..here.len() {
        let code2 = (here[w] ^ (here[w] << 1 | before)) & left[w];
        let code1 = (here[w] ^ above[w]) & up[w];
        before = here[w] >> 63;
        let mut coded = code1 | code2;
        while coded != 0 {
            found.push((first + 64 * w) as u32 + coded.trailing_zeros());
            coded &= coded - 1;
        }
    }
}
