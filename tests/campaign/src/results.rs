//! The results of a campaign in a file, so that it can be ended and continued.

use std::collections::BTreeMap;
use std::fs::OpenOptions;
use std::io;
use std::path::{Path, PathBuf};

use cross_build::board_elf;
use program_image::ImageError;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::injection::{Injection, Place};
use crate::motion::Motion;
use crate::outcome::{Basis, Outcome, Verdict};

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
    /// The program cannot be read.
    #[error(transparent)]
    Program(#[from] ImageError),
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
    /// First bytes of the hash of the flashed program.
    program: String,
    seed: u64,
    place: Place,
    number: u64,
    motion: Motion,
    address: u64,
    bit: u8,
    at_ms: u32,
    instructions: u32,
    outcome: Outcome,
    told_ms: Option<u32>,
    safe_ms: u32,
    pc: u32,
    /// Absent in results of campaigns that simulated each injection.
    #[serde(default)]
    basis: Basis,
}

impl Line {
    fn result(&self) -> (Injection, Verdict) {
        let injection = Injection {
            number: self.number,
            place: self.place,
            address: self.address,
            bit: self.bit,
            at_ms: self.at_ms,
            instructions: self.instructions,
            motion: self.motion,
        };
        let verdict = Verdict {
            outcome: self.outcome,
            told_ms: self.told_ms,
            safe_ms: self.safe_ms,
            pc: self.pc,
            basis: self.basis,
        };
        (injection, verdict)
    }
}

/// The results of a program and a seed.
#[derive(Debug, Default)]
pub struct Results {
    /// The file, if they are kept.
    path: Option<PathBuf>,
    program: String,
    seed: u64,
    known: BTreeMap<(Place, u64), (Injection, Verdict)>,
}

impl Results {
    /// Results of the board's program with this seed: those in the file, if one is given.
    ///
    /// # Errors
    /// The file or the program cannot be read, or a line is no result.
    pub fn open(path: Option<&Path>, seed: u64) -> Result<Self, ResultsError> {
        // Not of the ELF file, whose line numbers change with comments.
        let hash = Sha256::digest(program_image::flash(board_elf())?);
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
            let mut reader = csv::Reader::from_path(path).map_err(in_line(path))?;
            for line in reader.deserialize() {
                let line: Line = line.map_err(in_line(path))?;
                if (&line.program, line.seed) == (&results.program, seed) {
                    let (injection, verdict) = line.result();
                    let key = (injection.place, injection.number);
                    results.known.insert(key, (injection, verdict));
                }
            }
        }
        Ok(results)
    }

    /// First bytes of the hash of the flashed program.
    pub fn program(&self) -> &str {
        &self.program
    }

    /// The verdict on an injection that has been carried out: one of the same number into another
    /// place, or at another instant, does not count.
    pub fn verdict(&self, injection: &Injection) -> Option<Verdict> {
        let key = (injection.place, injection.number);
        let known = self.known.get(&key).filter(|(it, _)| it == injection);
        known.map(|(_, verdict)| *verdict)
    }

    /// Adds a result, and writes it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn add(&mut self, injection: &Injection, verdict: Verdict) -> Result<(), ResultsError> {
        let key = (injection.place, injection.number);
        self.known.insert(key, (*injection, verdict));
        let Some(path) = &self.path else {
            return Ok(());
        };
        let line = Line {
            program: self.program.clone(),
            seed: self.seed,
            place: injection.place,
            number: injection.number,
            motion: injection.motion,
            address: injection.address,
            bit: injection.bit,
            at_ms: injection.at_ms,
            instructions: injection.instructions,
            outcome: verdict.outcome,
            told_ms: verdict.told_ms,
            safe_ms: verdict.safe_ms,
            pc: verdict.pc,
            basis: verdict.basis,
        };
        append(path, &[line])
    }
}

/// Appends lines to a CSV file, after a header if it is new.
fn append(path: &Path, lines: &[impl Serialize]) -> Result<(), ResultsError> {
    let file = OpenOptions::new().create(true).append(true).open(path);
    let file = file.map_err(|source| at(path, source))?;
    let length = file.metadata().map_err(|source| at(path, source))?.len();
    let mut writer = csv::WriterBuilder::new()
        .has_headers(length == 0)
        .from_writer(file);
    for line in lines {
        writer.serialize(line).map_err(in_line(path))?;
    }
    writer.flush().map_err(|source| at(path, source))
}

/// An error of the operating system at this file.
pub(crate) fn at(path: &Path, source: io::Error) -> ResultsError {
    ResultsError::File {
        path: path.into(),
        source,
    }
}

/// An error in a line of this file.
pub(crate) fn in_line(path: &Path) -> impl Fn(csv::Error) -> ResultsError {
    move |source| ResultsError::Line {
        path: path.into(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_the_same_program_and_seed_are_found_again() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("results.csv");
        let range = 0..1;
        let draw = |number, place| Injection::draw(1, number, place, std::slice::from_ref(&range));
        let verdict = |told_ms| Verdict {
            outcome: Outcome::Told,
            told_ms,
            safe_ms: 9,
            pc: 2,
            basis: Basis::Recording,
        };
        let open = |program: &str, seed| Results::of(Some(&path), program.into(), seed).unwrap();
        for (program, number) in [("a", 3), ("a", 4), ("b", 5)] {
            let told_ms = (number == 3).then_some(20);
            let added = open(program, 1).add(&draw(number, Place::Ram), verdict(told_ms));
            added.unwrap();
        }
        let again = open("a", 1);
        let found = [3, 4, 5].map(|number| again.verdict(&draw(number, Place::Ram)));
        assert_eq!(found, [Some(verdict(Some(20))), Some(verdict(None)), None]);
        assert_eq!(again.verdict(&draw(3, Place::Code)), None);
        let later = Injection {
            at_ms: draw(3, Place::Ram).at_ms + 1,
            ..draw(3, Place::Ram)
        };
        assert_eq!(again.verdict(&later), None);
        assert_eq!(open("a", 2).verdict(&draw(3, Place::Ram)), None);
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
