//! A commissioning at the request of any master: object 2055h.

use super::Step;
use crate::can::client::{Client, ClientError};

/// The object.
const OBJECT: &str = "2055";

/// The value of a request.
const REQUESTED: i64 = 1;

/// What the program that commissions writes to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// The commissioning runs: 2.
    Running,
    /// It has ended, and what was found is saved: 3.
    Saved,
    /// It has failed by the bus, a fault, or an interrupt, and nothing is saved: 4.
    Failed,
    /// A step refuses, and nothing is saved: 16 and the number of the step.
    Refused(Step),
}

impl Answer {
    fn value(self) -> u8 {
        match self {
            Self::Running => 2,
            Self::Saved => 3,
            Self::Failed => 4,
            Self::Refused(step) => 16 + step.number(),
        }
    }

    /// Writes it to the actuator.
    ///
    /// # Errors
    /// Those of the client.
    pub fn report(self, client: &mut Client) -> Result<(), ClientError> {
        client.write(OBJECT, &self.value().to_string())
    }
}

/// Ends what is left of before this program: a request whose master may no longer watch the shaft,
/// and a run whose program has ended.
///
/// # Errors
/// Those of the client.
pub fn end_old_requests(client: &mut Client) -> Result<(), ClientError> {
    match client.integer(OBJECT)? {
        1 | 2 => Answer::Failed.report(client),
        _ => Ok(()),
    }
}

/// Whether a master requests a commissioning of this actuator.
///
/// # Errors
/// Those of the client.
pub fn is_requested(client: &mut Client) -> Result<bool, ClientError> {
    Ok(client.integer(OBJECT)? == REQUESTED)
}
