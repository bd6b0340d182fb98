//! Figures, as SVG for papers or as self-contained interactive HTML.
//!
//! A [`Figure`] describes the content; [`svg::render`] and [`html::render`] draw it, and [`save`]
//! selects the format by the file name.

use std::path::Path;

mod axis;
pub mod figure;
pub mod html;
pub mod palette;
pub mod points;
pub mod svg;
mod trace;

pub use figure::{Figure, Panel, Scale, Series, Style};
pub use palette::Colours;
pub use trace::of_trace;

use crate::{error::Error, file};

/// The file format of a figure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// A vector graphic for a paper.
    Svg,
    /// A self-contained interactive page.
    Html,
}

impl Format {
    /// The format for the extension of a file name.
    ///
    /// # Errors
    /// [`Error::Option`] if the name ends in neither `.svg` nor `.html`.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Svg),
            Some("html") => Ok(Self::Html),
            _ => Err(Error::Option {
                option: "--plot",
                value: path.display().to_string(),
                expected: "a name that ends in .svg or .html",
            }),
        }
    }
}

/// Writes a figure as `FILE.svg` or as a self-contained page `FILE.html`.
///
/// # Errors
/// Those of [`Format::of`], and [`Error::Write`].
pub fn save(figure: &Figure, path: &Path) -> Result<(), Error> {
    let text = match Format::of(path)? {
        Format::Svg => svg::render(figure),
        Format::Html => html::render(figure),
    };
    file::write(path, &text)
}

#[cfg(test)]
mod tests;
