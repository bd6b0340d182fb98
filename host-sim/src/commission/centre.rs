//! The middle of the range becomes position 0: a homing where the shaft is, 37 of 6098h, which sets
//! the origin 2041h:3. Nothing moves; the save stores it.

use std::time::Duration;

use canopen::cia402::statusword;

use super::{CommissionError, Findings, refuse};
use crate::can::client::Client;

const STEP: &str = "centre";

/// The position at which the encoder is at 0.
pub(super) const ORIGIN: &str = "2041:3";

/// The objects that a homing needs.
const HOMING: [&str; 3] = ["6060", "6098", "607C"];

/// Homing method: where the shaft is.
const HERE: &str = "37";

/// Time of a homing without a motion: some control periods. A homing of before is reported as
/// attained until it has begun.
const HOMED: Duration = Duration::from_millis(20);

/// Most by which the shaft moves when the drive holds it, mdeg: the play of worn gears and two
/// counts of the encoder.
const MOST_MDEG: i64 = 500;

/// Makes the middle of the found range position 0, but for the motion of the shaft when the drive
/// holds it, and the range that of the new positions, narrower by this motion at both ends. The
/// drive is off afterwards, and [`super::write`] saves both.
///
/// # Errors
/// [`CommissionError`]. The actuator may have the new origin then, until a reset.
pub fn centre(client: &mut Client, findings: &mut Findings) -> Result<(), CommissionError> {
    client.quick_stop()?;
    let mut before = Vec::new();
    for object in HOMING {
        before.push((object, client.integer(object)?));
    }
    let begin = client.integer(ORIGIN)?;
    let (low, high) = findings.range_mdeg;
    let home = client.integer("6064")? - i64::from(low.midpoint(high));
    client.write("6098", HERE)?;
    client.write("607C", &home.to_string())?;
    client.enable(6)?;
    client.start_homing()?;
    client.pause(HOMED)?;
    client.wait(HOMED, "expected a homing where the shaft is", |status| {
        status & statusword::MODE_12 != 0
    })?;
    client.quick_stop()?;
    for (object, value) in before {
        client.write(object, &value.to_string())?;
    }
    let origin = client.integer(ORIGIN)?;
    let [low, high] = [low, high].map(|end| i64::from(end) + origin - begin);
    let middle = low.midpoint(high);
    let half = i32::try_from(high.min(-low));
    match (half, i32::try_from(origin)) {
        (Ok(half), Ok(origin)) if middle.abs() <= MOST_MDEG => {
            findings.range_mdeg = (-half, half);
            findings.origin_mdeg = Some(origin);
            Ok(())
        }
        _ => {
            let why = format!(
                "the middle of the range is at {middle} mdeg after the homing, expected {MOST_MDEG} \
                 mdeg at most: the shaft moves when the drive holds it"
            );
            refuse(STEP, why)
        }
    }
}
