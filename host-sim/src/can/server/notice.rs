//! Events of a server that concern its operator.

use std::{fmt, io};

use super::CLIENTS_MAX;

/// An event for the operator of the server.
#[derive(Debug)]
pub enum Notice {
    /// A client sends more frames than the bus carries; they wait in its connection.
    Slowed {
        /// Name of the client.
        client: String,
    },
    /// A client does not read what it gets.
    Losing {
        /// Name of the client.
        client: String,
    },
    /// A client has lost lines, and reads again or has disconnected.
    Lost {
        /// Name of the client.
        client: String,
        /// Number of lost lines.
        lines: u64,
    },
    /// There are as many clients as the server accepts.
    Full,
    /// The system has no connection for a new client.
    NotAccepted(io::Error),
    /// The computer was too slow for the actuators, or was suspended.
    Late {
        /// Number of control periods that were skipped.
        periods: u64,
    },
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Slowed { client } => write!(
                f,
                "{client} sends more frames than the bus carries: it has to wait"
            ),
            Self::Losing { client } => {
                write!(f, "{client} does not read fast enough: it loses lines")
            }
            Self::Lost { client, lines } => write!(f, "{client} has lost {lines} lines"),
            Self::Full => write!(
                f,
                "there are {CLIENTS_MAX} clients, the most that are accepted: further ones are refused"
            ),
            Self::NotAccepted(error) => {
                write!(f, "new clients have to wait until one disconnects: {error}")
            }
            Self::Late { periods } => write!(
                f,
                "the computer was late: {periods} control periods were skipped"
            ),
        }
    }
}
