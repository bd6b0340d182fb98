//! Figures, as SVG for papers or as self-contained interactive HTML.
//!
//! A [`Figure`] describes the content; [`svg::render`] and [`html::render`] draw it, and [`save`]
//! selects the format by the file name.

use std::path::{Path, PathBuf};

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

use crate::file::{self, WriteError};

/// The names that a figure takes.
pub const EXPECTED_NAME: &str = "a name that ends in .svg or .html";

/// Why a figure is not written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The name has no known suffix.
    #[error("the figure is {}, expected {EXPECTED_NAME}", .0.display())]
    Name(PathBuf),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

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
    /// [`Error::Name`] if the name ends in neither `.svg` nor `.html`.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("svg") => Ok(Self::Svg),
            Some("html") => Ok(Self::Html),
            _ => Err(Error::Name(path.into())),
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
    Ok(file::write(path, text)?)
}

#[cfg(test)]
mod tests;
