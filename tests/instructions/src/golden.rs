//! The golden counts: a line with name and count for each workload.

use std::{fmt::Write as _, fs, io, path::PathBuf};

use crate::Error;

/// Counts by the name of the workload, in their order.
#[derive(Debug, Default)]
pub struct Golden(Vec<(String, u64)>);

fn path() -> PathBuf {
    PathBuf::from(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../golden/instructions.txt"
    ))
}

impl Golden {
    /// The counts in the tree; none without a file.
    ///
    /// # Errors
    /// For a file that cannot be read or holds something else.
    pub fn read() -> Result<Self, Error> {
        let path = path();
        let text = match fs::read_to_string(&path) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            result => result.map_err(|source| Error::File {
                path: path.clone(),
                source,
            })?,
        };
        let count = |line: &str| {
            let (name, count) = line.split_once(' ')?;
            Some((name.to_owned(), count.trim().parse().ok()?))
        };
        let counts = text.lines().map(|line| {
            count(line).ok_or_else(|| Error::Line {
                path: path.clone(),
                line: line.to_owned(),
            })
        });
        counts.collect::<Result<_, _>>().map(Self)
    }

    /// The count of a workload.
    pub fn of(&self, name: &str) -> Option<u64> {
        let found = self.0.iter().find(|(own, _)| own == name);
        found.map(|(_, count)| *count)
    }

    /// Appends a count.
    pub fn push(&mut self, name: &str, count: u64) {
        self.0.push((name.to_owned(), count));
    }

    /// Replaces the counts in the tree.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self) -> Result<(), Error> {
        let mut text = String::new();
        for (name, count) in &self.0 {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name:<28} {count:>12}");
        }
        let path = path();
        fs::write(&path, text).map_err(|source| Error::File { path, source })
    }
}
