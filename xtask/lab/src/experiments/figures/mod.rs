//! The dissertation's own results, by its own methods: Figures 4.11 to 4.20 and 5.13 to 5.33.
//!
//! Chapter 4 shows the points of one view, and the partial model of that view, for each sensor.
//! Chapter 5 shows range images, and the global model after each of them. The scenes are the
//! bundled ones, and their scanners have their true size.

mod mask;

use super::lab::Lab;
use super::pictures::{SCANNERS, Shown, observed, scanned};
use super::trial;
use crate::failure::Failure;
use crate::table::say;
use mask::{Growth, Judged};
use std::io::Write;
use std::path::Path;
use transect::{Unwatched, reconstruct};
use transect_device::View;
use transect_exchange::svg::{write_overview, write_points};
use transect_exchange::write_file;
use transect_model::Model;
use transect_workflow::explain::range_image_figure;
use transect_workflow::simulation::{PreparedScene, SensorPlan};

/// The numbers of the two figures of chapter 4 that show each of [`SCANNERS`].
const CHAPTER_4: [[&str; 2]; 3] = [["4.11", "4.12"], ["4.14", "4.15"], ["4.19", "4.20"]];

/// Number of the first range image of the room, and of the face mask.
const ROOM: usize = 13;
const MASK: usize = 18;

/// Pictures in their order, and the page that shows them.
struct Page<'a> {
    folder: &'a Path,
    pictures: Vec<(String, String)>,
}

/// Runs the experiment.
pub fn run(lab: &Lab) -> Result<(), Failure> {
    let folder = lab.folder()?;
    let mut page = Page { folder, pictures: Vec::new() };
    for (shown, numbers) in SCANNERS.iter().zip(CHAPTER_4) {
        chapter_4(shown, numbers, &mut page)?;
    }
    room(&mut page, lab)?;
    face(&mut page, lab)?;
    page.write()?;
    say(&format!("{} pictures: {}", page.pictures.len(), folder.join("index.html").display()));
    Ok(())
}

/// The points of one view, and its partial model.
fn chapter_4(shown: &Shown, numbers: [&str; 2], page: &mut Page<'_>) -> Result<(), Failure> {
    let scene = trial::bundled_without_noise(shown.scene)?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let first = views.get(..1).unwrap_or_default();
    let name = shown.sensor.name();
    let points: Vec<_> = first.iter().flat_map(scanned).collect();
    let (planes, unit) = (&scene.description.planes, scene.description.unit);
    let caption = format!("{} of the points of one view", points.len());
    let options = observed(&format!("{name}: scanned points"), shown.observer);
    page.add(numbers[0], &format!("Points that the sensor {name} scanned"), |out| {
        write_points(&points, planes, unit, &caption, &options, out)
    })?;
    let [(_, setup), _] = mask::setups(&scene);
    let model = reconstruct(first, &setup, &Unwatched)?.model;
    let options = observed(&format!("{name}: partial model of one view"), shown.observer);
    page.add(numbers[1], &format!("Partial model of this view of the sensor {name}"), |out| {
        write_overview(&model, &options, out)
    })
}

/// The room: four range images, and the model after each of them.
fn room(page: &mut Page<'_>, lab: &Lab) -> Result<(), Failure> {
    let scene = trial::bundled("room")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let number = |k: usize, is_model: bool| match (is_model, k) {
        (false, k) => format!("5.{}", ROOM + k),
        (true, 3) => "5.17".to_owned(),
        // Not printed in the dissertation.
        (true, k) => format!("5.17-after-{}", k + 1),
    };
    let (growth, _) = grown("room", (&scene, &views), SCANNERS[0].observer, page, number)?;
    growth.print("room", lab)
}

/// The face mask: a range image of each view, the model after it, and how good the last one is.
fn face(page: &mut Page<'_>, lab: &Lab) -> Result<(), Failure> {
    let scene = trial::bundled("hyscan_mask")?;
    let views = scene.simulate(&SensorPlan::OWN)?.views;
    let number = |k: usize, is_model: bool| format!("5.{}", MASK + 2 * k + usize::from(is_model));
    let observer = SCANNERS[2].observer;
    let (growth, model) = grown("face mask", (&scene, &views), observer, page, number)?;
    growth.print("growth", lab)?;
    let [(own, _), (default, setup)] = mask::setups(&scene);
    let default = (default, reconstruct(&views, &setup, &Unwatched)?.model);
    let models = model.map(|model| (own, model)).into_iter().chain([default]).collect();
    let judged = Judged { scene: &scene, views: &views, models };
    judged.print(lab)?;
    let figure = judged.drawn()?;
    lab.picture("mask", |file| figure.write(file))
}

/// Draws the range image of each view, and the model of the dissertation's methods after it, with
/// the cases and patterns that occurred and the gaps that are left. `number` names the figures.
fn grown(
    what: &str,
    (scene, views): (&PreparedScene, &[View]),
    observer: (f64, f64),
    page: &mut Page<'_>,
    number: impl Fn(usize, bool) -> String,
) -> Result<(Growth, Option<Model>), Failure> {
    let [(_, setup), _] = mask::setups(scene);
    let mut growth = Growth::new(scene.description.unit);
    let mut last = None;
    for (k, view) in views.iter().enumerate() {
        let caption = format!("Range image of view {} of the {what}", k + 1);
        let figure = range_image_figure(view, &caption, view.name());
        page.add(&number(k, false), &caption, |out| figure.write(out))?;
        let result = reconstruct(&views[..=k], &setup, &Unwatched)?;
        let told = growth.add(&result);
        let title = format!("{what} after view {}", k + 1);
        let options = observed(&title, observer);
        page.add(&number(k, true), &format!("Global model of the {title}: {told}"), |out| {
            write_overview(&result.model, &options, out)
        })?;
        last = Some(result.model);
    }
    Ok((growth, last))
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
