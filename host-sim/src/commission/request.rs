//! A commissioning at the request of any master: object 2055h.

use crate::can::client::{Client, ClientError};

/// The object.
const OBJECT: &str = "2055";

/// Its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Request {
    /// A master requests a commissioning.
    Requested = 1,
    /// It runs.
    Running = 2,
    /// It has ended, and what was found is saved.
    Saved = 3,
    /// It was refused, or has failed, and nothing is saved.
    Refused = 4,
}

impl Request {
    /// Answers what is left of before this program: a request whose master may no longer watch the
    /// shaft, and a run whose program has ended.
    ///
    /// # Errors
    /// Those of the client.
    pub fn refuse_old(client: &mut Client) -> Result<(), ClientError> {
        match client.integer(OBJECT)? {
            1 | 2 => Self::Refused.report(client),
            _ => Ok(()),
        }
    }

    /// Whether a master requests a commissioning of this actuator.
    ///
    /// # Errors
    /// Those of the client.
    pub fn is_pending(client: &mut Client) -> Result<bool, ClientError> {
        Ok(client.integer(OBJECT)? == Self::Requested as i64)
    }

    /// Writes it to the actuator.
    ///
    /// # Errors
    /// Those of the client.
    pub fn report(self, client: &mut Client) -> Result<(), ClientError> {
        client.write(OBJECT, &(self as u8).to_string())
    }
}
