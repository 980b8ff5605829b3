//! Tunables of `shape/`: rings, corners and the final curves.

/// `shape/rings.rs`
pub mod rings {
    /// Highest harmonic that is compared: ellipse, triangle and square have 2, 3 and 4. By hand.
    /// Doubled: small rings have too few nodes to determine them.
    pub const HARMONICS: usize = 4;
    /// Standard deviations by which the harmonics' squares may exceed their expectation. By hand.
    /// Doubled: rounded squares become circles.
    pub const CONFIDENCE: f64 = 3.0;
    /// Largest radius of a ring, in footprints. Theory: on larger rings the narrowest window turns
    /// by less than `place::LARGEST_WINDOW_TURN`, so windows may choose. Doubled: large rings
    /// become circles.
    pub const LARGEST_RADIUS: f64 = 19.0;
    /// Largest turn between neighbouring nodes, in radians. By hand: chords lie 1 % of the radius
    /// inside. Doubled: 4 %.
    pub const LARGEST_NODE_TURN: f64 = 0.3;
    /// Steps of the search for the centre. By hand: it converges in three. Doubled: nothing
    /// changes.
    pub const ROUNDS: usize = 5;
}

/// `shape/corners`
pub mod corners {
    /// Longest way between two sides, and how far ahead of each they may meet, in footprints. By
    /// hand: smoothing works over several pixels. Doubled: rounded edges become sharp.
    pub const LONGEST_ZONE: f64 = 7.0;
    pub const AHEAD: f64 = 6.0;
    /// How far a side may reach beyond the corner, in footprints. By hand. Doubled: sides cross.
    pub const BEYOND: f64 = 0.5;
    /// Least and largest turn of a corner, in radians (40° and 140°). By hand: a flatter one is a
    /// bend, a sharper one a thin tip, which its nodes describe better than its sides.
    pub const SMALLEST_TURN: f64 = 0.7;
    pub const LARGEST_TURN: f64 = 2.44;
    /// Largest curvature of a side, as a share of that of an arc along both sides, and standard
    /// deviations by which it must be known. Measured on two simulated scenes: 146 corners of 217
    /// and no ring of 236 pass. Doubled: rings of a few footprints become polygons.
    pub const BEND_SHARE: f64 = 0.6;
    pub const BEND_SIGMAS: f64 = 0.5;
    /// How far nodes between the sides may lie off them, in standard deviations, besides the noise
    /// of a pixel. By hand: smoothing over a crease moves a node by no more. Doubled: fillets
    /// become sharp.
    pub const OFF_SIGMAS: f64 = 3.0;
    /// Footprints from the corner within which a view's unit joins samples of both sides, and by
    /// how many footprints that moves nodes. Theory: half a unit, and the height of its chord.
    /// Doubled: as above.
    pub const NEAR: f64 = 0.7;
    pub const SAMPLED: f64 = 0.2;
    /// Largest distance from the corner to the ends of a chord that cuts it off, in footprints.
    /// Theory: a longer unit is a gap. Doubled: gaps become corners.
    pub const CHORD: f64 = 1.5;
    /// Least distance of the curve from the corner, in standard deviations of the corner. By hand.
    /// Doubled: fewer corners of noisy scans become sharp.
    pub const MIN_CUT_SIGMAS: f64 = 1.0;
    /// Footprints from a corner within which nodes of a side move onto it. By hand: the last fits
    /// have neighbours on one hand only. Doubled: nothing known.
    pub const RIM: f64 = 2.5;
    /// Distance that nodes keep from the corner and from each other, in footprints. By hand.
    pub const APART: f64 = 0.4;
    /// Nodes before and after one whose turn shows that a corner may be near. By hand. Doubled:
    /// corners of short sides are missed.
    pub const LOOK_NODES: usize = 4;
    /// Nodes on each side of a turn among which sides are searched for. By hand. Doubled: more
    /// time.
    pub const AROUND_NODES: usize = 16;
    /// Nodes with which a side begins. By hand: two more than a line needs. Doubled: short sides
    /// are missed.
    pub const SEED_NODES: usize = 4;
    /// Longest side, in footprints: farther nodes say little of the corner. By hand. Doubled: bent
    /// sides end before.
    pub const LONGEST_SIDE: f64 = 10.0;
    /// Least cosine between the direction of a side and its nodes' (25°). By hand.
    pub const SAME_SIDE: f64 = 0.906;
    /// Distance of a node on a side, in standard deviations, and in footprints besides. By hand.
    /// Doubled: sides run on into the rounded corner.
    pub const ON_SIGMAS: f64 = 3.0;
    pub const ON_FOOTPRINTS: f64 = 0.02;
    /// Least sine between two sides that meet. By hand; below `SMALLEST_TURN`. Doubled: nothing
    /// changes.
    pub const SMALLEST_SINE: f64 = 0.3;
    /// Longest way round the end of a thin part, in footprints, and most nodes there. By hand.
    /// Doubled: more time.
    pub const LONGEST_WAY: f64 = 12.0;
    pub const MAX_SHORT_NODES: usize = 16;
    /// Largest cosine between sides that face each other (140°). By hand.
    pub const FACING: f64 = -0.766;
    /// Standard deviation of the slant of an end before any node is known, as a slope (17°). By
    /// hand: made things have square ends. Doubled: noise slants ends.
    pub const SLANT: f64 = 0.3;
    /// Largest misfit of a sharp end, over that of the best arc: smoothing alone rounds an end. By
    /// hand. Doubled: round ends become sharp.
    pub const MAX_ROUND_RATIO: f64 = 2.0;
}

/// `shape/output.rs`
pub mod output {
    /// Distance between neighbouring nodes, in footprints, from which the ground between may be a
    /// gap. Theory: thinning leaves up to 1.4. Doubled: gaps of two samples count as measured.
    pub const GAP_FOOTPRINTS: f64 = 1.5;
    /// Distance of a view's unit from the middle of a gap, within which the view measured it, in
    /// footprints, and at least the overlap threshold. Measured on 10 000 random scans: no gap
    /// passes as measured. Doubled: three gaps of those scans pass.
    pub const MEASURED_FOOTPRINTS: f64 = 0.5;
    /// A node goes in between where the chord misses the curve by more than this share of the
    /// standard deviation. By hand. Doubled: chords show.
    pub const CHORD_SHARE: f64 = 0.25;
    /// And by more than this many standard deviations of what the errors of both directions make of
    /// it. Theory: three are rarely chance. Measured: without, coarse nodes beside fine ones bow by
    /// up to 4 mm over half a metre of a room's walls. Doubled: bends of noisy curves show chords.
    pub const SLOPE_SIGMAS: f64 = 3.0;
    /// Least cosine between a unit and the directions of its nodes, for a cubic between them (20°).
    /// By hand: at a corner directions do not tell the curve between.
    pub const SMOOTH_COSINE: f64 = 0.94;
    /// Search distance for the end of a view's curve at the end of a fused one, in footprints. By
    /// hand. Doubled: reasons of ends farther away are taken.
    pub const END_FOOTPRINTS: f64 = 4.0;
}
