//! Tunables of `connect/`: links, chains, ends, spurs and hooks.

/// `connect/link.rs`
pub mod link {
    /// How far ahead a node searches for its successor, in footprints. By hand: thinning leaves up
    /// to 1.4. Doubled: gaps are linked before the views' own curves are asked.
    pub const REACH_FOOTPRINTS: f64 = 3.0;
    /// Least cosine between linked nodes, and between them and the step (60°). By hand. Doubled: no
    /// bend is linked.
    pub const LEAST_COSINE: f64 = 0.5;
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
pub mod chain {
    /// Fewest nodes of a chain; fewer have no direction. Theory. Doubled: legs of few samples are
    /// lost.
    pub const MIN_NODES: usize = 3;
    /// Nodes on each side whose chord is a chain's direction at a node. By hand. Doubled: lags at
    /// bends.
    pub const CHORD_NODES: usize = 2;
    /// Nodes whose mean direction is that of an end. By hand. Doubled: lags at bends.
    pub const DIRECTION_NODES: usize = 4;
    /// Longest step of a short chain that several views confirm, in spacings. Theory: one missing
    /// pixel is no gap. Doubled: scraps of two views with a gap between them become curves.
    pub const CONFIRMED_STEP: f64 = 2.0;
    /// Least length of a chain without a node that two views measured, in lengths of the common
    /// course that the error of its view asks for. Theory: over less than a course nothing averages
    /// the view's error, and it looks like surface. Measured: the median of the red kitchen's
    /// halves falls by 7 %. 12 of the 14 false pieces of `kitchen_kin40_real` go, with 0.4 % of its
    /// tight completeness. With 0.75 two more false pieces stay in another draw of it; with 1.25
    /// the halves gain 0.3 % in median. With the error of a typical view for all, parts seen from
    /// near and far have 21 false pieces instead of 17.
    pub const LONE_COURSES: f64 = 1.0;
}

/// `connect/cover.rs`
pub mod cover {
    /// Least length of the rest of a chain that was cut, in footprints, for it to be joined. By
    /// hand. Doubled: gaps stay open.
    pub const REST_FOOTPRINTS: f64 = 2.0;
    /// Cells of the grid of nodes, in footprints. Theory: the longest gap of the join rules, and
    /// few units are longer. Doubled: more time.
    pub const CELL_FOOTPRINTS: f64 = 4.0;
}

/// `connect/ends.rs`
pub mod ends {
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
    /// Part of the shorter chain that is cut from an end at most: half of one of two chains, a
    /// third of one that is closed, which is cut at both ends. By hand. Doubled: curves that
    /// overshoot by more stay open.
    pub const CUT_PARTS: [usize; 2] = [2, 3];
    /// Fewest nodes of a chain that is closed. By hand: one more than a triangle.
    /// Doubled: loops of few samples stay open.
    pub const LEAST_CLOSED: usize = 4;
    /// Share of the overlap threshold by which gaps may be longer: ends of two views' curves may
    /// lie that far apart sideways. By hand. Doubled: ends of different surfaces are joined.
    pub const THRESHOLD_SHARE: f64 = 0.25;
}

/// `connect/spurs.rs`
pub mod spurs {
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
pub mod hooks {
    /// Fewest nodes of a chain whose hooks are removed: a small ring is all bends. By hand.
    pub const MIN_NODES: usize = 8;
    /// Longest unit that is a hook whatever its noise is, in footprints. Theory: thinning keeps
    /// neighbours of one curve farther apart. Doubled: bends lose nodes.
    pub const SHORT_FOOTPRINTS: f64 = 0.5;
}
