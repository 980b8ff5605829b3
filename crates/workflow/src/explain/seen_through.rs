//! The last step of a plane: what more views looked through than measured is left out.

use super::PlaneOfViews;
use super::page::Builder;
use super::pairwise::curves_apart;
use super::palette;
use super::plane_map::{PlaneMap, SIZE, envelope_of};
use transect::{Seen, Witness, without_seen_through};
use transect_exchange::svg::Mark;
use transect_geometry::Curve;

/// Draws the curves that a model has, if the step leaves out any node of the fused ones. Returns
/// the curves of the model.
pub(super) fn draw(
    of_views: &PlaneOfViews<'_>,
    fused: Vec<Curve>,
    pages: &mut Builder,
) -> Vec<Curve> {
    let Some(around) = envelope_of(&fused) else { return fused };
    let has_curves = of_views.witnesses.iter().zip(&of_views.curves);
    let witnesses: Vec<&Witness> = has_curves
        .filter(|(_, curves)| !curves.is_empty())
        .filter_map(|(w, _)| w.as_ref())
        .collect();
    let frame = of_views.setup.planes.frame(of_views.plane);
    let Seen { curves, left_out } = without_seen_through(fused.clone(), &frame, &witnesses);
    if left_out == 0 {
        return curves;
    }
    pages.count("nodes seen through, left out", left_out);
    let caption = format!(
        "{left_out} nodes are left out, because more views looked through them than measured them. \
         These {} curves are those of the model.",
        curves.len()
    );
    let map = PlaneMap::fit(&around, of_views.setup.unit);
    let title = "Curves without what views looked through";
    pages.step("seen-through", (title, &caption), SIZE, |figure| {
        map.inside(figure, |figure| {
            for curve in &fused {
                map.curve(figure, curve, palette::MISSING, 1.6);
            }
        });
        curves_apart(figure, &map, &curves);
        figure.legend(Mark::Line(palette::MISSING), "left out");
    });
    curves
}
