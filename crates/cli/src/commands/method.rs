//! Options that choose the methods, and the settings of the dissertation's own methods.

use super::lengths::length;
use super::named;
use crate::failure::Failure;
use clap::Args;
use transect_fusion::FusionMethod;
use transect_partial::Method;
use transect_partial::dissertation::DirectionRule;
use transect_partial::subpixel::Subpixel;
use transect_workflow::Settings;

/// How curves are found and fused.
#[derive(Debug, Args)]
#[command(next_help_heading = "Method")]
pub struct MethodArguments {
    /// How each view's curves are found: all planes in one sweep over the range image, or plane by
    /// plane, in the dissertation's own steps [default: the store's, else one_pass].
    #[arg(long, value_name = "METHOD", value_parser = named([
        ("one_pass", Method::OnePass(Default::default())),
        ("dissertation", Method::Dissertation(Default::default())),
    ]))]
    method: Option<Method>,
    /// How the views' curves are fused: all views at once, or view by view, by the dissertation's
    /// overlap rules [default: the store's, else consensus].
    #[arg(long, value_name = "METHOD", value_parser = named([
        ("consensus", FusionMethod::Consensus(Default::default())),
        ("pairwise", FusionMethod::Pairwise(Default::default())),
    ]))]
    fusion: Option<FusionMethod>,
    #[command(flatten)]
    own: OwnArguments,
}

/// Settings of the dissertation's own methods.
#[derive(Debug, Args)]
#[command(next_help_heading = "Settings of the dissertation (--method dissertation, \
                               --fusion pairwise)")]
struct OwnArguments {
    /// Where a plane passes between two pixels (3.6): straight in space or in the device frame, or
    /// a cubic through four points [default: cartesian].
    #[arg(long, value_name = "SOLUTION", value_parser = named([
        ("cartesian", Subpixel::Cartesian),
        ("device_plane", Subpixel::DevicePlane),
        ("device_curves", Subpixel::DeviceCurves),
        ("four_point", Subpixel::FourPoint),
    ]))]
    subpixel: Option<Subpixel>,
    /// Most missing pixels that a curve is continued across; 0 bridges nothing (3.5.1)
    /// [default: 4].
    #[arg(long, value_name = "PIXELS")]
    gap: Option<usize>,
    /// Thickness up to which a curve is thinned; below 2 nothing is thinned (3.5.2) [default: 4].
    #[arg(long, value_name = "PIXELS")]
    thickness: Option<usize>,
    /// What tells a range jump: the angle of incidence, or the printed test, for which both pixels
    /// lie nearer to the plane than LENGTH along their rays (3.4.2) [default: incidence].
    #[arg(long, value_name = "incidence|LENGTH")]
    jump: Option<String>,
    /// What tells the direction of a curve: where rays meet the plane, or the printed rules by
    /// code (3.7) [default: points].
    #[arg(long, value_name = "RULE", value_parser = named([
        ("points", DirectionRule::PlanePoints),
        ("codes", DirectionRule::Codes),
    ]))]
    direction: Option<DirectionRule>,
    /// Distance within which two curves of one direction overlap (5.5.1) [default: measured
    /// between the views].
    #[arg(long, value_name = "LENGTH")]
    threshold: Option<String>,
}

impl MethodArguments {
    /// Puts the options into settings.
    pub fn apply(&self, settings: &mut Settings) -> Result<(), Failure> {
        (settings.partial, settings.fusion) = (self.method, self.fusion);
        let (own, methods) = (&self.own, &mut settings.methods);
        (methods.subpixel, methods.direction) = (own.subpixel, own.direction);
        (methods.gap, methods.thickness) = (own.gap, own.thickness);
        methods.jump = own.jump.as_deref().map(str::parse).transpose()?;
        methods.threshold = length("threshold", own.threshold.as_ref())?;
        Ok(())
    }
}
