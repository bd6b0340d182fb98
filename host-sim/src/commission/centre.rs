//! The middle of the range becomes position 0: a homing where the shaft is, 37 of 6098h, which sets
//! the origin 2041h:3. No motion is commanded; the save stores it.

use std::time::Duration;

use canopen::cia402::statusword;

use super::{CommissionError, Findings, Limits, Step, refuse};
use crate::can::client::{Client, ClientError};

const STEP: Step = Step::Centre;

/// The position at which the encoder is at 0.
pub(super) const ORIGIN: &str = "2041:3";

/// Bit of 607Eh that reverses positions. It does not reverse the origin.
const REVERSED: i64 = 1 << 7;

/// The objects that a homing needs, with the limit of the current.
const HOMING: [&str; 4] = ["6060", "6072", "6098", "607C"];

/// Homing method: where the shaft is.
const HERE: &str = "37";

/// Longest time of a homing without a motion, as that of the steps of enabling.
const HOMED: Duration = Duration::from_secs(1);

/// Most by which the shaft moves meanwhile, mdeg: the play of worn gears and two counts of the
/// encoder.
const MOST_MDEG: i64 = 500;

/// Half a turn, within which the encoder is at a start, mdeg.
const HALF_TURN_MDEG: i64 = 180_000;

/// The direction of positions by the encoder.
fn direction(client: &mut Client) -> Result<i64, ClientError> {
    let is_reversed = client.integer("607E")? & REVERSED != 0;
    Ok(if is_reversed { -1 } else { 1 })
}

/// By how much positions are greater than with an origin, mdeg.
pub(super) fn shift(client: &mut Client, origin_mdeg: i64) -> Result<i64, ClientError> {
    Ok(direction(client)? * (client.integer(ORIGIN)? - origin_mdeg))
}

/// Makes the middle of the found range position 0, but for the motion of the shaft when the drive
/// holds it, and the range that of the new positions. The drive is off afterwards, and
/// [`super::write`] saves both.
///
/// # Errors
/// [`CommissionError`]. The actuator may have the new origin then, until a reset.
pub fn centre(
    client: &mut Client,
    limits: &Limits,
    findings: &mut Findings,
) -> Result<(), CommissionError> {
    client.quick_stop()?;
    let mut before = Vec::new();
    for object in HOMING {
        before.push((object, client.integer(object)?));
    }
    let sign = direction(client)?;
    let begin = client.integer(ORIGIN)?;
    let (low, high) = findings.range_mdeg;
    let by_encoder = [low, high].map(|end| sign * i64::from(end) - begin);
    if by_encoder.iter().any(|end| end.abs() >= HALF_TURN_MDEG) {
        let [from, to] = by_encoder;
        let why = format!(
            "the range is {from} to {to} mdeg by the encoder, expected less than 180 deg from its \
             zero, 2010h:3: a restart loses whole turns"
        );
        return refuse(STEP, why);
    }
    let home = client.integer("6064")? - i64::from(low.midpoint(high));
    client.write("6098", HERE)?;
    client.write("607C", &home.to_string())?;
    limits.limit_current(client)?;
    client.enable(6)?;
    // An interrupt ends it before the origin is another one.
    client.pause(Duration::ZERO)?;
    client.start_homing()?;
    // A drive that has been switched off shows the homing of before.
    client.wait(HOMED, "expected a homing where the shaft is", |status| {
        status & 0x6F == 0x27 && status & statusword::MODE_12 != 0
    })?;
    client.quick_stop()?;
    for (object, value) in before {
        client.write(object, &value.to_string())?;
    }
    let origin = client.integer(ORIGIN)?;
    let shift = sign * (origin - begin);
    let [low, high] = [low, high].map(|end| i64::from(end) + shift);
    let middle = low.midpoint(high);
    match [low, high, origin].map(i32::try_from) {
        [Ok(low), Ok(high), Ok(origin)] if middle.abs() <= MOST_MDEG => {
            findings.range_mdeg = (low, high);
            findings.origin_mdeg = Some(origin);
            Ok(())
        }
        _ => {
            let why = format!(
                "the middle of the range is at {middle} mdeg after the homing, expected 0 within \
                 {MOST_MDEG} mdeg: the shaft has moved, as under a load when the drive is off"
            );
            refuse(STEP, why)
        }
    }
}
