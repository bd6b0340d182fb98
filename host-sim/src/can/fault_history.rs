//! Faults of an actuator: names of the present and latched ones, and the last errors.

use firmware::faults::{Fault, FaultDescription, TABLE};

use super::client::{Client, ClientError};

/// The faults whose bits are set in 2050h:9 or 2050h:10.
pub fn descriptions(bits: i64) -> impl Iterator<Item = &'static FaultDescription> {
    let rows = TABLE.iter();
    rows.filter(move |row| bits >> row.fault.number() & 1 == 1)
}

/// Their names.
///
/// ```
/// assert_eq!(host_sim::can::fault_history::names(1 << 9), ["stall"]);
/// ```
pub fn names(bits: i64) -> Vec<&'static str> {
    descriptions(bits).map(|row| row.name).collect()
}

/// An entry of 1003h or the content of an EMCY message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PastError {
    /// Error code of CiA 301 and CiA 402.
    pub error_code: u16,
    /// What the additional information says: of a fault of the board, 128 and its number; below
    /// that a node or a PDO.
    pub instance: u16,
}

impl PastError {
    /// From a word of 1003h.
    pub fn of_word(word: u32) -> Self {
        Self {
            error_code: word as u16,
            instance: (word >> 16) as u16 & 0xFF,
        }
    }

    /// The error code as text.
    pub fn code(&self) -> String {
        format!("{:04X}h", self.error_code)
    }

    /// The fault of the board; `None` for an error of the bus.
    pub fn fault(&self) -> Option<&'static FaultDescription> {
        let fault = Fault::of_number(self.instance.saturating_sub(128))?;
        let mut rows = TABLE.iter();
        rows.find(|row| row.error_code == self.error_code && row.fault == fault)
    }

    /// Its cause in words.
    ///
    /// ```
    /// use host_sim::can::fault_history::PastError;
    /// assert_eq!(PastError::of_word(0x0089_7121).what(), "stall");
    /// ```
    pub fn what(&self) -> String {
        self.fault().map_or_else(
            || format!("of the bus, {}", self.instance),
            |row| row.name.to_owned(),
        )
    }
}

/// The last errors, the newest first.
///
/// # Errors
/// Those of the transfers.
pub fn history(client: &mut Client) -> Result<Vec<PastError>, ClientError> {
    let mut history = Vec::new();
    for sub in 1..=client.integer("1003:0")? {
        let word = client.integer(&format!("1003:{sub}"))?;
        history.push(PastError::of_word(word as u32));
    }
    Ok(history)
}
