//! Growing a model store from scans: the part of `reconstruct` that `--store` asks for.

use super::model_file::open_store;
use super::planes::PlaneArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::table::Row;
use std::path::{Path, PathBuf};
use transect::{
    GrowError, Grower, Growth, LoadedView, ReconstructError, Reconstruction, Setup, SourceError,
    ViewSource,
};
use transect_exchange::{Scan, ScanView};
use transect_geometry::{Isometry3, PlaneFamily};
use transect_model::store::Store;

/// Options that have a store grown.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Model store (views can be added, replaced and removed later)")]
pub struct StoreArguments {
    /// Model store to add the scan's views to, one transaction each; made if it is not there. Views
    /// that it has are left alone, so an interrupted run can be run again.
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// Put before the names of this scan's views in the store, where several scans share names.
    #[arg(long, value_name = "TEXT", requires = "store", default_value = "")]
    prefix: String,
}

type Grown = (Reconstruction, Vec<Row>);

impl StoreArguments {
    /// The planes of a store that is there, for a scan and a command line that name none.
    pub fn planes(
        &self,
        scan: &Scan,
        asked: &PlaneArguments,
    ) -> Result<Option<PlaneFamily>, Failure> {
        match &self.store {
            Some(path) if path.exists() && scan.planes.is_none() && asked.say_nothing() => {
                Ok(Some(open_store(path)?.read()?.header().planes.clone()))
            }
            _ => Ok(None),
        }
    }

    /// Grows the store by a scan; `None` if there is no store to grow.
    pub fn grow(
        &self,
        scan_path: &Path,
        scan: &Scan,
        setup: &Setup,
        progress: &Progress,
    ) -> Option<Result<Grown, Failure>> {
        let path = self.store.as_ref()?;
        let origin = std::path::absolute(scan_path).unwrap_or_else(|_| scan_path.to_owned());
        let origin = origin.display().to_string();
        let view = |view| StoreView {
            view,
            id: format!("{}{}", self.prefix, view.name()),
            origin: origin.clone(),
            pose: None,
        };
        let views: Vec<StoreView> = scan.views.iter().map(view).collect();
        Some(grow(path, &views, setup, progress))
    }
}

/// A view of a scan on its way into a store.
pub struct StoreView<'a> {
    /// Where its image is.
    pub view: &'a ScanView,
    /// What the store calls it.
    pub id: String,
    /// The scan it is of.
    pub origin: String,
    /// In place of the scan's own.
    pub pose: Option<Isometry3>,
}

impl ViewSource for StoreView<'_> {
    fn name(&self) -> &str {
        self.view.name()
    }

    fn id(&self) -> &str {
        &self.id
    }

    fn origin(&self) -> String {
        self.origin.clone()
    }

    fn load(&self) -> Result<LoadedView, SourceError> {
        let (view, notes) = self.view.load()?;
        let view = match &self.pose {
            Some(pose) => view.with_pose(*pose)?,
            None => view,
        };
        Ok(LoadedView { view, notes })
    }
}

fn grow(
    path: &Path,
    views: &[StoreView<'_>],
    setup: &Setup,
    progress: &Progress,
) -> Result<Grown, Failure> {
    let is_new = !path.exists();
    let store = if is_new { create(path, setup)? } else { open_store(path)? };
    let grower = Grower::new(&store, setup).map_err(|e| Failure::with_file(path, e))?;
    let grown = grower.add_views(views, progress);
    let nothing = matches!(
        grown,
        Err(GrowError::View(ReconstructError::Nothing { .. } | ReconstructError::NoCurves { .. }))
    );
    if is_new && nothing {
        // Its planes are fixed, and of no use: the next attempt will have others.
        drop(store);
        std::fs::remove_file(path).map_err(|e| Failure::with_file(path, e))?;
        return Err(grown
            .map(drop)
            .err()
            .map_or_else(|| Failure::because("no curves"), Failure::from));
    }
    let Growth { present, report, fused } = grown?;
    let rows = vec![
        Row::new("store", path.display().to_string(), ""),
        Row::count("views added", report.views.len()),
        Row::count("views there already", present.len()),
        Row::count("planes fused", fused),
    ];
    let model = store.read()?.model()?;
    store.close()?;
    Ok((Reconstruction { model, report }, rows))
}

fn create(path: &Path, setup: &Setup) -> Result<Store, Failure> {
    if let Some(folder) = path.parent().filter(|f| !f.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|e| Failure::with_file(folder, e))?;
    }
    Ok(Store::create(path, &setup.store_header())?)
}
