//! Traces as files: CSV for all, MAT for MATLAB and Octave, Parquet for data frames.
//!
//! MAT and Parquet files also contain a [`Description`] of the run and the unit of each column.
//! Rows are written as they arrive, so that a trace may be larger than the memory.

pub mod csv;
pub mod description;
pub mod mat;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod unit;

use std::path::{Path, PathBuf};

pub use description::Description;

use crate::{
    error,
    file::{WholeFile, WriteError},
    simulate::{Rows, Simulation},
};
use csv::Csv;
use mat::Mat;

/// The names that a trace file takes.
pub const EXPECTED_NAME: &str = "a name that ends in .csv, .mat or .parquet";

/// Why a trace file is not written.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The name has no known suffix.
    #[error("the trace file is {}, expected {EXPECTED_NAME}", .0.display())]
    Name(PathBuf),
    /// The file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The run has more rows than the format.
    #[error(
        "{} would have {rows} rows, expected at most {most}: a variable of a MAT file holds 2 GiB; \
         a greater --every, a smaller --duration, or another format",
        path.display()
    )]
    TooLong {
        /// The file.
        path: PathBuf,
        /// Rows of the run.
        rows: u64,
        /// The most rows of the format.
        most: u64,
    },
    /// This build lacks the format.
    #[cfg(not(feature = "parquet"))]
    #[error(
        "{}: this program was built without the feature `parquet`, expected \
         `cargo build --release --features parquet`",
        .0.display()
    )]
    WithoutParquet(PathBuf),
}

impl From<Error> for error::Error {
    fn from(error: Error) -> Self {
        match error {
            Error::Write(error) => error.into(),
            Error::Name(path) => Self::Option {
                option: "--out",
                value: path.display().to_string(),
                expected: EXPECTED_NAME,
            },
            refused => Self::Conflict(refused.to_string()),
        }
    }
}

/// The format of a trace file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Comma-separated text with a header.
    Csv,
    /// MAT level 5.
    Mat,
    /// Apache Parquet, with the feature `parquet`.
    Parquet,
}

impl Format {
    /// The format of the suffix of a file name.
    ///
    /// # Errors
    /// [`Error::Name`] unless the name ends in `.csv`, `.mat` or `.parquet`.
    pub fn of(path: &Path) -> Result<Self, Error> {
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("mat") => Ok(Self::Mat),
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(Error::Name(path.into())),
        }
    }
}

/// A file for the rows of a run.
pub struct TraceFile {
    path: PathBuf,
    writer: Writer,
}

enum Writer {
    Csv(Csv<WholeFile>),
    Mat(Mat<WholeFile>),
    #[cfg(feature = "parquet")]
    Parquet(parquet::Parquet<WholeFile>),
}

impl TraceFile {
    /// Opens the file for the rows of this run.
    ///
    /// # Errors
    /// [`Error::Write`], and others if the run exceeds the format or this build lacks it.
    pub fn create(
        path: &Path,
        format: Format,
        simulation: &Simulation,
        description: &Description,
    ) -> Result<Self, Error> {
        let columns = simulation.columns();
        let file = || WholeFile::create(path);
        let writer = match format {
            Format::Csv => file().and_then(|file| Ok(Writer::Csv(Csv::create(file, &columns)?))),
            Format::Mat => {
                let rows = simulation.rows();
                let most = mat::most_rows(columns.len());
                if rows > most {
                    let path = path.into();
                    return Err(Error::TooLong { path, rows, most });
                }
                let mat = file().and_then(|file| Mat::create(file, &columns, rows, description));
                mat.map(Writer::Mat)
            }
            #[cfg(feature = "parquet")]
            Format::Parquet => file()
                .and_then(|file| parquet::Parquet::create(file, &columns, description))
                .map(Writer::Parquet),
            #[cfg(not(feature = "parquet"))]
            Format::Parquet => return Err(Error::WithoutParquet(path.into())),
        };
        let writer = writer.map_err(|source| WriteError::new(path, source))?;
        Ok(Self {
            path: path.into(),
            writer,
        })
    }

    /// Completes the file and renames it.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn finish(self) -> Result<(), Error> {
        let file = match self.writer {
            Writer::Csv(csv) => Ok(csv.finish()),
            Writer::Mat(mat) => mat.finish(),
            #[cfg(feature = "parquet")]
            Writer::Parquet(parquet) => parquet.finish(),
        };
        let result = file.and_then(WholeFile::complete);
        Ok(result.map_err(|source| WriteError::new(&self.path, source))?)
    }
}

impl Rows for TraceFile {
    fn row(&mut self, values: &[f64]) -> Result<(), error::Error> {
        let result = match &mut self.writer {
            Writer::Csv(csv) => csv.row(values),
            Writer::Mat(mat) => mat.row(values),
            #[cfg(feature = "parquet")]
            Writer::Parquet(parquet) => parquet.row(values),
        };
        Ok(result.map_err(|source| WriteError::new(&self.path, source))?)
    }
}
