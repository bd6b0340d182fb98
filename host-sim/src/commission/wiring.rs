//! The first step: short pulses of torque, upward and downward, show the senses of motor, encoder,
//! current measurement and back-EMF.

use std::time::Duration;

use super::samples::{Board, SIGNALS, Sample};
use super::{CommissionError, Limits, Step, record, refuse};
use crate::can::client::{Client, ClientError};

const STEP: Step = Step::Wiring;

/// Longest time of a pulse.
const LONGEST: Duration = Duration::from_millis(400);

/// Time in which the position loop brings the shaft to rest.
const REST: Duration = Duration::from_millis(400);

/// Travel that ends a pulse, mdeg.
const TRAVEL_MDEG: i64 = 5_000;

/// Least travel that shows the sense of the encoder: eleven counts of 4,096, mdeg.
const LEAST_MDEG: f64 = 1_000.0;

/// Least back-EMF of a motor that turns: above offset and noise of its measurement, mV.
const LEAST_BACK_EMF_MV: f64 = 150.0;

/// Least current of a motor that is connected: above the offset of its measurement, mA.
const LEAST_CURRENT_MA: f64 = 30.0;

/// What a pulse shows, each with the sign of the duty: negative is against it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pulse {
    /// Largest travel of the shaft, mdeg.
    pub travel_mdeg: f64,
    /// Largest sampled current, mA.
    pub current_ma: f64,
    /// Largest back-EMF, mV.
    pub back_emf_mv: f64,
}

/// Why the wiring is wrong, if it is; `Ok(false)` if the shaft did not move enough to judge.
///
/// ```
/// use host_sim::commission::{Pulse, judge};
///
/// let good = Pulse { travel_mdeg: 5e3, current_ma: 100.0, back_emf_mv: 900.0 };
/// assert_eq!(judge(&good), Ok(true));
/// let reversed = Pulse { current_ma: -100.0, ..good };
/// assert!(judge(&reversed).unwrap_err().contains("current sense is reversed"));
/// ```
///
/// # Errors
/// The reason, with what was expected.
pub fn judge(pulse: &Pulse) -> Result<bool, String> {
    let Pulse {
        travel_mdeg,
        current_ma,
        back_emf_mv,
    } = *pulse;
    // The estimate of the current of a motor that does not turn may have any sign.
    if current_ma < -LEAST_CURRENT_MA && back_emf_mv.abs() > LEAST_BACK_EMF_MV {
        return Err(format!(
            "the current sense is reversed: {current_ma:.0} mA against the duty, expected its sign"
        ));
    }
    if back_emf_mv < -LEAST_BACK_EMF_MV {
        return Err(format!(
            "the back-EMF is reversed: {back_emf_mv:.0} mV against the duty, expected its sign"
        ));
    }
    let turns = back_emf_mv > LEAST_BACK_EMF_MV;
    if turns && current_ma < LEAST_CURRENT_MA {
        return Err(format!(
            "the current measurement is dead: {current_ma:.0} mA of a motor that turns, expected \
             more than 30 mA"
        ));
    }
    if turns && travel_mdeg < -LEAST_MDEG {
        return Err(
            "the encoder is reversed: the angle moves against the motor, expected the same sense; \
             reverse 2010h:4 or the leads of the motor"
                .into(),
        );
    }
    if turns && travel_mdeg.abs() < LEAST_MDEG {
        return Err(format!(
            "the motor turns ({back_emf_mv:.0} mV of back-EMF) and the encoder does not: magnet \
             or encoder is stuck, or the coupling is loose; expected more than 1 deg"
        ));
    }
    if !turns && travel_mdeg.abs() > LEAST_MDEG {
        return Err("the shaft turns without back-EMF: expected more than 150 mV".into());
    }
    Ok(turns)
}

/// Distance from the ends of the range within which a pulse ends and the shaft comes to rest, mdeg.
const ROOM_MDEG: i32 = 15_000;

/// Refuses a shaft from which a pulse could leave the range.
pub fn check_room(client: &mut Client, (low, high): (i32, i32)) -> Result<(), CommissionError> {
    let (low, high) = (low + ROOM_MDEG, high - ROOM_MDEG);
    let present = client.integer("6064")?;
    if (i64::from(low)..=i64::from(high)).contains(&present) {
        return Ok(());
    }
    let why = format!(
        "the shaft is at {present} mdeg, expected {low} to {high} mdeg: 15 deg within the range"
    );
    refuse(STEP, why)
}

/// Temperatures of the board at which a motor is measured, deg C. The winding is assumed to have
/// that of the board; after operation at a high load it is hotter.
const TEMPERATURES_DEG_C: std::ops::RangeInclusive<f64> = -10.0..=60.0;

/// Refuses a board too cold or too hot to know the temperature of its motor.
pub fn check_temperature(client: &mut Client) -> Result<(), CommissionError> {
    let found = client.integer("2006")? as f64 * 0.1;
    if TEMPERATURES_DEG_C.contains(&found) {
        return Ok(());
    }
    let why = format!(
        "the temperature of the board, 2006h, is {found:.1} deg C, expected {} to {} deg C: let \
         the actuator cool down, or its sensor is broken",
        TEMPERATURES_DEG_C.start(),
        TEMPERATURES_DEG_C.end()
    );
    refuse(STEP, why)
}

/// Pulses of growing torque in both directions, until the shaft moves.
pub fn check(client: &mut Client, limits: &Limits, board: &Board) -> Result<(), CommissionError> {
    for sign in [1, -1] {
        let mut last = Pulse::default();
        let mut has_moved = false;
        for share in [4, 2, 1] {
            let permille = i32::from(limits.permille) / share * sign;
            last = pulse(client, permille, board)?;
            has_moved = judge(&last).or_else(|why| refuse(STEP, why))?;
            if has_moved {
                // The position loop, which the right senses permit, brings the shaft to rest.
                client.enable(1)?;
                client.pause(REST)?;
                break;
            }
        }
        if !has_moved {
            return refuse(STEP, held(&last));
        }
    }
    Ok(())
}

/// Why a motor does not turn.
fn held(pulse: &Pulse) -> String {
    let cause = match pulse.current_ma > LEAST_CURRENT_MA {
        true => "the shaft is held, or the limit of the current is too low",
        false => "motor or current sense is not connected, or the current sense is reversed",
    };
    format!(
        "the motor does not turn at {:.0} mA: {cause}",
        pulse.current_ma
    )
}

/// A pulse of torque of at most [`TRAVEL_MDEG`], after which the shaft comes to rest.
fn pulse(client: &mut Client, permille: i32, board: &Board) -> Result<Pulse, CommissionError> {
    client.write("6071", "0")?;
    client.enable(4)?;
    let begin = client.integer("6064")?;
    let (capture, moved) = record(client, &SIGNALS, |client| {
        client.write("6071", &permille.to_string())?;
        let step = Duration::from_millis(8);
        for _ in 0..LONGEST.as_millis() / step.as_millis() {
            client.pause(step)?;
            let way = client.integer("6064")? - begin;
            if way.abs() > TRAVEL_MDEG {
                break;
            }
        }
        client.write("6071", "0")?;
        client.pause(Duration::from_millis(200))?;
        match client.status()? & 0x6F {
            0x27 => Ok(()),
            _ => client.fail_in_state("expected the shaft to follow a pulse of torque"),
        }
    })?;
    let pulse = of_samples(&board.samples(&capture), permille.signum());
    // The recording shows why the drive has stopped.
    let turns = judge(&pulse).or_else(|why| refuse(STEP, why))?;
    match moved {
        Err(error @ ClientError::State { .. }) if !turns => {
            refuse(STEP, format!("{}; {error}", held(&pulse)))
        }
        moved => Ok(moved.map(|()| pulse)?),
    }
}

/// The largest values of a recording: of the currents and voltages while the duty has the sign of
/// the pulse, of the angle also while the shaft moves on.
fn of_samples(samples: &[Sample], sign: i32) -> Pulse {
    let sign = f64::from(sign);
    let begin_deg = samples.first().map_or(0.0, |sample| sample.angle_deg);
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        values.fold(0.0, larger) * sign * 1e3
    };
    let driven = || {
        samples
            .iter()
            .filter(|s| f64::from(s.driven.compare) * sign > 0.0)
    };
    Pulse {
        travel_mdeg: largest(&mut samples.iter().map(|s| s.angle_deg - begin_deg)),
        current_ma: largest(&mut driven().map(|s| s.sampled_a)),
        back_emf_mv: largest(&mut driven().map(|s| s.back_emf_v)),
    }
}
