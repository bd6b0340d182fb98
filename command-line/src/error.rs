//! The errors of all commands, with their exit statuses.

use std::{io, process::ExitCode};

use host_sim::{
    can::{client::ClientError, update::UpdateError},
    commission::CommissionError,
    dronecan_client::NodeError,
    error::Error as SimulatorError,
    file::{CheckError, WriteError},
    plot,
    servo_bus::client::ServoError,
    trace_file,
};
use identification::{
    IdentifyError, data::ImportError, parameter_file::NotSimulated, request::RequestError,
};
use model_core::{parameter::ParameterError, scenario::ScenarioError};
use program_image::signed::SignError;

/// Exit status after an interrupt, as shells report it.
const INTERRUPTED: u8 = 130;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A scenario, an input, a file or a run.
    #[error(transparent)]
    Simulator(#[from] SimulatorError),
    /// An identification.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
    /// A bus or an actuator on it.
    #[error(transparent)]
    Bus(#[from] ClientError),
    /// A serial bus or a servo on it.
    #[error(transparent)]
    Servo(#[from] ServoError),
    /// A DroneCAN node or its bus.
    #[error(transparent)]
    Node(#[from] NodeError),
    /// A bus cannot be served.
    #[error("cannot serve at {address}: {source}")]
    Serve {
        /// Address or device.
        address: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// An actuator was not updated.
    #[error(transparent)]
    Update(#[from] UpdateError),
    /// An image or a key.
    #[error(transparent)]
    Image(#[from] SignError),
    /// The page or its bus.
    #[error(transparent)]
    Studio(#[from] studio::StudioError),
    /// The emulated board.
    #[cfg(feature = "board")]
    #[error("{0}")]
    Board(String),
    /// The value of an option is refused.
    #[error("{option} is {value}, expected {expected}")]
    Option {
        /// The option.
        option: &'static str,
        /// The value.
        value: String,
        /// The values that it takes.
        expected: &'static str,
    },
    /// Fits of these models are not those of an optimum.
    #[error("the search has not converged: the values of {} are not those of an optimum", .0.join(", "))]
    NotConverged(Vec<String>),
    /// A step of a commissioning refuses.
    #[error(transparent)]
    Commission(CommissionError),
    /// What was found is not written.
    #[error("{0}")]
    Refused(String),
    /// Options exclude each other, or a request cannot be met.
    #[error("{0}")]
    Conflict(String),
}

impl Error {
    /// Prints the error to standard error, and returns the exit status.
    pub fn report(self) -> ExitCode {
        if self.is_closed_pipe() {
            return ExitCode::FAILURE;
        }
        note!("error: {self}");
        ExitCode::from(match self {
            refusal if refusal.is_refusal() => 3,
            Self::NotConverged(_) | Self::Commission(_) | Self::Refused(_) => 3,
            Self::Update(UpdateError::Hardware { .. }) => 2,
            Self::Update(_) => 1,
            Self::Bus(ClientError::Interrupted) => INTERRUPTED,
            Self::Bus(error) if error.is_at_limit() => 4,
            Self::Bus(error) if error.is_invalid_request() => 2,
            Self::Image(SignError::File { .. }) => 1,
            Self::Servo(
                ServoError::Bus { .. } | ServoError::NoAnswer(_) | ServoError::NotReached { .. },
            ) => 1,
            Self::Node(NodeError::Value { .. } | NodeError::NoParameter(..)) => 2,
            Self::Node(_) | Self::Bus(_) | Self::Serve { .. } | Self::Studio(_) => 1,
            Self::Simulator(SimulatorError::Read { .. } | SimulatorError::Write(_)) => 1,
            _ => 2,
        })
    }

    /// Whether the actuator has refused.
    pub fn is_refusal(&self) -> bool {
        match self {
            Self::Bus(error) => error.is_refusal(),
            Self::Update(error) => error.is_refusal(),
            Self::Servo(error) => matches!(error, ServoError::Refused { .. }),
            Self::Node(error) => matches!(error, NodeError::Kept { .. }),
            _ => false,
        }
    }

    /// Whether the reader of standard output has closed it, which needs no message.
    fn is_closed_pipe(&self) -> bool {
        matches!(
            self,
            Self::Simulator(SimulatorError::Write(error))
                if error.source.kind() == io::ErrorKind::BrokenPipe
        )
    }
}

macro_rules! of_the_simulator {
    ($($Error:ty),+) => {$(
        impl From<$Error> for Error {
            fn from(error: $Error) -> Self {
                SimulatorError::from(error).into()
            }
        }
    )+};
}

of_the_simulator!(
    ParameterError,
    ScenarioError<'_>,
    ImportError,
    WriteError,
    CheckError,
    plot::Error,
    trace_file::Error
);

impl From<RequestError> for Error {
    fn from(error: RequestError) -> Self {
        match error {
            RequestError::UnknownParameter { name, known } => {
                let expected = known.join(", ");
                SimulatorError::unknown("parameter", &name, known, expected).into()
            }
            RequestError::Conflict(problem) => Self::Conflict(problem),
        }
    }
}

impl From<NotSimulated> for Error {
    fn from(error: NotSimulated) -> Self {
        Self::Conflict(error.to_string())
    }
}
