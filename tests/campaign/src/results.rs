//! The results of a campaign in a file, so that it can be ended and continued.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use cross_build::board_elf;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::injection::{Injection, Place};
use crate::outcome::Outcome;

/// Why results cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ResultsError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A line is no result.
    #[error("{}: {source}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// What is wrong, and in which line.
        source: csv::Error,
    },
}

/// A result. Those of another program or seed stay in the file and do not count.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
struct Line {
    program: String,
    seed: u64,
    place: Place,
    number: u64,
    outcome: Outcome,
}

/// The results of a program and a seed.
#[derive(Debug, Default)]
pub struct Results {
    /// The file, if they are kept.
    path: Option<PathBuf>,
    program: String,
    seed: u64,
    known: BTreeMap<(Place, u64), Outcome>,
}

impl Results {
    /// Results of the board's program with this seed: those in the file, if one is given.
    ///
    /// # Errors
    /// The file or the program cannot be read, or a line is no result.
    pub fn open(path: Option<&Path>, seed: u64) -> Result<Self, ResultsError> {
        let elf = board_elf();
        let bytes = std::fs::read(elf).map_err(|source| at(elf, source))?;
        let hash = Sha256::digest(bytes);
        let program = hash[..8].iter().map(|byte| format!("{byte:02x}")).collect();
        Self::of(path, program, seed)
    }

    fn of(path: Option<&Path>, program: String, seed: u64) -> Result<Self, ResultsError> {
        let mut results = Self {
            path: path.map(Path::to_owned),
            program,
            seed,
            known: BTreeMap::new(),
        };
        if let Some(path) = path.filter(|path| path.exists()) {
            let line_error = |source| ResultsError::Line {
                path: path.into(),
                source,
            };
            let mut reader = csv::Reader::from_path(path).map_err(line_error)?;
            for line in reader.deserialize() {
                let line: Line = line.map_err(line_error)?;
                if (&line.program, line.seed) == (&results.program, seed) {
                    results
                        .known
                        .insert((line.place, line.number), line.outcome);
                }
            }
        }
        Ok(results)
    }

    /// The outcome of an injection that has been judged.
    pub fn outcome(&self, place: Place, number: u64) -> Option<Outcome> {
        self.known.get(&(place, number)).copied()
    }

    /// Adds results, and writes them.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, judged: &[(Injection, Outcome)]) -> Result<(), ResultsError> {
        for (injection, outcome) in judged {
            let key = (injection.place, injection.number);
            self.known.insert(key, *outcome);
        }
        let Some(path) = &self.path else {
            return Ok(());
        };
        let file = OpenOptions::new().create(true).append(true).open(path);
        let file = file.map_err(|source| at(path, source))?;
        let length = file.metadata().map_err(|source| at(path, source))?.len();
        let mut writer = csv::WriterBuilder::new()
            .has_headers(length == 0)
            .from_writer(file);
        for (injection, outcome) in judged {
            let line = Line {
                program: self.program.clone(),
                seed: self.seed,
                place: injection.place,
                number: injection.number,
                outcome: *outcome,
            };
            writer
                .serialize(line)
                .map_err(|source| ResultsError::Line {
                    path: path.clone(),
                    source,
                })?;
        }
        writer.flush().map_err(|source| at(path, source))
    }
}

fn at(path: &Path, source: io::Error) -> ResultsError {
    ResultsError::File {
        path: path.into(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(number: u64, outcome: Outcome) -> (Injection, Outcome) {
        let range = 0..1;
        let draw = |number| Injection::draw(1, number, Place::Ram, std::slice::from_ref(&range));
        (draw(number), outcome)
    }

    #[test]
    fn results_of_the_same_program_and_seed_are_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        let open = |program: &str, seed| Results::of(Some(&path), program.into(), seed).unwrap();
        open("a", 1).add(&[judged(3, Outcome::Told)]).unwrap();
        open("a", 1).add(&[judged(4, Outcome::NoEffect)]).unwrap();
        open("b", 1).add(&[judged(5, Outcome::Hazardous)]).unwrap();
        let again = open("a", 1);
        let found = [3, 4, 5].map(|number| again.outcome(Place::Ram, number));
        assert_eq!(found, [Some(Outcome::Told), Some(Outcome::NoEffect), None]);
        assert_eq!(again.outcome(Place::Code, 3), None);
        assert_eq!(open("a", 2).outcome(Place::Ram, 3), None);
    }

    #[test]
    fn a_line_that_is_no_result_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        std::fs::write(&path, "program,seed,place,number,outcome\na,1,ram,x,told\n").unwrap();
        let error = Results::of(Some(&path), "a".into(), 1)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("results.csv") && error.contains("line: 2"),
            "{error}"
        );
    }
}
