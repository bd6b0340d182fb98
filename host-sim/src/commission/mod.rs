//! Commissioning of an actuator over its bus: its wiring is checked at limited current, then runs
//! at constant rate give the torque constant. Nothing is saved before all steps have succeeded.

mod runs;
mod slope;
#[cfg(test)]
mod tests;
mod wiring;
mod write;

use firmware::capture::Signal;

use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};

pub use runs::Findings;
pub use wiring::{Pulse, judge};
pub use write::{Kept, write};

/// A value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// Why an actuator is not commissioned.
#[derive(Debug, thiserror::Error)]
pub enum CommissionError {
    /// The bus or the actuator.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// A step refuses.
    #[error("{step}: {why}")]
    Refused {
        /// The step.
        step: &'static str,
        /// What was found, and what was expected.
        why: String,
    },
}

/// The limits of the motion.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// The range of the angle, which becomes 607Dh, mdeg.
    pub range_mdeg: (i32, i32),
    /// Highest current of the pulses, in thousandths of the rated current 6075h.
    pub permille: u16,
    /// Highest rate of the runs, mdeg/s.
    pub rate_mdeg_s: i32,
}

/// Checks the wiring and measures. The drive is off afterwards, but for a failure.
///
/// # Errors
/// [`CommissionError`].
pub fn measure(client: &mut Client, limits: &Limits) -> Result<Findings, CommissionError> {
    client.quick_stop()?;
    wiring::check_room(client, limits)?;
    // So far above the rate of the runs that the limit does not act on them.
    client.write("6080", &(limits.rate_mdeg_s / 4 * 5).to_string())?;
    wiring::check(client, limits)?;
    let findings = runs::measure(client, limits)?;
    client.quick_stop()?;
    Ok(findings)
}

/// A refusal of a step.
fn refuse<T>(step: &'static str, why: impl Into<String>) -> Result<T, CommissionError> {
    let why = why.into();
    Err(CommissionError::Refused { step, why })
}

/// Records these signals during a motion. The error of the motion follows the recording, which
/// shows why.
fn record(
    client: &mut Client,
    signals: &[Signal],
    motion: impl FnOnce(&mut Client) -> Result<(), ClientError>,
) -> Result<(Capture, Result<(), ClientError>), ClientError> {
    client.write("2030:1", "0")?;
    for sub in 1..=8 {
        let signal = signals.get(sub - 1).map_or(255, |signal| *signal as u8);
        client.write(&format!("2031:{sub}"), &signal.to_string())?;
    }
    client.write("2030:5", "1")?;
    client.write("2030:3", "0")?;
    client.write("2030:1", "1")?;
    let moved = motion(client);
    client.write("2030:1", "0")?;
    Ok((Capture::upload(client)?, moved))
}
