//! Telemetry for the commands that show or record it.

use std::time::{Duration, Instant};

use crate::error::Error;
use host_sim::can::client::{Client, ClientError};
use host_sim::can::telemetry::Telemetry;

/// Timeout of the telemetry.
const SILENCE: Duration = Duration::from_secs(2);

/// Starts the node and passes each complete record to `see` until `is_over`, which gets the elapsed
/// time.
pub(super) fn watch(
    client: &mut Client,
    is_over: impl Fn(Duration) -> bool,
    mut see: impl FnMut(&Telemetry, Duration) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut telemetry = Telemetry::of(client)?;
    client.manage(1)?;
    let begun = Instant::now();
    let mut heard = begun;
    while !is_over(begun.elapsed()) {
        let frame = client.link().receive(Duration::from_millis(100));
        let frame = frame.map_err(ClientError::from)?;
        // Frames of other nodes may arrive all the time.
        if heard.elapsed() > SILENCE {
            return Err(ClientError::NotNow {
                node: client.node(),
                why: "the node sends no telemetry",
            }
            .into());
        }
        let Some(frame) = frame else { continue };
        if telemetry.receive(&frame) {
            heard = Instant::now();
            see(&telemetry, begun.elapsed())?;
        }
    }
    Ok(())
}
