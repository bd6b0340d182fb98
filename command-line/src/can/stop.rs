//! `actuator stop`: a quick stop.

use clap::Args;
use serde_json::json;

use super::{AtNode, print_json};
use crate::error::Error;
use host_sim::can::client::Client;

/// Stops an actuator by a quick stop, after which its drive is off
///
/// With --hold the drive halts and holds the shaft. Of a servo the torque is off without a stop. A
/// DroneCAN node is always released.
#[derive(Debug, Args)]
pub struct Stop {
    /// Halts and holds the shaft
    #[arg(long)]
    hold: bool,
    #[command(flatten)]
    at: AtNode,
}

impl Stop {
    /// Stops the actuator.
    ///
    /// # Errors
    /// Those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        match self.at.servo()? {
            Some(mut servo) if self.hold => servo.halt()?,
            Some(mut servo) => servo.release()?,
            None => match self.at.drone()? {
                Some(mut node) => node.release()?,
                None => self.stop(&mut self.at.open()?)?,
            },
        }
        match self.at.json() {
            true => print_json(&json!({ "stopped": true })),
            false => Ok(()),
        }
    }
    fn stop(&self, client: &mut Client) -> Result<(), Error> {
        match self.hold {
            true => client.halt()?,
            false => client.quick_stop()?,
        }
        Ok(())
    }
}
