//! Tunables of `measure/`: weights, spread, errors of views and common courses.

/// `measure/observations.rs`
pub mod observations {
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
pub mod spread {
    /// Least distance of nodes that are compared with another view, in nodes: neighbours are
    /// correlated. By hand. It counts where planes have 6 000 to 10 000 nodes; others have
    /// [`MIN_SAMPLES`] or [`WANTED_SAMPLES`]. Doubled: planes of up to 20 000 nodes have fewer.
    pub const SAMPLE_EVERY: usize = 20;
    /// Samples of a plane at least. Theory: the median of n absolute normal errors has a relative
    /// standard deviation of 1.17 / √n, which is 7 % here. Doubled: more time.
    pub const MIN_SAMPLES: usize = 300;
    /// Samples of a large plane: the median is then good to 5 %. Theory as above.
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
    /// Share of the search distance from which no wider one is tried. By hand: the search ends at 5
    /// × [`SEARCH_FOOTPRINTS`] = 20 footprints, which holds [`NEARBY_SPREADS`] (4.5) times the
    /// largest spread seen, 4 footprints. Doubled: other surfaces widen the spread of the red
    /// kitchen, and the share of its halves within 2 cm falls by 0.5 %.
    pub const WIDEST_SHARE: f64 = 5.0;
    /// Growth of the spread over that of the search from which other surfaces make it. Theory:
    /// evenly distributed distances have 1. Measured: 0.5 at most on depth cameras. Doubled: it
    /// never counts as made by other surfaces.
    pub const EVEN_GROWTH: f64 = 0.75;
    /// Spreads that a search must hold to count. Theory: they are 3.2 standard deviations of the
    /// distance between two views, which one distance in 700 exceeds. If distances are evenly
    /// distributed up to that of the search, they are 2.4 times as long, and the search grows.
    /// Doubled: the whole distance is searched on most planes.
    pub const NEARBY_SPREADS: f64 = 4.5;
    /// Pairs farther apart than this many standard deviations of their distance are of different
    /// surfaces. Theory: one normal error in 16 000 is larger. Doubled: neighbouring surfaces widen
    /// the spread.
    pub const CUT_SPREADS: f64 = 4.0;
    /// Median of |x| of a normal x of standard deviation 1. Theory.
    pub const MEDIAN_OF_NORMAL: f64 = 0.6745;
}

/// `measure/view_error.rs`
pub mod view_error {
    /// Variance of the square of a normal error, in squares of its variance. Theory.
    pub const VARIANCE_OF_SQUARE: f64 = 2.0;
    /// Parts of the error that pairs tell apart by less than this, squared and relative, count as
    /// one. By hand; only rounding is smaller. Doubled: nothing changes.
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
pub mod scale {
    /// Least overlap threshold in standard deviations of the node. Theory: one normal error in 16
    /// 000 is larger. Doubled: thin parts of one direction merge.
    pub const LEAST_SIGMAS: f64 = 4.0;
    /// Least overlap threshold in footprints. By hand: curves differ by sampling. Doubled: as
    /// above.
    pub const LEAST_FOOTPRINTS: f64 = 0.35;
}

/// `measure/settle.rs`, `measure/reach.rs`, `measure/bead.rs`, `measure/common_course.rs`,
/// `measure/course_fit.rs` and `measure/align.rs`
pub mod settle {
    /// Least error of the views, in footprints. Theory: curves of one surface differ by as much
    /// through sampling alone, as for the least overlap threshold. Measured: a depth camera at half
    /// its noise errs by 0.66 mm in the median, and by 1.16 with 0.5; with 0 the 95 % distance of
    /// the bunny is 13 % larger. Doubled: that camera errs as with 0.5, and the curves of depth
    /// cameras at close range zigzag.
    pub const LEAST_FOOTPRINTS: f64 = super::scale::LEAST_FOOTPRINTS;
    /// Least ratio of the views' errors to the nodes' own. By hand: on one plane of a noisy room
    /// the errors of views seem to be three times the noise by chance; depth cameras have 9 and
    /// more. Doubled: nothing changes.
    pub const LEAST_NOISE_RATIO: f64 = 4.0;
    /// Half-length of a common course, in errors of a view. Measured: from 6 to 8 medians of the
    /// kitchens and the room fall by 1 to 3 %. Doubled: by 1 to 5 % more, but 2 to 7 % of thin
    /// things and of small ones in kitchens are lost.
    pub const ALONG_ERRORS: f64 = 8.0;
    /// Largest distance between beads of one course, in errors of a view. Theory: two views differ
    /// by √2 errors, and one normal difference in 100 000 is larger than 4.42 times that. Measured:
    /// with 5, walls that wrong poses double keep both copies (95 % distance of
    /// `parts_pin12_n01_pose` 7 % larger); with 7, small things merge (tight completeness of
    /// `kitchen_kin40_real` 86.0 instead of 86.4 %). Doubled: surfaces beside each other merge.
    pub const ACROSS_ERRORS: f64 = 6.25;
    /// Largest factor between the reach of a common course and the typical one. By hand: it bounds
    /// the time. Measured: with 1, where all courses are alike, the 95 % distance of parts seen
    /// from near and far is 5 % larger and the median of the red kitchen's halves 4 %. Between 1.5
    /// and 5 no such figure changes by more than 2 %. Doubled: nothing but time.
    pub const LARGEST_REACH: f64 = 2.0;
    /// Half-lengths of all windows, in that of the narrowest: each about three times the one
    /// before. Measured against 2 and 4: medians of three kitchens and a room fall by 2 to 7 %.
    /// Doubled: they change by -4 to +2 %, and those of round things grow by a tenth.
    pub const WINDOWS: [f64; 3] = [1.0, 3.0, 10.0];
    /// Distance between the courses of a wider window and of the narrower ones at which the wider
    /// one does not count, in standard deviations. Theory: one normal error in 400 is larger. The
    /// standard deviation is that between the wider and the narrowest window, so the widest window
    /// has twice as much room. Measured with its own one: medians of two kitchens are 2 % larger,
    /// no other figure changes by 1 %. Doubled: bends become flatter.
    pub const WAVE_CUT: f64 = 3.0;
    /// Rounds of alignment. Measured: the first takes out half of the views' differences. Between 1
    /// and 4 nothing changes by more than 1 %, but for the median of `parts_pin12_n01_pose`: it is
    /// 3 % larger after two. Doubled: time.
    pub const ALIGN_ROUNDS: usize = 3;
    /// Distance from its course, in errors of a view, at which a bead does not move its view.
    /// Theory: as for other outliers, one normal error in 16 000 is larger. Doubled: other surfaces
    /// pull.
    pub const ALIGN_CUT: f64 = 4.0;
    /// Half-lengths of a course that count as one observation of a view's motion: windows beside
    /// each other share the errors of the camera. Measured: between 1 and 16 medians of the kitchen
    /// and the red kitchen change by 3 %, and are best between 4 and 16. Doubled: nothing changes.
    pub const REACHES_PER_OBSERVATION: f64 = 4.0;
    /// Beads along half of a course. Measured: with 3, wide windows round corners by 10 %, and the
    /// 95 % distance of `parts_pin12_n01_pose` grows by 5 %. Doubled: four times the time of common
    /// courses.
    pub const BEADS_PER_REACH: f64 = 5.0;
    /// Smallest cosine between beads that are joined. Measured on `parts_pin12_n01_pose`, whose
    /// parts are round: with 10 degrees its 95 % distance is that of short beads within 1 %. With
    /// 30 degrees it is 5 % larger. Doubled angle: corners get rounder.
    pub const JOINED_COSINE: f64 = 0.985;
    /// How far apart beads that share a course may be: along it, in half-lengths of the window, and
    /// across it, in largest distances between beads of one course. By hand: half a bead, and a
    /// distance at which windows still hold the same views. Measured against a course for each
    /// bead: fusion of the red kitchen takes 0.7 times as long, and medians of 22 depth cameras
    /// change by 0.3 %, on average by nothing. Doubled: both take 3 % less time, and the 95 %
    /// distance of `parts_pin12_n01_pose` is 1 % larger.
    pub const SHARED_ALONG: f64 = 0.5 / BEADS_PER_REACH;
    pub const SHARED_ACROSS: f64 = 0.25;
    /// Largest ratio of the variances of beads that share a course, and so nearly the reach of
    /// their windows. Measured: without a bound, the median of the red kitchen's halves is 4 %
    /// larger. Doubled: nothing changes.
    pub const SHARED_VARIANCE: f64 = 1.3;
    /// Beads that are joined before views are aligned: a motion of the whole view needs no detail.
    /// Measured with 3 instead of 2: figures of depth cameras change by about 1 % at most, and
    /// fusion of the red kitchen takes 5 % less time. Doubled: courses of short pieces of curve
    /// have no slope.
    pub const ALIGN_BEADS: usize = 3;
    /// Rounds of averaging. By hand: the first course passes through beads that have not moved.
    /// Doubled: corners become rounder, while accuracy gains 2 %.
    pub const ROUNDS: usize = 2;
    /// Least variance of the beads' places along a course, in squares of its half-length, for the
    /// course to have a slope. By hand. Doubled: nothing changes.
    pub const LEAST_VARIANCE: f64 = 0.01;
    /// Least mean square of what of x² is not linear along a course, with x in half-lengths, for
    /// the course to have a bend. By hand: the square of [`LEAST_VARIANCE`], as x² goes with x².
    /// A window that is measured as a whole has 0.04.
    pub const LEAST_BENT: f64 = LEAST_VARIANCE * LEAST_VARIANCE;
    /// Least variance of a view's distance from a common course, in variances of the view, for the
    /// distance to tell something of the views' errors. Theory: two views that count alike have
    /// half. Doubled: courses of two views do not count.
    pub const LEAST_OFF_VARIANCE: f64 = 0.25;
}
