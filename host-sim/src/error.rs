//! What can go wrong, said so that it can be mended: what, where, and what was expected.

use std::{
    io,
    path::{Path, PathBuf},
};

use model_core::actuator::ModelKind;
use model_core::parameter::ParameterError;
use model_core::scenario::{Kind, ScenarioError};

use crate::can::client::ClientError;
use identification::{
    IdentifyError, data::ImportError, parameter_file::NotSimulated, request::RequestError,
};

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file could not be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file could not be written.
    #[error("cannot write {}: {source}", sink(path))]
    Write {
        /// The file, or `-` for standard output.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// An input file holds something else than a command sequence.
    #[error("{}:{line}: {problem}", path.display())]
    InputFile {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: u64,
        /// What is there, with its column, and what was expected.
        problem: String,
    },
    /// A scenario file is not TOML, or holds an unknown key or a value of another kind.
    #[error("{}: {problem}", path.display())]
    ScenarioFile {
        /// The file.
        path: PathBuf,
        /// The line, the key and what was expected.
        problem: String,
    },
    /// The emulated board cannot run as it was asked to.
    #[error("{0}")]
    Board(String),
    /// A name that nobody knows.
    #[error("unknown {kind} `{name}`{}; expected {expected}", suggestion(closest))]
    UnknownName {
        /// What should have been named: `parameter`, `preset`, `input` ...
        kind: &'static str,
        /// What was named.
        name: String,
        /// The known name that is most like it.
        closest: Option<String>,
        /// What would have been known.
        expected: String,
    },
    /// A parameter got a value that it cannot take.
    #[error("parameter {0}")]
    Parameter(#[from] ParameterError),
    /// An option, or the entry of a scenario file, got a value that it cannot take.
    #[error("{option} is {value}, expected {expected}")]
    Option {
        /// Which one.
        option: &'static str,
        /// What it was given.
        value: String,
        /// What it takes.
        expected: &'static str,
    },
    /// What went wrong with something that stands in a file.
    #[error("{}:{line}: {error}", path.display())]
    At {
        /// The file.
        path: PathBuf,
        /// The line, counted from 1.
        line: usize,
        /// What went wrong.
        error: Box<Error>,
    },
    /// Nothing could be identified.
    #[error("{0}")]
    Identify(#[from] IdentifyError),
    /// Something could not be done with an actuator on a bus.
    #[error("{0}")]
    Bus(#[from] ClientError),
    /// A bus cannot be served.
    #[error("cannot serve at {place}: {source}")]
    Serve {
        /// Where.
        place: String,
        /// What the system said.
        source: io::Error,
    },
    /// Something that was asked for does not go together.
    #[error("{0}")]
    Conflict(String),
}

fn sink(path: &Path) -> String {
    if path == Path::new("-") {
        return "standard output".into();
    }
    path.display().to_string()
}

fn suggestion(closest: &Option<String>) -> String {
    closest
        .as_ref()
        .map_or(String::new(), |name| format!(", did you mean `{name}`?"))
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

impl From<RequestError> for Error {
    fn from(error: RequestError) -> Self {
        match error {
            RequestError::UnknownParameter { name, known } => {
                let expected = known.join(", ");
                Self::unknown("parameter", &name, known, expected)
            }
            RequestError::Conflict(problem) => Self::Conflict(problem),
        }
    }
}

impl From<ScenarioError<'_>> for Error {
    fn from(error: ScenarioError<'_>) -> Self {
        match error {
            ScenarioError::Parameter(error) => Self::Parameter(error),
            ScenarioError::Unknown { kind, name } => {
                let mut known = Vec::new();
                kind.for_each_name(|name| known.push(name));
                let expected = match kind {
                    Kind::Parameter(ModelKind::Board, plant) => format!(
                        "one that `actuator simulate board --plant {plant} --list-parameters` prints"
                    ),
                    Kind::Parameter(model, _) => {
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

impl From<NotSimulated> for Error {
    fn from(error: NotSimulated) -> Self {
        Self::Conflict(error.to_string())
    }
}

impl Error {
    /// An [`Error::UnknownName`] that knows these names.
    pub fn unknown<'a>(
        kind: &'static str,
        name: &str,
        known: impl IntoIterator<Item = &'a str>,
        expected: impl Into<String>,
    ) -> Self {
        // Below this likeness (Jaro-Winkler, 0 to 1) a guess confuses more than it helps.
        const LIKE_ENOUGH: f64 = 0.8;
        let closest = known
            .into_iter()
            .filter(|known| !known.is_empty())
            .map(|known| (strsim::jaro_winkler(name, known), known))
            .filter(|(likeness, _)| *likeness >= LIKE_ENOUGH)
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
