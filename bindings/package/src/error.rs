//! Why a release is not made.

use std::{
    io,
    path::{Path, PathBuf},
    process::ExitStatus,
};

/// Why a release is not made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file or folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A tool did not start.
    #[error("cannot run `{command}`: {source}")]
    Start {
        /// The command.
        command: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A tool failed.
    #[error("`{command}` failed: {status}")]
    Failed {
        /// The command.
        command: String,
        /// Its exit status.
        status: ExitStatus,
    },
    /// A program for another target was not built.
    #[error(transparent)]
    Build(#[from] cross_build::Error),
    /// The program of a board has no valid image.
    #[error(transparent)]
    Image(#[from] program_image::ImageError),
    /// The program of a board cannot be signed.
    #[error(transparent)]
    Sign(#[from] program_image::signed::SignError),
    /// The list of packages is not what was expected.
    #[error("the output of `cargo metadata`: {0}")]
    Metadata(#[from] serde_json::Error),
    /// The list of changes has no section of this version.
    #[error("CHANGELOG.md: no section `## {0}`, the version of the workspace")]
    NoChanges(&'static str),
    /// A file is larger than it may be.
    #[error("{} has {bytes} bytes, expected {most} at most", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Its size.
        bytes: u64,
        /// The greatest size.
        most: u64,
    },
}

/// The error of the operating system at this file.
pub fn at(path: &Path) -> impl Fn(io::Error) -> Error + use<> {
    let path = path.to_owned();
    move |source| Error::File {
        path: path.clone(),
        source,
    }
}
