//! Telemetry for the commands that show or record it.

use std::time::{Duration, Instant};

use crate::can::client::Client;
use crate::can::telemetry::Telemetry;
use crate::error::Error;

/// How long nothing may come.
const SILENCE: Duration = Duration::from_secs(2);

/// Starts the node and calls `see` with each complete record until it says that it has had enough, or the time is over.
pub(super) fn watch(
    client: &mut Client,
    time: Option<Duration>,
    mut see: impl FnMut(&Telemetry, Duration) -> Result<bool, Error>,
) -> Result<(), Error> {
    let mut telemetry = Telemetry::of(client)?;
    client.manage(1)?;
    let begun = Instant::now();
    let mut heard = begun;
    while time.is_none_or(|time| begun.elapsed() < time) {
        let frame = client.link().receive(Duration::from_millis(100));
        let frame = frame.map_err(crate::can::client::ClientError::from)?;
        // Others may be talking all the time.
        if heard.elapsed() > SILENCE {
            let node = client.node();
            return Err(Error::Conflict(format!("node {node} sends no telemetry")));
        }
        let Some(frame) = frame else { continue };
        if telemetry.receive(&frame) {
            heard = Instant::now();
            if !see(&telemetry, begun.elapsed())? {
                break;
            }
        }
    }
    Ok(())
}
