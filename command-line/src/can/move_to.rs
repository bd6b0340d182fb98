//! `actuator move`: to an angle, and no further.

use std::time::Duration;

use canopen::cia402::statusword;
use clap::Args;
use serde_json::json;

use super::dronecan::Node;
use super::servo::Servo;
use super::{AtNode, print_json};
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
use host_sim::can::client::{Client, ClientError};
use model_core::parameter::Shown;

/// Moves an actuator to an angle by a profile, and prints the angle reached
///
/// The drive is enabled if necessary. Afterwards it holds the angle unless --release is given. An
/// angle beyond the limits of the actuator ends at the limit, with exit status 4. The actuator
/// stops if this program is interrupted, ends or waits in vain, but with --no-wait. A servo of a
/// serial bus moves on if this program is killed.
#[derive(Debug, Args)]
pub struct Move {
    /// Angle, deg
    angle_deg: f64,
    /// Rate of the profile, deg/s; it is kept in 6081h for later moves [default: the value there]
    #[arg(long, value_name = "DEG_S")]
    rate: Option<f64>,
    /// Disables the drive at the end, also on failure
    #[arg(long)]
    release: bool,
    /// Does not wait until the angle is reached
    #[arg(long, conflicts_with = "release")]
    no_wait: bool,
    /// Timeout, s
    #[arg(long, value_name = "SECONDS", default_value_t = 10.0)]
    within: f64,
    #[command(flatten)]
    at: AtNode,
}

impl Move {
    /// Moves the actuator.
    ///
    /// # Errors
    /// For an invalid number; those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let target_mdeg = mdeg("the angle", self.angle_deg)?;
        let within = Duration::try_from_secs_f64(self.within).map_err(|_| Error::Option {
            option: "--within",
            value: Shown(self.within).to_string(),
            expected: "a time in seconds",
        })?;
        let rate_mdeg_s = self.rate.map(profile_rate).transpose()?;
        if let Some(mut servo) = self.at.servo()? {
            return self.turn(&mut servo, within);
        }
        if let Some(mut node) = self.at.drone()? {
            return self.command(&mut node, within);
        }
        let mut client = self.at.open()?;
        let move_to = |client: &mut Client| self.arrive(client, target_mdeg, rate_mdeg_s, within);
        let angle_deg = match self.no_wait {
            true => move_to(&mut client),
            false => client.supervised(interrupt::stop()?, move_to, Client::halt),
        };
        let released = match self.release {
            true => client.disable(),
            false => Ok(()),
        };
        // The error of the move is more informative than that of the release.
        let angle_deg = angle_deg?;
        released?;
        if self.at.json() {
            return print_json(&json!({ "angle_deg": angle_deg }));
        }
        print(&format!("{angle_deg} deg\n"))
    }

    /// Commands a DroneCAN node until it is at the angle.
    fn command(&self, node: &mut Node, within: Duration) -> Result<(), Error> {
        if self.rate.is_some() || self.no_wait {
            let text =
                "--rate and --no-wait: a DroneCAN node is commanded until it is at the angle";
            return Err(Error::Conflict(text.into()));
        }
        let angle_deg = node.turn_to(self.angle_deg, within);
        if self.release || angle_deg.is_err() {
            let released = node.release();
            // The error of the move is more informative than that of the release.
            released.or_else(|error| angle_deg.as_ref().map_or(Ok(()), |_| Err(error)))?;
        }
        self.print_angle(angle_deg?)
    }

    fn print_angle(&self, angle_deg: f64) -> Result<(), Error> {
        if self.at.json() {
            return print_json(&json!({ "angle_deg": angle_deg }));
        }
        print(&format!("{angle_deg:.3} deg\n"))
    }

    /// Moves a servo.
    fn turn(&self, servo: &mut Servo, within: Duration) -> Result<(), Error> {
        if self.rate.is_some() {
            let text = "--rate: of a servo, set goal_velocity or profile_velocity";
            return Err(Error::Conflict(text.into()));
        }
        let within = (!self.no_wait).then_some(within);
        let angle_deg = servo.turn_to(self.angle_deg, within);
        let released = match self.release {
            true => servo.release(),
            false => Ok(()),
        };
        let angle_deg = angle_deg?;
        released?;
        self.print_angle(angle_deg)
    }

    /// Moves to the angle, and returns the angle reached.
    fn arrive(
        &self,
        client: &mut Client,
        target_mdeg: i32,
        rate_mdeg_s: Option<i32>,
        within: Duration,
    ) -> Result<f64, Error> {
        if let Some(rate) = rate_mdeg_s {
            client.write("6081", &rate.to_string())?;
        }
        client.enable(1)?;
        client.move_to(target_mdeg)?;
        if !self.no_wait {
            let expected = "expected the angle to be reached";
            let status = client.wait(within, expected, |status| {
                status & statusword::TARGET_REACHED != 0
            })?;
            if status & statusword::INTERNAL_LIMIT != 0 {
                return Err(ClientError::AtLimit {
                    node: client.node(),
                    angle_deg: client.integer("6064")? as f64 / 1000.0,
                    why: "the angle is beyond the limits 607Dh, and the drive is at one of them",
                }
                .into());
            }
        }
        Ok(client.integer("6064")? as f64 / 1000.0)
    }
}

/// A rate of at least one unit, mdeg/s.
fn profile_rate(deg_s: f64) -> Result<i32, Error> {
    let rate = mdeg("--rate", deg_s)?;
    if rate > 0 {
        return Ok(rate);
    }
    Err(Error::Option {
        option: "--rate",
        value: Shown(deg_s).to_string(),
        expected: "a rate of at least 0.001 deg/s",
    })
}

/// In thousandths, the unit of the dictionary.
pub(super) fn mdeg(option: &'static str, degrees: f64) -> Result<i32, Error> {
    let value = (degrees * 1000.0).round();
    if value.abs() <= f64::from(i32::MAX) {
        Ok(value as i32)
    } else {
        Err(Error::Option {
            option,
            value: Shown(degrees).to_string(),
            expected: "a number within 2,147,483",
        })
    }
}
