//! Errors of scenarios, inputs, files and runs, with their location and the expected value.
//!
//! Files, plots and trace files have their own errors, which become one of these where an option
//! names the file. The CAN client and the tuning have theirs too; the command line joins all of
//! them.

use std::{io, path::PathBuf};

use model_core::actuator::ModelKind;
use model_core::parameter::ParameterError;
use model_core::scenario::{NameKind, ScenarioError};

use identification::data::ImportError;

use crate::{
    file::{CheckError, WriteError},
    plot,
};

/// Why a run, an analysis or a file is refused.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A file could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// An input file is not a command sequence.
    #[error("{}:{line}: {problem}", path.display())]
    InputFile {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// The content, with its column, and the expected content.
        problem: String,
    },
    /// A scenario file is not TOML, or has an unknown key or a value of another type.
    #[error("{}: {problem}", path.display())]
    ScenarioFile {
        /// The file.
        path: PathBuf,
        /// The line, the key and the expected value.
        problem: String,
    },
    /// An unknown name.
    #[error("unknown {kind} `{name}`{}; expected {expected}", suggestion(closest))]
    UnknownName {
        /// Kind of the named object: `parameter`, `preset`, `input` ...
        kind: &'static str,
        /// The name.
        name: String,
        /// The most similar known name.
        closest: Option<String>,
        /// The names that are expected.
        expected: String,
    },
    /// The value of a parameter is refused.
    #[error("parameter {0}")]
    Parameter(#[from] ParameterError),
    /// The value of an option, or of an entry of a scenario file, is refused.
    #[error("{option} is {value}, expected {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// The value.
        value: String,
        /// The values that it takes.
        expected: &'static str,
    },
    /// An error with its place in a file.
    #[error("{}:{line}: {error}", path.display())]
    At {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// The error.
        error: Box<Error>,
    },
    /// Another thread has ended the run.
    #[error("interrupted")]
    Interrupted,
    /// Options exclude each other, or a request cannot be met.
    #[error("{0}")]
    Conflict(String),
}

fn suggestion(closest: &Option<String>) -> String {
    closest
        .as_ref()
        .map_or(String::new(), |name| format!(", did you mean `{name}`?"))
}

impl From<CheckError> for Error {
    fn from(error: CheckError) -> Self {
        match error {
            CheckError::Write(error) => error.into(),
            twice => Self::Conflict(twice.to_string()),
        }
    }
}

impl From<plot::Error> for Error {
    fn from(error: plot::Error) -> Self {
        match error {
            plot::Error::Write(error) => error.into(),
            plot::Error::Name(path) => Self::Option {
                option: "--plot",
                value: path.display().to_string(),
                expected: plot::EXPECTED_NAME,
            },
        }
    }
}

impl From<ImportError> for Error {
    fn from(error: ImportError) -> Self {
        match error {
            ImportError::Read { path, source } => Self::Read { path, source },
            ImportError::Content {
                path,
                line,
                problem,
            } => Self::InputFile {
                path,
                line,
                problem,
            },
        }
    }
}

/// The similarity of a name to a known one; `None` below that at which a suggestion misleads.
fn similarity(name: &str, known: &str) -> Option<f64> {
    // 1 less the share of letters to be changed.
    const LEAST: f64 = 0.6;
    // `motor_gain` is no misspelt `position_gain`.
    const LEAST_OF_WORD: f64 = 0.5;
    if known.starts_with(name) && !name.is_empty() {
        return Some(LEAST);
    }
    let words = |name| str::split(name, ['_', '-']);
    let are_words_similar = words(name).count() != words(known).count()
        || words(name)
            .zip(words(known))
            .all(|(a, b)| strsim::normalized_damerau_levenshtein(a, b) >= LEAST_OF_WORD);
    let similarity = strsim::normalized_damerau_levenshtein(name, known);
    (are_words_similar && similarity >= LEAST).then_some(similarity)
}

impl From<ScenarioError<'_>> for Error {
    fn from(error: ScenarioError<'_>) -> Self {
        match error {
            ScenarioError::Parameter(error) => Self::Parameter(error),
            ScenarioError::Unknown { kind, name } => {
                let mut known = Vec::new();
                kind.for_each_name(|name| known.push(name));
                let expected = match kind {
                    NameKind::Parameter(ModelKind::Board, plant) => format!(
                        "one that `actuator simulate board --plant {plant} --list-parameters` prints"
                    ),
                    NameKind::Parameter(model, _) => {
                        format!("one that `actuator simulate {model} --list-parameters` prints")
                    }
                    kind => kind.to_string(),
                };
                Self::unknown(kind.label(), name, known, expected)
            }
            error => Self::Conflict(error.to_string()),
        }
    }
}

impl Error {
    /// An [`Error::UnknownName`] that suggests the most similar of these names.
    pub fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
        expected: impl Into<String>,
    ) -> Self {
        let closest = known
            .into_iter()
            .filter(|known| !known.is_empty())
            .filter_map(|known| Some((similarity(name, known)?, known)))
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, known)| known.to_owned());
        Self::UnknownName {
            kind,
            name: name.to_owned(),
            closest,
            expected: expected.into(),
        }
    }
}
