//! Errors of a client.

use std::io;

/// Why a request to a DroneCAN node failed.
#[derive(Debug, thiserror::Error)]
pub enum NodeError {
    /// The bus cannot be opened or used.
    #[error("bus {bus}: {source}")]
    Bus {
        /// Its name.
        bus: String,
        /// The error of the operating system.
        source: io::Error,
    },
    /// A node does not answer.
    #[error("node {0} does not answer; `scan --allocate` gives node-IDs to nodes that have none")]
    NoAnswer(u8),
    /// A node sends no status of an actuator.
    #[error("node {0} sends no actuator.Status")]
    NoStatus(u8),
    /// A node does not have a parameter.
    #[error("node {0} has no parameter {1}")]
    NoParameter(u8, String),
    /// A value that a parameter cannot have.
    #[error("{name} is {value}, expected {expected}")]
    Value {
        /// The parameter.
        name: String,
        /// The value.
        value: String,
        /// The values that it takes.
        expected: String,
    },
    /// The node has kept another value.
    #[error("node {node} keeps {name} at {value}, expected {expected}")]
    Kept {
        /// The node.
        node: u8,
        /// The parameter.
        name: String,
        /// Its value.
        value: String,
        /// The values that it takes.
        expected: String,
    },
    /// A target was not reached in time.
    #[error("node {node} is at {angle_deg:.1} deg, expected {target_deg} deg to be reached")]
    NotReached {
        /// The node.
        node: u8,
        /// Its angle, deg.
        angle_deg: f64,
        /// The target, deg.
        target_deg: f64,
    },
}
