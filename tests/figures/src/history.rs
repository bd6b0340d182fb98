//! Every measurement so far: a line of JSON each.

use std::{collections::BTreeMap, fs, path::Path};

use serde::{Deserialize, Serialize};

use crate::{Error, machine::Machine, timing::Figure};

/// The least and the greatest value of a figure over the runs, and their median.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Range {
    /// Its unit.
    pub unit: String,
    /// Least value.
    pub least: f64,
    /// Median.
    pub median: f64,
    /// Greatest value.
    pub greatest: f64,
}

/// One line: when, on what, and what came out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Entry {
    /// Date, UTC.
    pub date: String,
    /// Commit.
    pub commit: String,
    /// Processor.
    pub processor: String,
    /// Load average before the first run.
    pub load: String,
    /// Number of runs.
    pub runs: usize,
    /// The figures by name.
    pub figures: BTreeMap<String, Range>,
}

impl Entry {
    /// The ranges of these runs.
    pub fn of(machine: &Machine, runs: &[Vec<Figure>]) -> Self {
        let mut values: BTreeMap<&str, (&str, Vec<f64>)> = BTreeMap::new();
        for figure in runs.iter().flatten() {
            let (_, values) = values
                .entry(&figure.name)
                .or_insert((&figure.unit, Vec::new()));
            values.push(figure.value);
        }
        let range = |(name, (unit, mut values)): (&str, (&str, Vec<f64>))| {
            values.sort_by(f64::total_cmp);
            let range = Range {
                unit: unit.to_owned(),
                least: values.first().copied().unwrap_or_default(),
                median: values.get(values.len() / 2).copied().unwrap_or_default(),
                greatest: values.last().copied().unwrap_or_default(),
            };
            (name.to_owned(), range)
        };
        Self {
            date: machine.date.clone(),
            commit: machine.commit.clone(),
            processor: machine.processor.clone(),
            load: machine.load.clone(),
            runs: runs.len(),
            figures: values.into_iter().map(range).collect(),
        }
    }
}

/// Appends an entry to the file and returns all.
///
/// # Errors
/// If the file cannot be read or written, or holds something else.
pub fn append(path: &Path, entry: Entry) -> Result<Vec<Entry>, Error> {
    let file = |source| Error::Write {
        path: path.to_owned(),
        source,
    };
    let text = if path.exists() {
        fs::read_to_string(path).map_err(file)?
    } else {
        String::new()
    };
    let json = |error: serde_json::Error| file(error.into());
    let entries = text.lines().map(serde_json::from_str);
    let mut entries: Vec<Entry> = entries.collect::<Result<_, _>>().map_err(json)?;
    let line = serde_json::to_string(&entry).map_err(json)?;
    fs::write(path, format!("{text}{line}\n")).map_err(file)?;
    entries.push(entry);
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
        Machine {
            commit: "abc".into(),
            date: "2026-01-01".into(),
            processor: "p".into(),
            load: "0.1".into(),
            compiler: "rustc".into(),
        }
    }

    #[test]
    fn a_line_holds_the_range_of_the_runs_and_every_entry_is_kept() {
        let run = |value| {
            vec![Figure {
                name: "speed".into(),
                value,
                unit: "s/s".into(),
            }]
        };
        let entry = Entry::of(&machine(), &[run(3.0), run(1.0), run(2.0)]);
        let range = &entry.figures["speed"];
        assert_eq!((range.least, range.median, range.greatest), (1.0, 2.0, 3.0));
        let place = std::env::temp_dir().join(format!("figures-{}.jsonl", std::process::id()));
        assert_eq!(append(&place, entry.clone()).unwrap().len(), 1);
        let entries = append(&place, entry).unwrap();
        fs::remove_file(&place).unwrap();
        assert_eq!(entries.len(), 2);
    }
}
