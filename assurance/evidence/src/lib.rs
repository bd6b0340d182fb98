//! The experiments on the project, and the sources on which their results depend.
//!
//! `assurance/evidence.toml` says for each experiment what it shows, its command, and the commit
//! and a hash of the sources that it last ran with. A result is stale as soon as one of these
//! sources has changed. The hash is that of the names and contents that git has of them, so that it
//! is computed without reading a file.

mod list;
mod record;
mod sources;

use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

pub use list::{Evidence, Experiment, State};
pub use record::record;
pub use sources::Repository;

/// Why the experiments cannot be listed or recorded.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// The file has another structure.
    #[error("{}: {source}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        source: Box<toml_edit::de::Error>,
    },
    /// git did not start.
    #[error("cannot run git: {0}")]
    Start(io::Error),
    /// git failed.
    #[error("`git {command}` failed ({status}): {message}")]
    Git {
        /// Its arguments.
        command: String,
        /// The exit status.
        status: ExitStatus,
        /// What it printed.
        message: String,
    },
    /// An experiment depends on a source that does not exist.
    #[error("no file of the repository is named {0}")]
    NoSource(String),
    /// There is no such experiment.
    #[error("no experiment {0}")]
    NoExperiment(String),
    /// The experiment has not run with the sources of a commit.
    #[error("{id}: not committed:\n{files}")]
    Uncommitted {
        /// The experiment.
        id: String,
        /// Its sources that differ from the last commit.
        files: String,
    },
}
