//! The options that overviews and pictures of points share.

use super::canvas::escaped;
use std::io::{self, Write};

/// The direction of view, the size and the heading of an overview.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct OverviewOptions {
    /// The picture's heading.
    pub title: String,
    /// Direction to the viewer around the guide: 0 along the planes' x axis, 90 along y.
    pub azimuth_deg: f64,
    /// Height of the viewer above the planes; between 0 and 90.
    pub elevation_deg: f64,
    /// Width in pixels.
    pub width: f64,
    /// Height in pixels.
    pub height: f64,
}

impl Default for OverviewOptions {
    /// Seen from the front right of the planes' axes and from above, 1400 × 1000 pixels.
    fn default() -> Self {
        Self {
            title: "Cross-section model".to_owned(),
            azimuth_deg: -60.0,
            elevation_deg: 30.0,
            width: 1400.0,
            height: 1000.0,
        }
    }
}

impl OverviewOptions {
    /// The root element and white paper.
    pub(super) fn write_opening(&self, out: &mut dyn Write) -> io::Result<()> {
        let (width, height, title) = (self.width, self.height, escaped(&self.title));
        writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, sans-serif\" \
         font-size=\"16\" fill=\"#222\">\n<title>{title}</title>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>"
        )
    }
}
