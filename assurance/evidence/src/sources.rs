//! The sources as git has them.

use std::path::{Path, PathBuf};
use std::process::Command;

use sha2::{Digest, Sha256};

use crate::Error;

/// A repository.
#[derive(Debug, Clone)]
pub struct Repository(PathBuf);

impl Repository {
    /// The repository with its files in this folder.
    pub fn new(folder: &Path) -> Self {
        Self(folder.into())
    }

    /// The hash of the files that these path specifications name: of their modes, contents and
    /// names.
    ///
    /// # Errors
    /// One of them names no file, or git fails.
    pub fn hash(&self, paths: &[&str]) -> Result<String, Error> {
        for path in paths {
            if self.files(&[path])?.is_empty() {
                return Err(Error::NoSource((*path).into()));
            }
        }
        Ok(format!("{:x}", Sha256::digest(self.files(paths)?)))
    }

    fn files(&self, paths: &[&str]) -> Result<String, Error> {
        self.git(&[&["ls-files", "--stage", "--"], paths].concat())
    }

    /// Those of the files that differ from the last commit, a line each.
    ///
    /// # Errors
    /// git fails.
    pub fn uncommitted(&self, paths: &[&str]) -> Result<String, Error> {
        self.git(&[&["status", "--porcelain", "--"], paths].concat())
    }

    /// The abbreviated name of the last commit.
    ///
    /// # Errors
    /// git fails.
    pub fn commit(&self) -> Result<String, Error> {
        let name = self.git(&["rev-parse", "--short=10", "HEAD"])?;
        Ok(name.trim().into())
    }

    fn git(&self, arguments: &[&str]) -> Result<String, Error> {
        let mut command = Command::new("git");
        command.current_dir(&self.0).args(arguments);
        let output = command.output().map_err(Error::Start)?;
        if !output.status.success() {
            return Err(Error::Git {
                command: arguments.join(" "),
                status: output.status,
                message: String::from_utf8_lossy(&output.stderr).trim().into(),
            });
        }
        Ok(String::from_utf8_lossy(&output.stdout).into())
    }
}
