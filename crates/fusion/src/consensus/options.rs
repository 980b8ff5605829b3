//! Options, and the switches of the steps beyond the core.

use serde::{Deserialize, Serialize};

/// Options. No length is in the user's unit: all follow from measured spreads and
/// footprints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ConsensusOptions {
    /// Overlap threshold in measured spreads between views. Two curves of the same direction that
    /// lie closer than this are one surface.
    pub threshold_spreads: f64,
    /// Largest angle between the directions of two observations of one surface, in radians.
    pub direction_limit_rad: f64,
    /// Shortest curve, in footprints that were measured: gaps do not count. A shorter one stays
    /// without a gap if it is closed or two views measured it. Shorter loops and rests are left out
    /// where curves crossed.
    pub shortest_footprints: f64,
    /// Steps to leave out, to measure what they are worth.
    #[doc(hidden)]
    #[serde(skip)]
    pub steps: Steps,
}

impl Default for ConsensusOptions {
    fn default() -> Self {
        Self {
            threshold_spreads: 8.0,
            direction_limit_rad: 50_f64.to_radians(),
            shortest_footprints: 4.0,
            steps: Steps::default(),
        }
    }
}

/// Declares the switches once: the fields, their default, and the list for measurements.
macro_rules! steps {
    ($($(#[$doc:meta])* $name:ident,)*) => {
        /// The steps beyond the core; all run by default, and the result is valid without any.
        ///
        /// The core is: observations, spread, thinning, final place, links, cover.
        /// `cargo xtask experiments ablation` leaves out one step at a time.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[non_exhaustive]
        pub struct Steps {
            $($(#[$doc])* pub $name: bool,)*
        }

        impl Default for Steps {
            fn default() -> Self {
                Self { $($name: true,)* }
            }
        }

        impl Steps {
            /// For each step its name, and all steps but this one.
            pub fn each_left_out() -> Vec<(&'static str, Self)> {
                vec![$((stringify!($name), Self { $name: false, ..Self::default() }),)*]
            }
        }
    };
}

steps! {
    /// The sampling error of each node, from how rough its view's curve is.
    sampling_error,
    /// Less weight towards open ends.
    end_taper,
    /// The views' systematic errors, as part of all weights.
    view_error,
    /// The part of these errors that goes with the noise.
    error_with_noise,
    /// The part of them that grows with the incidence.
    incidence_error,
    /// A first search for other views nearby, before the full search distance.
    nearby_spread,
    /// Views' curves moved onto their common course where their errors exceed a third of a
    /// footprint.
    settle,
    /// Views shifted and turned as a whole before.
    align,
    /// Curves moved onto longer courses where the surface bends no more than a parabola.
    wider_courses,
    /// Groups of observations that rough fits treat as one.
    groups,
    /// Groups that go to a node that stands already when their turn comes.
    late_absorption,
    /// The shift of a cluster on a bend towards the inside.
    bend_shift,
    /// Third and fourth order of an arc in the final fits.
    arcs,
    /// Correlation of the errors of neighbouring nodes.
    shared_errors,
    /// The second, weighted fit where residuals are large.
    robust_fit,
    /// One of the two narrowest windows may be off by chance.
    stray_windows,
    /// A single window that disagrees is passed over.
    passed_window,
    /// A wider first window for fine nodes among coarse ones.
    wide_first_window,
    /// Windows on bends as wide as noise hides the fit's error.
    noisy_turns,
    /// All windows gathered at once where most nodes need them.
    wide_gathering,
    /// Gaps counted in samples of the coarsest view.
    coarse_spacing,
    /// Links that the views' own curves suggest.
    witnessed_links,
    /// Links to nodes near open ends cost more.
    end_doubt,
    /// Ends that meet are joined first.
    join_meeting,
    /// Ends that continue each other are joined.
    join_smooth,
    /// Ends round a tip are joined.
    join_hairpin,
    /// Ends that cross are cut back and joined.
    join_crossing,
    /// Open chains of one view beside a closed one are left out.
    spurs,
    /// Short units that run backwards are removed, and units within the noise that turn by more
    /// than 90 degrees.
    backward,
    /// Short chains of one view are left out on planes where curves moved onto common courses.
    lone_chains,
    /// Small closed chains become circles.
    rings,
    /// Corners become sharp.
    corners,
    /// Short sides between two corners.
    short_sides,
    /// Nodes between neighbours where the curve leaves their chord.
    middle_nodes,
}
