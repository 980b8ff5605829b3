//! The error of registered poses in the nodes of runs and stores.

use crate::objects::{noisy_views, setup};
use transect::{Grower, LoadedView, Refinement, SourceError, Unwatched, ViewSource, reconstruct};
use transect_device::View;
use transect_geometry::Node;
use transect_model::Section;
use transect_model::store::Store;

/// A view whose source states by how much its surface may be off.
pub struct Registered(pub View, pub Option<f64>);

impl ViewSource for Registered {
    fn name(&self) -> &str {
        self.0.name()
    }

    fn surface_sigma(&self) -> Option<f64> {
        self.1
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        self.0.load()
    }
}

fn registered(surface_sigma: impl Fn(usize) -> Option<f64>) -> Vec<Registered> {
    let views = noisy_views().into_iter().enumerate();
    views.map(|(k, view)| Registered(view, surface_sigma(k))).collect()
}

#[test]
fn nodes_hold_what_registered_poses_may_err_by() {
    let as_given = reconstruct(&noisy_views(), &setup(), &Unwatched).unwrap();
    let with_sigma = reconstruct(&registered(|_| Some(0.5)), &setup(), &Unwatched).unwrap();
    let mut nodes = 0;
    for ((plane, before), (index, after)) in
        as_given.model.sections().zip(with_sigma.model.sections())
    {
        assert_eq!(plane, index);
        let of = |section: &Section| {
            section.curves().flat_map(|curve| curve.nodes().to_vec()).collect::<Vec<Node>>()
        };
        for (before, after) in of(before).iter().zip(of(after)) {
            assert_eq!((before.position, before.views), (after.position, after.views));
            if let Some(views) = before.views {
                let of_pose = 0.5 / f64::from(views.get()).sqrt();
                let expected = f64::from(before.sigma).hypot(of_pose);
                assert!((f64::from(after.sigma) / expected - 1.0).abs() < 1e-6, "{after:?}");
                nodes += 1;
            }
        }
    }
    assert!(nodes > 1000, "{nodes}");
}

#[test]
fn a_store_holds_them_as_one_run_does() {
    let sources = registered(|_| Some(0.5));
    let at_once = reconstruct(&sources, &setup(), &Unwatched).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("registered.transect");
    let store = Store::create(path, &setup().store_header()).unwrap();
    let setup = setup();
    let grower = Grower::new(&store, &setup).unwrap();
    grower.add_views(&sources, &Unwatched).unwrap();
    let stored = store.read().unwrap().model().unwrap();
    assert!(stored.sections().eq(at_once.model.sections()));
    let again = grower.add_views(&sources, &Unwatched).unwrap();
    assert_eq!(again.present.len(), sources.len());
    for other in [None, Some(0.25)] {
        let error = grower.add_views(&registered(|_| other), &Unwatched).unwrap_err();
        assert!(error.to_string().contains("another surface_sigma"), "{error}");
    }
}

#[test]
fn errors_that_neighbouring_planes_share_leave_out_no_plane() {
    let mut setup = setup();
    let unrefined = reconstruct(&noisy_views(), &setup, &Unwatched).unwrap();
    setup.refinement = Some(Refinement::new(0.01, 2).unwrap());
    let planes = |sigma| {
        let result = reconstruct(&registered(|_| sigma), &setup, &Unwatched).unwrap();
        result.model.sections().map(|(plane, _)| plane).collect::<Vec<_>>()
    };
    let exact = planes(None);
    assert_eq!(planes(Some(0.5)), exact);
    assert!(exact.len() > unrefined.model.sections().len(), "{}", exact.len());
}

#[test]
fn a_source_whose_surface_is_off_by_no_number_is_named() {
    for wrong in [-1.0, 1e40, f64::NAN, f64::INFINITY] {
        let sources = registered(|k| (k == 1).then_some(wrong));
        let error = reconstruct(&sources, &setup(), &Unwatched).map(drop).unwrap_err().to_string();
        let view = format!("view {}: its surface_sigma is ", sources[1].name());
        assert!(error.starts_with(&view), "{error}");
    }
}
