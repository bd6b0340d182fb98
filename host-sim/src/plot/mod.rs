//! Figures: SVG for papers, self-contained interactive HTML for the desk.
//!
//! A [`Figure`] says what is shown; [`svg::render`] and [`html::render`] draw it, and [`save`]
//! chooses between them by the name of the file.

use std::io;
use std::path::Path;

mod axis;
pub mod figure;
pub mod html;
pub mod palette;
pub mod points;
pub mod svg;

pub use figure::{Figure, Panel, Scale, Series, Style};
pub use palette::Colours;

/// Writes a figure as `FILE.svg` or as a self-contained page `FILE.html`.
///
/// # Errors
/// If the name ends in anything else, or the file cannot be written. The message names the file.
pub fn save(figure: &Figure, path: &Path) -> io::Result<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("svg") => write_file(path, &svg::render(figure)),
        Some("html") => write_file(path, &html::render(figure)),
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!(
                "{}: a plot's name must end in .svg or .html",
                path.display()
            ),
        )),
    }
}

/// Writes a text file; the error names it.
pub(crate) fn write_file(path: &Path, text: &str) -> io::Result<()> {
    std::fs::write(path, text)
        .map_err(|e| io::Error::new(e.kind(), format!("cannot write {}: {e}", path.display())))
}

#[cfg(test)]
mod tests;
