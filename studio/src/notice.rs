//! Events that concern the operator of the server.

use std::fmt;

/// An event for standard error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Notice {
    /// A connection was refused.
    Refused {
        /// Address of the other side.
        from: String,
        /// The reason.
        why: &'static str,
    },
    /// There are as many connections as the server accepts.
    Full {
        /// Their number.
        connections: usize,
        /// Number of refused connections since the last such notice.
        refused: u64,
    },
    /// A page was closed by the server.
    Closed {
        /// Address of the other side.
        from: String,
        /// The reason.
        why: String,
    },
    /// A change of the bus, of an actuator, or of who controls them.
    Event(String),
}

impl fmt::Display for Notice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused { from, why } => write!(f, "refused {from}: {why}"),
            Self::Full {
                connections,
                refused,
            } => write!(
                f,
                "refused {refused} connections: there are {connections} already"
            ),
            Self::Closed { from, why } => write!(f, "closed the page at {from}: {why}"),
            Self::Event(text) => write!(f, "{text}"),
        }
    }
}
