//! `transect explain`: each step of the methods on one view and one plane, as figures.

use super::method::MethodArguments;
use super::planes::{AcceptArguments, PlaneArguments};
use super::scan::ScanArguments;
use crate::failure::Failure;
use crate::notes;
use crate::table::{Row, print};
use std::path::{Path, PathBuf};
use transect_workflow::explain::Explanation;
use transect_workflow::{OpenScan, Settings, WorkflowError, default_folder};

/// Options of `explain`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// The view whose range image is shown, by its number from 0 or by its name.
    #[arg(long, value_name = "VIEW", default_value = "0")]
    view: String,
    #[command(flatten)]
    drawing: DrawingArguments,
}

/// The common arguments of `explain` and `explain-growth`.
#[derive(Debug, clap::Args)]
pub struct DrawingArguments {
    /// Scan, as for reconstruct.
    scan: PathBuf,
    /// Number of the plane [default: the one on which the view has most curves].
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    plane: Option<i64>,
    /// Folder for the figures and the page index.html [default: transect-out/NAME/COMMAND].
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    open: ScanArguments,
    #[command(flatten)]
    planes: PlaneArguments,
    #[command(flatten)]
    methods: MethodArguments,
    #[command(flatten)]
    accept: AcceptArguments,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<(), Failure> {
    arguments
        .drawing
        .run("explain", |scan, settings, plane| scan.explain(settings, &arguments.view, plane))
}

impl DrawingArguments {
    /// Opens the scan, makes an explanation, and writes it.
    pub fn run(
        &self,
        command: &str,
        explain: impl FnOnce(&OpenScan, &Settings, Option<i64>) -> Result<Explanation, WorkflowError>,
    ) -> Result<(), Failure> {
        let mut scan = self.open.open(&self.scan)?;
        let mut settings = Settings::default();
        settings.planes = self.planes.settings()?;
        settings.accept.clone_from(&self.accept.accept);
        self.methods.apply(&mut settings)?;
        if scan.lacks_planes(&settings) {
            notes::tell(&[scan.suggest_planes(&settings)?]);
        }
        let default = || default_folder(&scan.scan().name).join(command);
        let out = self.out.clone().unwrap_or_else(default);
        let explanation = explain(&scan, &settings, self.plane)?;
        let page = explanation.write(&out, &scan.inputs(&settings, None))?;
        print(&rows(&explanation, &page));
        Ok(())
    }
}

fn rows(explanation: &Explanation, page: &Path) -> Vec<Row> {
    let mut rows = vec![Row::plain("explained", &explanation.title)];
    rows.extend(explanation.counts.iter().map(|(what, value)| Row::plain(what.as_str(), value)));
    rows.push(Row::plain("figures", explanation.steps.len()));
    rows.push(Row::plain("page", page.display()));
    rows
}
