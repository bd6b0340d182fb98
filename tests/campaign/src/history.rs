//! The counts of all campaigns so far, of any program, in a CSV file.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::injection::Place;
use crate::outcome::{Basis, Outcome, Verdict};
use crate::results::{ResultsError, at, in_line};

/// Outcomes of the new injections of one campaign in one place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Entry {
    /// First bytes of the hash of the flashed program.
    pub program: String,
    /// Seed of the injections.
    pub seed: u64,
    /// Where they were made.
    pub place: Place,
    /// Number of injections.
    pub injections: u64,
    /// Of these, decided by a recording; an experiment was made for each of the others.
    pub recorded: u64,
    /// Of these, told, but with a shaft that coasted for longer than the limit.
    pub coasting: u64,
    /// Of these, told, but driven on for longer than the limit.
    pub driven: u64,
    /// Of these, silent and hazardous.
    pub hazardous: u64,
    /// Of these, not judged.
    pub unjudged: u64,
}

impl Entry {
    /// The counts of these verdicts.
    pub fn new(program: &str, seed: u64, place: Place, verdicts: &[Verdict]) -> Self {
        let count = |outcome| {
            let with_it = verdicts.iter().filter(|verdict| verdict.outcome == outcome);
            with_it.count() as u64
        };
        Self {
            program: program.to_owned(),
            seed,
            place,
            injections: verdicts.len() as u64,
            recorded: recorded(verdicts),
            coasting: count(Outcome::Coasting),
            driven: count(Outcome::Driven),
            hazardous: count(Outcome::Hazardous),
            unjudged: count(Outcome::Unjudged),
        }
    }
}

/// Number of verdicts by a recording.
pub fn recorded(verdicts: &[Verdict]) -> u64 {
    let by_recording = |verdict: &&Verdict| verdict.basis == Basis::Recording;
    verdicts.iter().filter(by_recording).count() as u64
}

/// Replaces the entries of the same campaigns and places in the file, adds the others, and returns
/// all that it then has.
///
/// # Errors
/// The file cannot be read or written, or a line is no entry.
pub fn update(path: &Path, entries: &[Entry]) -> Result<Vec<Entry>, ResultsError> {
    let mut all: Vec<Entry> = Vec::new();
    if path.exists() {
        let mut reader = csv::Reader::from_path(path).map_err(in_line(path))?;
        let read = reader.deserialize().collect::<Result<_, _>>();
        all = read.map_err(in_line(path))?;
    }
    for entry in entries {
        let key = |entry: &Entry| (entry.program.clone(), entry.seed, entry.place);
        match all.iter_mut().find(|other| key(other) == key(entry)) {
            Some(other) => *other = entry.clone(),
            None => all.push(entry.clone()),
        }
    }
    let mut writer = csv::Writer::from_path(path).map_err(in_line(path))?;
    for entry in &all {
        writer.serialize(entry).map_err(in_line(path))?;
    }
    writer.flush().map_err(|source| at(path, source))?;
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_of_all_campaigns_are_kept_and_those_of_the_same_one_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("history.csv");
        let hazardous = Verdict {
            outcome: Outcome::Hazardous,
            ..Verdict::UNJUDGED
        };
        let verdicts = [Verdict::UNJUDGED, hazardous, hazardous];
        let first = [Entry::new("a", 1, Place::Ram, &verdicts)];
        let counts = (first[0].injections, first[0].hazardous, first[0].unjudged);
        assert_eq!(counts, (3, 2, 1));
        let second = [Entry::new("b", 2, Place::Period, &verdicts[..1])];
        assert_eq!(update(&path, &first).unwrap(), first);
        assert_eq!(
            update(&path, &second).unwrap(),
            [first, second.clone()].concat()
        );
        let again = [Entry::new("a", 1, Place::Ram, &verdicts[..2])];
        assert_eq!(
            update(&path, &again).unwrap(),
            [again.clone(), second].concat()
        );
        std::fs::write(&path, "program,seed\na,x\n").unwrap();
        let error = update(&path, &[]).unwrap_err().to_string();
        assert!(error.contains("history.csv"), "{error}");
    }
}
