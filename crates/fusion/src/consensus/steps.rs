//! Switches for the steps beyond the core, to measure what each is worth.

/// The steps of consensus that can be left out. The result is valid without any of them.
///
/// The core always runs: observations, spread, thinning, placing, links, cover.
/// `cargo xtask experiments ablation` switches one off at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Steps {
    pub sampling_error: bool,
    pub taper: bool,
    pub layers: bool,
    pub layer_following: bool,
    pub view_error: bool,
    pub incidence_error: bool,
    pub nearby_spread: bool,
    pub groups: bool,
    pub late_absorption: bool,
    pub along_variance: bool,
    pub arcs: bool,
    pub shared_errors: bool,
    pub robust_fit: bool,
    pub stray_windows: bool,
    pub passed_window: bool,
    pub wide_first_window: bool,
    pub noisy_turns: bool,
    pub spread_spacing: bool,
    pub witnessed_links: bool,
    pub link_doubt: bool,
    pub join_meeting: bool,
    pub join_smooth: bool,
    pub join_hairpin: bool,
    pub join_crossing: bool,
    pub second_cover: bool,
    pub spurs: bool,
    pub sideways: bool,
    pub backward: bool,
    pub redundant: bool,
    pub direction: bool,
    pub rings: bool,
    pub corners: bool,
    pub short_sides: bool,
    pub bent_sides: bool,
    pub middle_nodes: bool,
    pub gather_far: bool,
}

impl Steps {
    pub const ALL: Self = Self {
        sampling_error: true,
        taper: true,
        layers: true,
        layer_following: true,
        view_error: true,
        incidence_error: true,
        nearby_spread: true,
        groups: true,
        late_absorption: true,
        along_variance: true,
        arcs: true,
        shared_errors: true,
        robust_fit: true,
        stray_windows: true,
        passed_window: true,
        wide_first_window: true,
        noisy_turns: true,
        spread_spacing: true,
        witnessed_links: true,
        link_doubt: true,
        join_meeting: true,
        join_smooth: true,
        join_hairpin: true,
        join_crossing: true,
        second_cover: true,
        spurs: true,
        sideways: true,
        backward: true,
        redundant: true,
        direction: true,
        rings: true,
        corners: true,
        short_sides: true,
        bent_sides: true,
        middle_nodes: true,
        gather_far: true,
    };

    /// Name and switch of each.
    pub fn each() -> Vec<(&'static str, fn(&mut Self) -> &mut bool)> {
        macro_rules! list { ($($n:ident),*) => { vec![$((stringify!($n), (|s: &mut Self| &mut s.$n) as fn(&mut Self) -> &mut bool)),*] } }
        list![
            sampling_error,
            taper,
            layers,
            layer_following,
            view_error,
            incidence_error,
            nearby_spread,
            groups,
            late_absorption,
            along_variance,
            arcs,
            shared_errors,
            robust_fit,
            stray_windows,
            passed_window,
            wide_first_window,
            noisy_turns,
            spread_spacing,
            witnessed_links,
            link_doubt,
            join_meeting,
            join_smooth,
            join_hairpin,
            join_crossing,
            second_cover,
            spurs,
            sideways,
            backward,
            redundant,
            direction,
            rings,
            corners,
            short_sides,
            bent_sides,
            middle_nodes,
            gather_far
        ]
    }
}

impl Default for Steps {
    fn default() -> Self {
        Self::ALL
    }
}
