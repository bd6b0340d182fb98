//! The paper's study, redone: the board's program on the emulated board in closed loop, the paper's
//! three models fitted to what it did, and each claim of the paper held against that.
//!
//! [`runs`] makes the data, [`models`] fits them, [`claims`] judges, [`page`] and [`figures`] show.
//! Everything is seeded: the same program makes the same files.

pub mod bench;
pub mod claims;
pub mod figures;
pub mod link;
pub mod measures;
pub mod models;
pub mod page;
pub mod runs;
pub mod study;

use identification::{IdentifyError, RecordingError};
use model_core::parameter::ParameterError;
use virtual_board::run::{FirmwareError, RunError};

/// Why there is no study.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// An input has another name.
    #[error("no input is called {0}")]
    NoInput(&'static str),
    /// A model has another name.
    #[error("no model is called {0}")]
    NoModel(&'static str),
    /// A claim cannot be judged.
    #[error("the study lacks runs that a claim is judged by")]
    Incomplete,
    /// Nothing could be compared.
    #[error("a model and a recording have no sample in common")]
    Nothing,
    /// An input or a model does not take a parameter.
    #[error("parameter {0}")]
    Parameter(#[from] ParameterError),
    /// The board's program cannot be read.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The board does not run.
    #[error(transparent)]
    Board(Box<RunError>),
    /// A run ended otherwise than it should.
    #[error("{0}: {1}")]
    Run(String, link::RunProblem),
    /// The emulation lacks something: the run proves nothing.
    #[error("{0}: what the emulation does not have:\n{1}")]
    Gaps(String, String),
    /// A recording cannot be used.
    #[error("{0}: {1}")]
    Recording(String, RecordingError),
    /// A model cannot be fitted.
    #[error(transparent)]
    Identify(Box<IdentifyError>),
    /// A file cannot be read or written, or a model cannot be simulated.
    #[error(transparent)]
    Program(Box<host_sim::error::Error>),
}

/// Boxed: a result is moved more often than it is a failure.
macro_rules! boxed {
    ($($Variant:ident: $Error:ty),+ $(,)?) => {
        $(impl From<$Error> for Failure {
            fn from(error: $Error) -> Self {
                Self::$Variant(Box::new(error))
            }
        })+
    };
}

boxed! {
    Board: RunError,
    Identify: IdentifyError,
    Program: host_sim::error::Error,
}
