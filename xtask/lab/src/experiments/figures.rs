//! The dissertation's own results, by its own methods: Figures 4.11 to 4.20 and 5.13 to 5.33.
//!
//! Chapter 4 shows the points of one view, and the partial model of that view, for each sensor.
//! Chapter 5 shows the range images of several views, and the global model after them. The scenes
//! are the bundled ones. The face mask of chapter 5 is seen by the line scanner at its true size.

mod mask;

use super::output::Output;
use super::pictures::scanned;
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use mask::{Growth, Judged};
use std::io::Write;
use std::path::Path;
use transect::{Unwatched, reconstruct};
use transect_device::{Pixel, View};
use transect_exchange::svg::{Figure, Mark, OverviewOptions, Raster, write_overview, write_points};
use transect_exchange::write_file;
use transect_geometry::Point2;
use transect_model::Model;
use transect_workflow::simulation::{PreparedScene, SensorKind, SensorPlan};

/// Options of `experiments figures`.
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Factor on the rows and columns of the sensors of chapter 4.
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR")]
    density: f64,
}

/// A sensor of chapter 4: its scene, where the observer stands (azimuth and elevation in degrees),
/// and the numbers of its two figures.
struct Chapter4 {
    sensor: SensorKind,
    scene: &'static str,
    observer: (f64, f64),
    figures: [&'static str; 2],
}

const CHAPTER_4: [Chapter4; 3] = [
    Chapter4 {
        sensor: SensorKind::Spherical,
        scene: "room",
        observer: (-60.0, 35.0),
        figures: ["4.11", "4.12"],
    },
    Chapter4 {
        sensor: SensorKind::LightStripe,
        scene: "face_mask",
        observer: (-65.0, 20.0),
        figures: ["4.14", "4.15"],
    },
    Chapter4 {
        sensor: SensorKind::LookupTable,
        scene: "face_mask",
        observer: (-65.0, 20.0),
        figures: ["4.19", "4.20"],
    },
];

/// Width and height of a range image's drawing, in pixels.
const IMAGE: f64 = 620.0;

/// Pictures in their order, and the page that shows them.
struct Page<'a> {
    folder: &'a Path,
    pictures: Vec<(String, String)>,
}

/// Runs the experiment.
pub fn run(arguments: &Arguments, out: &Output) -> Result<(), Failure> {
    let folder = out.folder()?;
    let mut page = Page { folder, pictures: Vec::new() };
    for shown in &CHAPTER_4 {
        chapter_4(shown, arguments.density, &mut page)?;
    }
    let density = arguments.density;
    room(density, &mut page)?;
    face(&mut page, out)?;
    page.write()?;
    say(&format!("{} pictures: {}", page.pictures.len(), folder.join("index.html").display()));
    Ok(())
}

/// The points of one view, and its partial model.
fn chapter_4(shown: &Chapter4, density: f64, page: &mut Page<'_>) -> Result<(), Failure> {
    let Chapter4 { sensor, scene, observer, figures } = shown;
    let scene = trial::bundled_without_noise(scene)?;
    let views = views(&scene, plan(*sensor, None, density))?;
    let first = views.get(..1).unwrap_or_default();
    let name = sensor.name();
    let points: Vec<_> = first.iter().flat_map(scanned).collect();
    let (planes, unit) = (&scene.description.planes, scene.description.unit);
    let caption = format!("{} of the points of one view", points.len());
    let options = observed(&format!("{name}: scanned points"), *observer);
    page.add(figures[0], &format!("Points that the sensor {name} scanned"), |out| {
        write_points(&points, planes, unit, &caption, &options, out)
    })?;
    let model = model(first, &scene)?;
    let options = observed(&format!("{name}: partial model of one view"), *observer);
    page.add(figures[1], &format!("Partial model of this view of the sensor {name}"), |out| {
        write_overview(&model, &options, out)
    })
}

/// Four range images of the room, and the model of all.
fn room(density: f64, page: &mut Page<'_>) -> Result<(), Failure> {
    let scene = trial::bundled("room")?;
    let views = views(&scene, plan(SensorKind::Spherical, None, density))?;
    for (k, view) in views.iter().enumerate() {
        let caption = format!("Range image from corner {} of the room", k + 1);
        let figure = range_image(view, &caption);
        page.add(&format!("5.{}", 13 + k), &caption, |out| figure.write(out))?;
    }
    let model = model(&views, &scene)?;
    let options = observed("Room: model of four views", (-60.0, 35.0));
    page.add("5.17", "The room from four range images", |out| write_overview(&model, &options, out))
}

/// The face mask: a range image of each view, the model after it, and how good the last one is.
fn face(page: &mut Page<'_>, out: &Output) -> Result<(), Failure> {
    let scene = trial::bundled("hyscan_mask")?;
    let views = views(&scene, SensorPlan::OWN)?;
    let [(own, dissertation), (default, setup)] = mask::setups(&scene);
    let mut growth = Growth::default();
    let mut last = None;
    for (k, view) in views.iter().enumerate() {
        let caption = format!("Range image of view {} of the face mask", k + 1);
        let figure = range_image(view, &caption);
        page.add(&format!("5.{}", 18 + 2 * k), &caption, |out| figure.write(out))?;
        let result = reconstruct(&views[..=k], &dissertation, &Unwatched)?;
        growth.add(&result);
        let model = result.model;
        let caption = format!("Global model after view {}", k + 1);
        let options = observed(&caption, (-65.0, 20.0));
        let number = format!("5.{}", 19 + 2 * k);
        page.add(&number, &caption, |out| write_overview(&model, &options, out))?;
        last = Some((own, model));
    }
    growth.print(out)?;
    let default = (default, reconstruct(&views, &setup, &Unwatched)?.model);
    let models = last.into_iter().chain([default]).collect();
    let judged = Judged { scene: &scene, views: &views, models };
    judged.print(out)?;
    let figure = judged.drawn()?;
    write_file(&page.folder.join("mask.svg"), |file| figure.write(file))?;
    Ok(())
}

/// A sensor's plan; the room's own stations are scanners that look into it from its corners.
fn plan(sensor: SensorKind, views: Option<usize>, density: f64) -> SensorPlan {
    let own = sensor == SensorKind::Spherical;
    let plan = if own { SensorPlan::OWN } else { SensorPlan::with(sensor) };
    SensorPlan { views, density, ..plan }
}

fn views(scene: &PreparedScene, plan: SensorPlan) -> Result<Vec<View>, Failure> {
    Ok(scene.simulate(&plan)?.views)
}

/// The model of views by the dissertation's own methods.
fn model(views: &[View], scene: &PreparedScene) -> Result<Model, Failure> {
    let [(_, setup), _] = mask::setups(scene);
    Ok(reconstruct(views, &setup, &Unwatched)?.model)
}

fn observed(title: &str, (azimuth_deg, elevation_deg): (f64, f64)) -> OverviewOptions {
    let mut options = OverviewOptions::default();
    title.clone_into(&mut options.title);
    (options.azimuth_deg, options.elevation_deg) = (azimuth_deg, elevation_deg);
    (options.width, options.height) = (1000.0, 760.0);
    options
}

/// The values of a range image as an intensity image, as the dissertation shows them.
fn range_image(view: &View, caption: &str) -> Figure {
    let size = view.image().size();
    let (near, far) = view.image().extremes().unwrap_or((0.0, 1.0));
    let shade = |row, col| match view.image().get(Pixel::new(row, col)) {
        Some(value) => Raster::shade(f64::from((value - near) / (far - near))),
        None => [0xbd; 3],
    };
    let scale = IMAGE / size.rows.max(size.cols) as f64;
    let drawn = [size.cols as f64 * scale, size.rows as f64 * scale];
    let mut figure = Figure::new(caption, view.name(), drawn);
    figure.raster(&Raster::new(size.rows, size.cols, shade), Point2::origin(), drawn);
    figure.rectangle(Point2::origin(), drawn, "fill=\"none\" stroke=\"#222\"");
    figure.legend(Mark::Area("#440154"), "smallest value");
    figure.legend(Mark::Area("#9fc928"), "largest value");
    figure.legend(Mark::Area("#bdbdbd"), "missing pixel");
    figure.legend(Mark::Remark, format!("{} rows × {} columns", size.rows, size.cols));
    figure
}

impl Page<'_> {
    /// Writes the picture of a figure of the dissertation.
    fn add(
        &mut self,
        number: &str,
        caption: &str,
        write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
    ) -> Result<(), Failure> {
        let file = format!("figure-{number}.svg");
        write_file(&self.folder.join(&file), write)?;
        self.pictures.push((file, format!("Figure {number}: {caption}")));
        Ok(())
    }

    fn write(&self) -> Result<(), Failure> {
        let title = "The dissertation's results, by its own methods";
        write_file(&self.folder.join("index.html"), |out| {
            writeln!(
                out,
                "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n\
                 <title>{title}</title>\n<style>body {{ font-family: sans-serif; margin: 2rem }} \
                 img {{ width: 48rem; max-width: 100% }}</style>\n<h1>{title}</h1>"
            )?;
            for (file, caption) in &self.pictures {
                writeln!(out, "<h2>{caption}</h2>\n<img src=\"{file}\" alt=\"{caption}\">")?;
            }
            writeln!(out, "</html>")
        })?;
        Ok(())
    }
}
