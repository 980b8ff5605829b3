//! Tunables of `estimate/`: groups, thinning and the places of nodes.

/// `estimate/groups.rs`
pub mod groups {
    /// Half-width of a group along the curve, in footprints. By hand: less than half a sample, so
    /// that groups lose no detail. Doubled: detail is lost.
    pub const ALONG_FOOTPRINTS: f64 = 0.3;
    /// Half-width across, as a share of the overlap threshold. By hand. Doubled: thin parts lose
    /// accuracy.
    pub const ACROSS_SHARE: f64 = 0.25;
    /// Least cosine between directions within a group (25°). By hand. Doubled: impossible.
    pub const SAME_WAY: f64 = 0.906;
}

/// `estimate/thin.rs`
pub mod thin {
    /// Reach of the rough line along the curve, in footprints and standard deviations. By hand.
    /// Doubled: lines cut bends.
    pub const ROUGH_FOOTPRINTS: f64 = 2.0;
    pub const ROUGH_SIGMAS: f64 = 3.0;
    /// A stand absorbs within this many of its footprints along the curve. By hand: one node per
    /// sample. Doubled: half the nodes, and small details are lost.
    pub const ABSORB_FOOTPRINTS: f64 = 0.7;
    /// A stand absorbs as if it had at least this many footprints of the finest group beside it.
    /// Beyond, it absorbs up to the first group off its line. Measured: with 1, thin things seen
    /// with noise have a 95 % distance 3.7 % larger. Doubled: a noisy room's is 3.7 % larger.
    pub const FINEST_FOOTPRINTS: f64 = 4.0;
    /// And within this share of the overlap threshold across. By hand. Doubled: surfaces beside it
    /// merge.
    pub const ABSORB_SHARE: f64 = 0.6;
}

/// `estimate/parabola`
pub mod parabola {
    /// Half-width of a window's middle, as a share of its reach: a sample there is on neither side.
    /// By hand; larger than rounding. Doubled: nothing changes.
    pub const MIDDLE_SHARE: f64 = 1e-3;
    /// Share of the threshold up to which samples have their whole weight. By hand. Doubled: no
    /// sample is ever weighed less, and outliers pull the fit.
    pub const FULL_TRUST: f64 = 0.5;
    /// Curvature times reach, in radians, beyond which a fit follows an arc no farther. Theory:
    /// directions no longer count as the same there. Doubled: noise is taken for a bend.
    pub const LARGEST_ARC: f64 = 0.9;
}

/// `estimate/place.rs`
pub mod place {
    /// Half-width of the narrowest window, in footprints. By hand: five nodes determine a parabola.
    /// Doubled: legs of a few footprints are smoothed away.
    pub const NARROWEST_FOOTPRINTS: f64 = 2.5;
    /// Factor from one window to the next. By hand. Doubled: windows are either too narrow or too
    /// wide.
    pub const WINDOW_GROWTH: f64 = 1.5;
    /// Windows tried: the widest has 19 footprints. By hand. Doubled: more time, little gain.
    pub const WINDOWS: i32 = 6;
    /// Windows that may be a node's first, whatever gaps lie in them. By hand. Doubled: fine nodes
    /// among coarse ones are placed by ground beyond a gap.
    pub const LAST_FIRST_WINDOW: i32 = 1;
    /// Longest gap in a wider first window, in footprints of the coarser node beside it. Theory:
    /// thinning leaves less. Doubled: as above.
    pub const GAP_FOOTPRINTS: f64 = 2.0;
    /// Largest difference of fits that agree, in its standard deviations. By hand: smaller follows
    /// noise, larger smooths over detail.
    pub const CONFIDENCE: f64 = 2.0;
    /// The same for the one fit that may be off by chance. Theory: one of 20 exceeds two. Doubled:
    /// detail is smoothed away.
    pub const STRAY_CONFIDENCE: f64 = 3.0;
    /// How many of the narrowest windows may be that one. By hand. Doubled: as above.
    pub const STRAY_WINDOWS: usize = 2;
    /// Least variance of the difference of two fits, as a share of the narrower fit's. By hand:
    /// both are estimates. Doubled: fits agree more easily.
    pub const LEAST_VARIANCE_SHARE: f64 = 0.1;
    /// Largest curvature times half-width of a window on a bend, whatever the noise, in radians. By
    /// hand. Doubled: bends are cut.
    pub const LARGEST_WINDOW_TURN: f64 = 0.13;
    /// The same where the fit's error is small against noise. Theory: beyond it directions no
    /// longer count as the same. Doubled: no effect, since the directions exclude the samples.
    pub const LARGEST_NOISY_TURN: f64 = 0.9;
    /// Error of a fit in the middle of a bend, over (curvature × half-width)³ × half-width. Theory:
    /// an evenly sampled parabola makes 0.0107 of an arc's fourth order. Computed: fits that follow
    /// that order leave .29 to .57 of it at the turn below, the more the fewer samples they have;
    /// two fifths are right for 20 samples. Doubled: narrower windows on bends.
    pub const ARC_ERROR: f64 = 0.4 * 0.0107;
    /// Turn from which an arc's sixth order has this error; below, it falls as the turn's square.
    /// Theory. Above, it is .57 to 1.2 at a turn of .75. Measured with a share that grows on: 95 %
    /// distances of 31 sets rise by .3 % in the mean, and those of thin things by 2 %.
    pub const SIXTH_ORDER_TURN: f64 = 0.6;
    /// Largest such error, in standard deviations of the fit. By hand. Doubled: bends are cut
    /// visibly.
    pub const ERROR_SHARE: f64 = 0.5;
    /// Windows for which neighbours are gathered at once, beyond the one that asks. Measured: time
    /// only.
    pub const GATHER_AHEAD: i32 = 2;
    /// Length over which neighbouring fits share their errors, as a share of their half-width h.
    /// Theory: a parabola through 2 h of even samples has 9/4 the variance of their mean, as if 2 h
    /// / (9/4) were averaged. Doubled: the predicted errors of later steps are too large.
    pub const SHARED_WINDOW: f64 = 8.0 / 9.0;
}

/// `estimate/node.rs`
pub mod node {
    /// Longest step of rings and of sides of corners, in footprints: a longer one is a gap. Theory:
    /// thinning leaves up to 1.4, and a single missing pixel is no gap. Doubled: corners are put
    /// into gaps.
    pub const LONGEST_STEP: f64 = 3.0;
    /// Shortest step that a view's shadow forbids, in footprints of the finer node. By hand: at a
    /// rim the coarser one is large. Doubled: bridges from a rim to the ground behind it stay.
    pub const SHADOW_FOOTPRINTS: f64 = 3.0;
    /// Longest straight step between range jumps of any views, in footprints of the finer node. By
    /// hand: with 4, a quarter of the closed curves of a noisy room open at rims. Doubled: a wall
    /// goes on over a quarter of a metre in the shadow of furniture.
    pub const BETWEEN_JUMPS_FOOTPRINTS: f64 = 8.0;
    /// Standard deviation of a fit's slope over that of its place, times the half-width of its
    /// window. Theory: 2 / √3 for a parabola through even samples.
    pub const SLOPE_PER_PLACE: f64 = 1.1547;
    /// Least cosine between a step and both directions if the step continues the curve (37°). By
    /// hand: range jumps of grazing rays lie along one surface. Doubled: impossible.
    pub const STRAIGHT: f64 = 0.8;
}
