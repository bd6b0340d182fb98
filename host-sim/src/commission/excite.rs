//! Excitations that the board generates, around an angle.

use std::time::Duration;

use firmware::capture::Signal;

use super::runs::arrive;
use super::{CommissionError, record};
use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};
use crate::can::excitation;

/// Longest excitation.
const LONGEST: Duration = Duration::from_secs(20);

/// Time at rest before a recording.
pub const REST: Duration = Duration::from_millis(200);

/// Records these signals of an excitation of these settings 2020h around an angle, mdeg, and of the
/// rest for a time before it and behind it.
pub fn excite(
    client: &mut Client,
    centre_mdeg: i32,
    (signals, rest): (&[Signal], Duration),
    settings: &[(u8, i32)],
) -> Result<Capture, CommissionError> {
    for (sub, value) in settings {
        client.write(&format!("2020:{sub}"), &value.to_string())?;
    }
    client.enable(1)?;
    arrive(client, centre_mdeg)?;
    client.pause(REST)?;
    let (capture, moved) = record(client, signals, |client| {
        client.pause(rest)?;
        excitation::start(client)?;
        let done = wait(client);
        // One that has not ended is stopped; its error is more informative.
        let stopped = match &done {
            Ok(()) => client.pause(rest),
            Err(_) => client.write("2020:1", "0"),
        };
        done.and(stopped)
    })?;
    moved?;
    Ok(capture)
}

fn wait(client: &mut Client) -> Result<(), ClientError> {
    let step = Duration::from_millis(20);
    for _ in 0..LONGEST.as_millis() / step.as_millis() {
        client.pause(step)?;
        if client.status()? & 0x6F != 0x27 {
            break;
        }
        if client.integer("2020:2")? == 0 {
            return Ok(());
        }
    }
    client.fail_in_state("expected the excitation to end")
}
