//! The file of the experiments.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

use serde::Deserialize;

use crate::{Error, Repository};

/// All experiments.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Evidence {
    /// Sources that several experiments have in common, by a name.
    #[serde(default)]
    sources: BTreeMap<String, Vec<String>>,
    /// The experiments.
    #[serde(rename = "experiment")]
    pub experiments: Vec<Experiment>,
}

/// An experiment.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Its name.
    pub id: String,
    /// What it shows.
    pub claim: String,
    /// How it is run.
    pub command: String,
    /// The sources on which its result depends: names of lists of them, and path specifications of
    /// git.
    pub sources: Vec<String>,
    /// Whether it runs on each change; nothing is recorded then.
    #[serde(default)]
    pub each_change: bool,
    /// What the last run found.
    pub result: Option<String>,
    /// The commit of the last run.
    pub commit: Option<String>,
    /// The hash of the sources in that commit; none of a commit before their files were moved.
    pub hash: Option<String>,
}

/// Whether the last result is one of the present sources.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// It runs on each change.
    EachChange,
    /// It is.
    Current,
    /// The sources have changed since.
    Stale,
    /// There is none.
    NotRun,
}

impl State {
    /// Whether the claim is shown for the present sources.
    pub fn is_shown(self) -> bool {
        matches!(self, Self::EachChange | Self::Current)
    }
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::EachChange => "each change",
            Self::Current => "current",
            Self::Stale => "stale",
            Self::NotRun => "not run",
        })
    }
}

impl Evidence {
    /// Reads the file.
    ///
    /// # Errors
    /// It cannot be read, or has another structure.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = fs::read_to_string(path).map_err(|source| Error::File {
            path: path.into(),
            source,
        })?;
        toml_edit::de::from_str(&text).map_err(|source| Error::Format {
            path: path.into(),
            source: Box::new(source),
        })
    }

    /// The experiment of this name.
    ///
    /// # Errors
    /// There is none.
    pub fn experiment(&self, id: &str) -> Result<&Experiment, Error> {
        let mut experiments = self.experiments.iter();
        let found = experiments.find(|experiment| experiment.id == id);
        found.ok_or_else(|| Error::NoExperiment(id.into()))
    }

    /// The path specifications of an experiment's sources.
    pub fn paths<'a>(&'a self, experiment: &'a Experiment) -> Vec<&'a str> {
        let mut paths = Vec::new();
        for source in &experiment.sources {
            match self.sources.get(source) {
                Some(list) => paths.extend(list.iter().map(String::as_str)),
                None => paths.push(source),
            }
        }
        paths
    }

    /// The state of an experiment.
    ///
    /// # Errors
    /// One of its sources does not exist, or git fails.
    pub fn state(&self, experiment: &Experiment, git: &Repository) -> Result<State, Error> {
        let paths = self.paths(experiment);
        let hash = git.hash(&paths)?;
        Ok(match &experiment.hash {
            _ if experiment.each_change => State::EachChange,
            None if experiment.result.is_none() => State::NotRun,
            Some(recorded) if *recorded == hash && git.uncommitted(&paths)?.is_empty() => {
                State::Current
            }
            _ => State::Stale,
        })
    }
}
