//! Figures in their order, and the page that shows them.

use crate::WorkflowError;
use crate::outputs::{Staging, claim_output};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use transect_exchange::svg::Figure;
use transect_exchange::write_file;

/// The page's file.
const PAGE: &str = "index.html";

/// One step: a figure and its file.
#[derive(Debug, Clone)]
pub struct Step {
    /// Name of the file.
    pub file: String,
    /// The figure, with the number in its heading.
    pub figure: Figure,
}

/// Numbered figures under one heading.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// The subject of all figures.
    pub title: String,
    /// The figures in order.
    pub steps: Vec<Step>,
    /// Rows for the terminal: what was counted.
    pub counts: Vec<(String, String)>,
}

/// Collects the figures of an explanation.
pub(super) struct Builder(Explanation);

impl Builder {
    pub fn new(title: String) -> Self {
        Self(Explanation { title, steps: Vec::new(), counts: Vec::new() })
    }

    /// Draws the next step into a figure of a size in pixels; `name` becomes part of the file's.
    pub fn step(
        &mut self,
        name: &str,
        (title, caption): (&str, &str),
        size: [f64; 2],
        draw: impl FnOnce(&mut Figure),
    ) {
        let number = self.0.steps.len() + 1;
        let mut figure = Figure::new(format!("{number} · {title}"), caption, size);
        draw(&mut figure);
        let file = format!("{number:02}-{name}.svg");
        self.0.steps.push(Step { file, figure });
    }

    /// Adds a row for the terminal.
    pub fn count(&mut self, what: impl Into<String>, value: impl ToString) {
        self.0.counts.push((what.into(), value.to_string()));
    }

    pub fn finish(self) -> Explanation {
        self.0
    }
}

impl Explanation {
    /// Writes the figures and the page into a folder, all together. The page's path.
    ///
    /// # Errors
    /// [`WorkflowError`] naming a file that cannot be written, or that would replace an input.
    pub fn write(&self, folder: &Path, inputs: &[PathBuf]) -> Result<PathBuf, WorkflowError> {
        let files = || self.steps.iter().map(|s| s.file.as_str()).chain([PAGE]);
        if folder.is_dir() {
            files().try_for_each(|name| claim_output(&folder.join(name), inputs))?;
        }
        let staging = Staging::begin(folder)?;
        for step in &self.steps {
            write_file(&staging.path().join(&step.file), |out| step.figure.write(out))?;
        }
        write_file(&staging.path().join(PAGE), |out| self.write_page(out))?;
        staging.commit()?;
        Ok(folder.join(PAGE))
    }

    fn write_page(&self, out: &mut dyn Write) -> io::Result<()> {
        let title = escaped(&self.title);
        writeln!(
            out,
            "<!DOCTYPE html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n\
             <style>body {{ font-family: Helvetica, Arial, sans-serif; max-width: 84rem; \
             margin: 2rem auto; padding: 0 1rem; color: #222 }} img {{ max-width: 100%; \
             border: 1px solid #ddd; margin-bottom: 2rem }}</style>\n<h1>{title}</h1>\n<ol>"
        )?;
        for step in &self.steps {
            let heading = step.figure.title().split_once(" · ").map_or("", |(_, text)| text);
            writeln!(out, "<li><a href=\"#{}\">{}</a></li>", step.file, escaped(heading))?;
        }
        writeln!(out, "</ol>")?;
        for Step { file, figure } in &self.steps {
            let (heading, text) = (escaped(figure.title()), escaped(figure.caption()));
            writeln!(out, "<img id=\"{file}\" src=\"{file}\" alt=\"{heading}. {text}\">")?;
        }
        writeln!(out, "</html>")
    }
}

fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    text.replace('"', "&quot;")
}
