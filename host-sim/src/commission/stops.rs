//! The stops of the shaft, where no range is given: a limited torque turns it slowly until it
//! stands, in one direction and then in the other. A shaft that only sticks stands too: each stop
//! is approached a second time, from within.

use std::time::Duration;

use super::runs::arrive;
use super::write::write_range;
use super::{CommissionError, Limits, Step, refuse};
use crate::can::client::Client;

const STEP: Step = Step::Stops;

/// Greatest rate, at which the shaft meets a stop, mdeg/s. Gears that yield throw it back.
const RATE_MDEG_S: i64 = 30_000;

/// Share of the highest current that turns it: a divisor.
const SHARE: i32 = 2;

/// The shaft stands where all angles of this time are within this, mdeg: a fortieth of the way at
/// the greatest rate, and three counts of the encoder. It is shorter than the stall time 2100h:0E.
const STANDING_MDEG: i64 = 300;
const STANDING: Duration = Duration::from_millis(400);

/// Distance from a stop at which its second approach begins, mdeg.
const BACK_MDEG: i64 = 5_000;

/// Largest difference of two approaches, mdeg: the backlash of worn gears, a quarter of a degree,
/// and a count of the encoder with its noise at each.
const AGREE_MDEG: i64 = 500;

/// Interval of the readings of the angle.
const STEP_TIME: Duration = Duration::from_millis(20);

/// Longest way to a stop, mdeg: one turn.
const LONGEST_MDEG: i64 = 360_000;

/// Distance of the limits 607Dh from the stops, mdeg: the gears yield by a part of a degree, and an
/// overshoot of the position loop must not meet the stop.
const MARGIN_MDEG: i64 = 3_000;

/// Least range of the steps that follow, mdeg: a pulse needs 15 deg on both sides, and a run needs
/// room to settle.
pub const LEAST_MDEG: i32 = 40_000;

/// The range within the stops.
pub fn find(client: &mut Client, limits: &Limits) -> Result<(i32, i32), CommissionError> {
    client.quick_stop()?;
    let begin = client.integer("6064")?;
    let reach = 2 * LONGEST_MDEG;
    write_range(client, (begin - reach, begin + reach))?;
    let speed = client.integer("6080")?;
    client.write("6080", &RATE_MDEG_S.to_string())?;
    client.write("6071", "0")?;
    client.enable(4)?;
    let permille = i32::from(limits.permille) / SHARE;
    let low = stop(client, begin, -permille)?;
    let high = stop(client, begin, permille)?;
    client.write("6071", "0")?;
    client.quick_stop()?;
    client.write("6080", &speed.to_string())?;
    let range = [low + MARGIN_MDEG, high - MARGIN_MDEG].map(i32::try_from);
    match range {
        [Ok(low), Ok(high)] if high.saturating_sub(low) >= LEAST_MDEG => Ok((low, high)),
        _ => {
            let why = format!(
                "the shaft stands at {low} and at {high} mdeg, expected stops that are {} deg \
                 apart at least: friction holds it (a larger --current), or --range is needed",
                (i64::from(LEAST_MDEG) + 2 * MARGIN_MDEG) / 1000
            );
            refuse(STEP, why)
        }
    }
}

/// A stop, which two approaches find at the same angle.
fn stop(client: &mut Client, begin: i64, permille: i32) -> Result<i64, CommissionError> {
    let first = approach(client, begin, permille)?;
    client.enable(1)?;
    arrive(
        client,
        (first - BACK_MDEG * i64::from(permille.signum())) as i32,
    )?;
    client.write("6071", "0")?;
    client.enable(4)?;
    let second = approach(client, begin, permille)?;
    if (second - first).abs() <= AGREE_MDEG {
        return Ok(second);
    }
    let why = format!(
        "the shaft stands at {first} mdeg, and at {second} mdeg when it approaches again, expected \
         a difference of {AGREE_MDEG} mdeg at most: it sticks, or what stops it yields; --range is \
         needed"
    );
    refuse(STEP, why)
}

/// Turns the shaft until it stands; where.
fn approach(client: &mut Client, begin: i64, permille: i32) -> Result<i64, CommissionError> {
    client.write("6071", &permille.to_string())?;
    let readings = (STANDING.as_millis() / STEP_TIME.as_millis()) as usize;
    let mut angles = vec![client.integer("6064")?];
    loop {
        client.pause(STEP_TIME)?;
        let angle = client.integer("6064")?;
        if client.status()? & 0x6F != 0x27 {
            let expected = "expected the shaft to turn to a stop";
            return Ok(client.fail_in_state(expected)?);
        }
        if (angle - begin).abs() > LONGEST_MDEG {
            let why =
                format!("no stop within 360 deg of {begin} mdeg, expected one: --range is needed");
            return refuse(STEP, why);
        }
        angles.push(angle);
        let last = angles
            .len()
            .checked_sub(readings)
            .map(|from| &angles[from..]);
        let spread = |last: &[i64]| last.iter().max().zip(last.iter().min()).map(|(a, b)| a - b);
        if last
            .and_then(spread)
            .is_some_and(|spread| spread < STANDING_MDEG)
        {
            return Ok(angle);
        }
    }
}
