//! Replication of the paper's study: the board's program runs on the emulated board in closed loop,
//! the paper's three models are fitted to the recordings, and each claim of the paper is compared
//! with the results.
//!
//! [`runs`] records the data, [`models`] fits the models, [`claims`] evaluates the claims, [`page`]
//! and [`figures`] write the results. All random numbers are seeded: the same program writes the
//! same files.

pub mod claims;
pub mod figures;
pub mod host;
pub mod models;
pub mod page;
pub mod runs;
pub mod spread;
pub mod study;
pub mod test_bench;
pub mod trace_measures;

use host_sim::file::WriteError;
use identification::{IdentifyError, RecordingError};
use model_core::parameter::ParameterError;
use virtual_board::run::{FirmwareError, RunError};

/// Reason why the study failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Unknown name of an input.
    #[error("unknown input {0}")]
    NoInput(&'static str),
    /// Unknown name of a model.
    #[error("unknown model {0}")]
    NoModel(&'static str),
    /// Runs of a claim are missing.
    #[error("the study lacks runs for a claim")]
    Incomplete,
    /// No sample could be compared.
    #[error("a model and a recording have no sample in common")]
    Nothing,
    /// Unknown parameter of an input or a model, or a value outside its range.
    #[error("parameter {0}")]
    Parameter(#[from] ParameterError),
    /// The board's program cannot be read.
    #[error(transparent)]
    Firmware(#[from] FirmwareError),
    /// The run of the board failed.
    #[error(transparent)]
    Board(Box<RunError>),
    /// A run ended with an error.
    #[error("{0}: {1}")]
    Run(String, host::HostError),
    /// The program used something that is not emulated: the run is not valid.
    #[error("{0}: not emulated:\n{1}")]
    Gaps(String, String),
    /// A recording cannot be used.
    #[error("{0}: {1}")]
    Recording(String, RecordingError),
    /// A model cannot be fitted.
    #[error(transparent)]
    Identify(Box<IdentifyError>),
    /// A file cannot be read, or a model cannot be simulated.
    #[error(transparent)]
    Program(Box<host_sim::error::Error>),
    /// A file cannot be written.
    #[error(transparent)]
    Write(Box<WriteError>),
    /// A figure cannot be written.
    #[error(transparent)]
    Figure(Box<host_sim::plot::Error>),
}

/// Conversions of large errors, which are boxed to keep `Result` small.
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
    Write: WriteError,
    Figure: host_sim::plot::Error,
}
