//! All tunables of consensus, by the file that uses them, in the order in which a node meets them.
//!
//! Each says its meaning, unit and source, and what happens when it is doubled. "By hand": chosen
//! on simulated sets and the bunny by `cargo xtask experiments ablation`. Lengths are in
//! footprints (a view's sample spacing) or standard deviations. Numbers of a formula stand beside
//! it.

/// `measure/observations.rs`
pub(super) mod observations {
    /// Distance from an open end at which a node has its full weight, in footprints. By hand: real
    /// scanners overshoot silhouettes by a few pixels. Doubled: clean scans lose a little accuracy.
    pub const FULL_WEIGHT_FOOTPRINTS: f64 = 8.0;
    /// Weight factor of a node at an open end. By hand: enough to stand where no other view
    /// measured. Doubled: overshooting ends pull the curve a little more.
    pub const LEAST_TAPER: f64 = 0.02;
    /// Arc on each side of a node that gives its direction, in footprints and in standard
    /// deviations. By hand: noise turns shorter arcs. Doubled: directions lag behind bends and
    /// small legs merge.
    pub const TANGENT_FOOTPRINTS: f64 = 2.5;
    pub const TANGENT_SIGMAS: f64 = 3.0;
    /// Least and largest sampling error of a node, in footprints. By hand: the least keeps
    /// noise-free data finite; at sharp bends roughness is no error of sampling. Doubled: less
    /// weight on bends.
    pub const SAMPLING_SHARES: [f64; 2] = [0.002, 0.06];
    /// Smallest stated footprint that is believed, as a share of the mean distance between nodes.
    /// By hand; any small number will do. Doubled: nothing changes.
    pub const LEAST_FOOTPRINT: f64 = 1e-3;
}

/// `measure/spread.rs`
pub(super) mod spread {
    /// Every such node is compared with another view: neighbours are correlated. By hand. Doubled:
    /// half the samples, which matters on small planes.
    pub const SAMPLE_EVERY: usize = 20;
    /// Samples of a plane at least: with fewer, the median is uncertain by more than 10 %. Theory:
    /// the median of n normal errors has a relative error of about 1.25 / √n. Doubled: more time.
    pub const MIN_SAMPLES: usize = 300;
    /// Samples of a large plane: the median is then good to a few per cent. Theory as above.
    /// Doubled: the spread takes twice its 5 % of the time.
    pub const WANTED_SAMPLES: usize = 500;
    /// Pairs that make a spread at least. By hand. Doubled: views that barely overlap count as one.
    pub const MIN_PAIRS: usize = 8;
    /// Usual search distance for another view, in footprints and standard deviations of the node.
    /// By hand: wider than the poses of scanners err. Doubled: neighbouring surfaces enter the
    /// sample.
    pub const SEARCH_FOOTPRINTS: f64 = 4.0;
    pub const SEARCH_SIGMAS: f64 = 6.0;
    /// Share of the search distance that is searched first. By hand: saves time where views agree.
    /// Doubled: saves nothing.
    pub const NEARBY_SHARE: f64 = 0.4;
    /// Factor from one search distance to the next. By hand. Doubled: the spread of depth cameras
    /// is taken from distances at which other surfaces lie.
    pub const SHARE_GROWTH: f64 = 1.5;
    /// Share of the search distance from which no wider one is tried. By hand: depth cameras with
    /// poses of their own differ by up to 4 footprints, which 4.5 times this share holds. Doubled:
    /// other surfaces widen the spread of the red kitchen, and the share of its halves within 2 cm
    /// falls by 0.5 %.
    pub const WIDEST_SHARE: f64 = 5.0;
    /// Growth of the spread over that of the search from which other surfaces make it. Theory:
    /// evenly distributed distances have 1. Measured: 0.5 at most on depth cameras. Doubled: it
    /// never counts as made by other surfaces.
    pub const EVEN_GROWTH: f64 = 0.75;
    /// Spreads that a search must hold to count. Theory: the cut at four spreads must lie inside,
    /// and evenly distributed distances give 2.3 times the distance searched. Doubled: the whole
    /// distance is searched on most planes.
    pub const NEARBY_SPREADS: f64 = 4.5;
    /// Pairs farther apart than this many spreads are of different surfaces. Theory: one normal
    /// error in 16 000 is larger. Doubled: neighbouring surfaces widen the spread.
    pub const CUT_SPREADS: f64 = 4.0;
    /// Median of |x| of a normal x of standard deviation 1. Theory.
    pub const MEDIAN_OF_NORMAL: f64 = 0.6745;
}

/// `measure/view_error.rs`
pub(super) mod view_error {
    /// Variance of the square of a normal error, in squares of its variance. Theory.
    pub const VARIANCE_OF_SQUARE: f64 = 2.0;
    /// Incidences of a sample that differ by less than this, squared and relative, count as one. By
    /// hand; only rounding is smaller. Doubled: nothing changes.
    pub const LEAST_SPREAD: f64 = 1e-9;
    /// How often weights follow from the last estimate. By hand: later rounds change little.
    /// Doubled: nothing but time.
    pub const ROUNDS: usize = 4;
    /// Squared standard deviations beyond which a pair does not count. By hand: three standard
    /// deviations. Doubled: pairs of different surfaces count as errors of views.
    pub const SQUARED_CUT: f64 = 9.0;
    /// Share of a normal error's variance within that cut. Theory.
    pub const VARIANCE_LEFT_BY_CUT: f64 = 0.9733;
}

/// `measure/scale.rs`
pub(super) mod scale {
    /// Least overlap threshold in standard deviations of the node. Theory: one normal error in 16
    /// 000 is larger. Doubled: thin parts of one direction merge.
    pub const LEAST_SIGMAS: f64 = 4.0;
    /// Least overlap threshold in footprints. By hand: curves differ by sampling. Doubled: as
    /// above.
    pub const LEAST_FOOTPRINTS: f64 = 0.35;
}

/// `measure/settle.rs`, `measure/common_line.rs` and `measure/align.rs`
pub(super) mod settle {
    /// Least error of the views, in footprints. Theory: two views then differ by 0.7 footprints;
    /// below, their nodes hardly interleave. Doubled: depth cameras at close range zigzag.
    pub const LEAST_FOOTPRINTS: f64 = 0.5;
    /// Least ratio of the views' errors to the nodes' own. By hand: on one plane of a noisy room
    /// the errors of views seem to be three times the noise by chance; depth cameras have 9 and
    /// more. Doubled: nothing changes.
    pub const LEAST_NOISE_RATIO: f64 = 4.0;
    /// Half-length of a common line, in errors of a view. Measured on `kitchen_kin40_real` and the
    /// red kitchen: from 5 to 8 medians fall by 2 %, turns by a fifth, and small things blur.
    /// Doubled: corners are round.
    pub const ALONG_ERRORS: f64 = 6.0;
    /// Largest distance between beads of one line, in errors of a view. Theory: two views differ by
    /// √2 errors, and one normal difference in 100 000 is larger than 4.42 times that. Measured:
    /// with 5, walls that wrong poses double keep both copies (95 % distance of
    /// `parts_pin12_n01_pose` 7 % larger); with 7, small things merge (tight completeness of
    /// `kitchen_kin40_real` 86.0 instead of 86.4 %). Doubled: surfaces beside each other merge.
    pub const ACROSS_ERRORS: f64 = 6.25;
    /// Half-lengths of wider windows, in those of the narrowest. Measured on `kitchen_kin40_real`
    /// and the red kitchen: medians fall by 8 and 3 %. Doubled: by as much again, but the 95 %
    /// distance of round parts with wrong poses grows by 11 %.
    pub const WIDER_WINDOWS: [f64; 2] = [2.0, 4.0];
    /// Distance between the lines of a wider window and of the narrower ones at which the wider
    /// one does not count, in standard deviations. Theory: one normal error in 400 is larger.
    /// Doubled: bends become flatter.
    pub const WAVE_CUT: f64 = 3.0;
    /// Rounds of alignment. Measured: the first takes out half of the views' differences; between 1
    /// and 4 nothing changes by more than 1 %, but for the median of `parts_pin12_n01_pose`, which
    /// is 3 % larger after two. Doubled: time.
    pub const ALIGN_ROUNDS: usize = 3;
    /// Distance from its line, in errors of a view, at which a bead does not move its view. Theory:
    /// as for other outliers, one normal error in 16 000 is larger. Doubled: other surfaces pull.
    pub const ALIGN_CUT: f64 = 4.0;
    /// Half-lengths of a line that count as one observation of a view's motion: windows beside each
    /// other share the errors of the camera. Measured: between 1 and 16 medians of the kitchen and
    /// the red kitchen change by 3 %, and are best between 4 and 16. Doubled: nothing changes.
    pub const REACHES_PER_OBSERVATION: f64 = 4.0;
    /// Beads along half of a line. Measured: with 3, wide windows round corners by 10 %, and the
    /// 95 % distance of `parts_pin12_n01_pose` grows by 5 %. Doubled: four times the time of common
    /// lines.
    pub const BEADS_PER_REACH: f64 = 5.0;
    /// Smallest cosine between beads that are joined. Measured on `parts_pin12_n01_pose`, whose
    /// parts are round: with 10 degrees its 95 % distance is that of short beads within 1 %. With
    /// 30 degrees it is 5 % larger. Doubled angle: corners get rounder.
    pub const JOINED_COSINE: f64 = 0.985;
    /// Beads that are joined before views are aligned: a motion of the whole view needs no detail.
    /// Measured with 2 instead of 1: medians change by less than 1 %, alignment takes a quarter of
    /// the time. Doubled: lines of short pieces of curve have no slope.
    pub const ALIGN_BEADS: usize = 2;
    /// Rounds of averaging. By hand: the first line passes through beads that have not moved.
    /// Doubled: corners become rounder, while accuracy gains 2 %.
    pub const ROUNDS: usize = 2;
    /// Least variance of the beads' places along a line, in squares of its half-width, for the line
    /// to have a slope. By hand. Doubled: nothing changes.
    pub const LEAST_VARIANCE: f64 = 0.01;
    /// Least variance of a view's distance from a common line, in variances of the view, for the
    /// distance to tell something of the views' errors. Theory: two views that count alike have
    /// half. Doubled: lines of two views do not count.
    pub const LEAST_OFF_VARIANCE: f64 = 0.25;
}

/// `estimate/groups.rs`
pub(super) mod groups {
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
pub(super) mod thin {
    /// Reach of the rough line along the curve, in footprints and standard deviations. By hand.
    /// Doubled: lines cut bends.
    pub const ROUGH_FOOTPRINTS: f64 = 2.0;
    pub const ROUGH_SIGMAS: f64 = 3.0;
    /// A stand absorbs within this many of its footprints along the curve. By hand: one node per
    /// sample. Doubled: half the nodes, and small details are lost.
    pub const ABSORB_FOOTPRINTS: f64 = 0.7;
    /// And within this share of the overlap threshold across. By hand. Doubled: surfaces beside it
    /// merge.
    pub const ABSORB_SHARE: f64 = 0.6;
}

/// `estimate/parabola`
pub(super) mod parabola {
    /// Half-width of a window's middle, as a share of its reach: a sample there is on neither side.
    /// By hand; larger than rounding. Doubled: nothing changes.
    pub const MIDDLE_SHARE: f64 = 1e-3;
    /// Share of the threshold up to which samples have their whole weight. By hand. Doubled: no
    /// sample is ever weighed less, and outliers pull the fit.
    pub const FULL_TRUST: f64 = 0.5;
    /// Curvature times reach, in radians, beyond which a fit follows an arc no farther. Theory:
    /// directions no longer count as the same there. Doubled: noise is taken for a bend.
    pub const LARGEST_TURN: f64 = 0.9;
}

/// `estimate/place.rs`
pub(super) mod place {
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
    pub const LARGEST_TURN: f64 = 0.13;
    /// The same where the fit's error is small against noise. Theory: beyond it directions no
    /// longer count as the same. Doubled: no effect, since the directions exclude the samples.
    pub const LARGEST_NOISY_TURN: f64 = 0.9;
    /// Error of a fit in the middle of a bend, over (curvature × half-width)³ × half-width. Theory:
    /// an evenly sampled parabola makes 0.0107 of an arc's fourth order, and fits that follow that
    /// order leave two fifths at the turn below. Doubled: narrower windows on bends.
    pub const ARC_ERROR: f64 = 0.4 * 0.0107;
    /// Turn from which an arc's sixth order has this error; below, it falls as the turn's square.
    /// Theory.
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
pub(super) mod node {
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
    /// Least cosine between a step and both directions if the step continues the curve (37°). By
    /// hand: range jumps of grazing rays lie along one surface. Doubled: impossible.
    pub const STRAIGHT: f64 = 0.8;
}

/// `connect/link.rs`
pub(super) mod link {
    /// How far ahead a node searches for its successor, in footprints. By hand: thinning leaves up
    /// to 1.4. Doubled: gaps are linked before the views' own curves are asked.
    pub const REACH_FOOTPRINTS: f64 = 3.0;
    /// Least cosine between linked nodes, and between them and the step (60°). By hand. Doubled: no
    /// bend is linked.
    pub const SMALLEST_TURN_COSINE: f64 = 0.5;
    /// The same for units of the views' curves, which also lead round thin tips. By hand.
    pub const BACKWARD: f64 = -0.2;
    /// The same for such units between nodes of one direction. By hand: a step to the side is a
    /// change of layer. Doubled: links between layers disappear with some bends.
    pub const SIDEWAYS: f64 = 0.3;
    /// Factor on the cost of a link that a view's own curve shows. By hand. Doubled: they come
    /// last.
    pub const WITNESSED: f64 = 0.7;
    /// Increase of the cost for a node without support, as a share. By hand: four follows a real
    /// scanner's better views more closely, and loses corners that views saw with few samples.
    pub const DOUBT: f64 = 1.0;
}

/// `connect/chain.rs`
pub(super) mod chain {
    /// Nodes on each side whose chord is a chain's direction at a node. By hand. Doubled: lags at
    /// bends.
    pub const CHORD_NODES: usize = 2;
    /// Nodes whose mean direction is that of an end. By hand. Doubled: lags at bends.
    pub const DIRECTION_NODES: usize = 4;
    /// Longest step of a short chain that several views confirm, in spacings. Theory: one missing
    /// pixel is no gap. Doubled: scraps of two views with a gap between them become curves.
    pub const CONFIRMED_STEP: f64 = 2.0;
    /// Least length of an open chain, in mean standard deviations of its nodes. By hand: noise
    /// leaves shorter ones of surfaces nearly parallel to the plane. Doubled: thin details are
    /// lost.
    pub const DIRECTION_SIGMAS: f64 = 6.0;
    /// Least length of a chain without a node that two views measured, in common lines. Theory:
    /// over less than a line nothing averages the view's error, and it looks like surface.
    /// Measured: the median of the red kitchen's halves falls by 5 %, and `kitchen_kin40_real`
    /// loses 0.2 % of its tight completeness. Doubled: 3 %, and 0.2 % more.
    pub const LONE_LINES: f64 = 1.0;
}

/// `connect/cover.rs`
pub(super) mod cover {
    /// Fewest nodes of a chain; fewer have no direction. Theory. Doubled: legs of few samples are
    /// lost.
    pub const MIN_NODES: usize = 3;
    /// Least length of the rest of a chain that was cut, in footprints, for it to be joined. By
    /// hand. Doubled: gaps stay open.
    pub const REST_FOOTPRINTS: f64 = 2.0;
    /// Longest unit that is searched for beside a node, in footprints: that of a joined gap.
    /// Theory: the longest gap of the join rules. Doubled: more time.
    pub const LONGEST_UNIT_FOOTPRINTS: f64 = 4.0;
}

/// `connect/ends.rs`
pub(super) mod ends {
    /// How two ends may be joined.
    #[derive(Debug, Clone, Copy)]
    pub struct JoinRule {
        /// Longest gap, in local footprints.
        pub gap_footprints: f64,
        /// Least and largest cosine between the directions of the two ends.
        pub cosines: [f64; 2],
        /// Least cosine between the gap and either direction.
        pub backward: f64,
        /// Nodes that may be cut from each end to find where the two come closest.
        pub cut_nodes: usize,
    }

    /// The rules. By hand. Doubled gaps: ends of different surfaces are joined. Doubled cuts: short
    /// chains are eaten up.
    impl JoinRule {
        /// Ends that meet, whatever the turn: they belong together before anything is cut or
        /// bridged. With a wider gap, a small gap round a corner would win over a longer one
        /// straight on.
        pub const MEETING: Self = Self::new(0.7, [-1.0, 1.0], -0.7, 0);
        /// A smooth continuation; ends that pass beside each other are cut until the gap leads
        /// forward.
        pub const SMOOTH: Self = Self::new(4.0, [0.5, 1.0], 0.3, 8);
        /// A sharp bend or a thin tip, where the curve turns back on itself.
        pub const HAIRPIN: Self = Self::new(4.0, [-1.0, 0.5], -0.7, 0);
        /// Ends that overshoot a rim and cross, or pass each other.
        pub const CROSSING: Self = Self::new(2.5, [-1.0, 0.5], -1.0, 10);

        const fn new(
            gap_footprints: f64,
            cosines: [f64; 2],
            backward: f64,
            cut_nodes: usize,
        ) -> Self {
            Self { gap_footprints, cosines, backward, cut_nodes }
        }
    }

    /// Cost of a node that is cut, in its footprints. By hand. Doubled: overshooting ends stay.
    pub const CUT_COST: f64 = 0.3;
    /// Share of the overlap threshold by which gaps may be longer: ends of two views' curves may
    /// lie that far apart sideways. By hand. Doubled: ends of different surfaces are joined.
    pub const THRESHOLD_SHARE: f64 = 0.25;
}

/// `connect/spurs.rs`
pub(super) mod spurs {
    /// Largest distance of a spur from the closed chain, in largest plausible offsets. By hand.
    /// Doubled: thin open parts beside a closed one are lost.
    pub const THRESHOLDS: f64 = 3.0;
    /// Largest mean number of views, and largest mean support, of a spur's nodes. By hand. Doubled:
    /// curves of two views are lost.
    pub const MAX_VIEWS: f64 = 1.5;
    pub const MAX_SUPPORT: f64 = 1.0;
    /// Least share of a spur's nodes beside the closed chain: overshooting ends bend away. By hand.
    pub const BESIDE_SHARE: f64 = 2.0 / 3.0;
}

/// `connect/hooks.rs`
pub(super) mod hooks {
    /// How often hooks are searched for in what is left. By hand. Doubled: nothing changes.
    pub const PASSES: usize = 4;
    /// Fewest nodes of a chain whose hooks are removed: a small ring is all bends. By hand.
    pub const MIN_NODES: usize = 8;
    /// Longest unit that is a hook, in footprints. Theory: thinning keeps neighbours of one curve
    /// farther apart. Doubled: bends lose nodes.
    pub const SHORT_FOOTPRINTS: f64 = 0.5;
}

/// `shape/rings.rs`
pub(super) mod rings {
    /// Highest harmonic that is compared: ellipse, triangle and square have 2, 3 and 4. By hand.
    /// Doubled: small rings have too few nodes to determine them.
    pub const HARMONICS: usize = 4;
    /// Standard deviations by which the harmonics' squares may exceed their expectation. By hand.
    /// Doubled: rounded squares become circles.
    pub const CONFIDENCE: f64 = 3.0;
    /// Largest radius of a ring, in footprints. Theory: on larger rings the narrowest window turns
    /// by less than `place::LARGEST_TURN`, so windows may choose. Doubled: large rings become
    /// circles.
    pub const LARGEST_RADIUS: f64 = 19.0;
    /// Largest turn between neighbouring nodes, in radians. By hand: chords lie 1 % of the radius
    /// inside. Doubled: 4 %.
    pub const LARGEST_TURN: f64 = 0.3;
    /// Steps of the search for the centre. By hand: it converges in three. Doubled: nothing
    /// changes.
    pub const ROUNDS: usize = 5;
}

/// `shape/corners`
pub(super) mod corners {
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
pub(super) mod output {
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
    /// Least cosine between a unit and the directions of its nodes, for a cubic between them (20°).
    /// By hand: at a corner directions do not tell the curve between.
    pub const SMOOTH_COSINE: f64 = 0.94;
    /// Search distance for the end of a view's curve at the end of a fused one, in footprints. By
    /// hand. Doubled: reasons of ends farther away are taken.
    pub const END_FOOTPRINTS: f64 = 4.0;
}
