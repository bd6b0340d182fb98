//! The second step: runs at constant rate, upward and downward, whose back-EMF against the rate
//! gives the torque constant.

use std::time::Duration;

use firmware::capture::Signal;

use super::slope::slope;
use super::write::write_range;
use super::{CommissionError, Estimate, Limits, record, refuse};
use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};
use crate::can::names::{self, Value};
use canopen::cia402::statusword;

const STEP: &str = "runs at constant rate";

/// Time at constant rate after which the loop has settled: three of the slowest pole of the
/// default gains, in control periods.
const SETTLING: usize = 60;

/// Least records of a run.
const LEAST_RECORDS: usize = 20;

/// Largest span of the runs to both sides: it limits their time, mdeg.
const HALF_SPAN_MDEG: i32 = 45_000;

/// Longest run.
const LONGEST: Duration = Duration::from_secs(20);

/// Largest error of the encoder once a turn, of a magnet within the alignment tolerance of the
/// AS5045, deg.
const ECCENTRICITY_DEG: f64 = 1.4;

/// Relative error of the gain of the back-EMF measurement: resistors of 1 %.
const GAIN_ERROR: f64 = 0.01;

/// What the runs give.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Findings {
    /// Torque constant of the motor by the gear ratio 2011h:3, Nm/A.
    pub torque_constant_nm_a: Estimate,
    /// Lowest supply voltage of all runs, V.
    pub least_supply_v: f64,
    /// Highest temperature of the board, deg C.
    pub temperature_deg_c: f64,
}

/// The records of a run at constant rate, in one point: rate, rad/s, and back-EMF, V.
type Run = (f64, f64);

/// Runs at four rates in both directions.
pub fn measure(client: &mut Client, limits: &Limits) -> Result<Findings, CommissionError> {
    let (low, high) = limits.range_mdeg;
    client.quick_stop()?;
    write_range(client, (low.into(), high.into()))?;
    let (centre, half) = (
        low.midpoint(high),
        ((high - low) / 20 * 9).min(HALF_SPAN_MDEG),
    );
    let ends = (centre - half, centre + half);
    client.enable(1)?;
    client.write("6081", &limits.rate_mdeg_s.to_string())?;
    arrive(client, ends.0)?;
    let (mut runs, mut supply_mv, mut temperature) = (Vec::new(), i32::MAX, i32::MIN);
    for quarter in [1, 2, 3, 4] {
        let rate = limits.rate_mdeg_s / 4 * quarter;
        client.write("6081", &rate.to_string())?;
        for end in [ends.1, ends.0] {
            let capture = run(client, end)?;
            for record in &capture.records {
                supply_mv = supply_mv.min(record[3]);
                temperature = temperature.max(record[4]);
            }
            let Some(run) = means(&capture, rate) else {
                let why = format!(
                    "no constant rate of {rate} mdeg/s within {low} to {high} mdeg: expected a \
                     larger range or a lower rate"
                );
                return refuse(STEP, why);
            };
            runs.push(run);
        }
    }
    arrive(client, centre)?;
    let ratio = match client.get(names::find("2011:3").map_err(ClientError::from)?)? {
        Value::Real(ratio) => f64::from(ratio),
        _ => return refuse(STEP, "2011h:3 is not a real number"),
    };
    Ok(Findings {
        torque_constant_nm_a: torque_constant(&runs, ratio, f64::from(ends.1 - ends.0) * 1e-3)?,
        least_supply_v: f64::from(supply_mv) * 1e-3,
        temperature_deg_c: f64::from(temperature) * 1e-3,
    })
}

fn arrive(client: &mut Client, end_mdeg: i32) -> Result<(), ClientError> {
    client.move_to(end_mdeg)?;
    let reached = |status| status & statusword::TARGET_REACHED != 0;
    client.wait(LONGEST, "expected the angle to be reached", reached)?;
    Ok(())
}

fn run(client: &mut Client, end_mdeg: i32) -> Result<Capture, CommissionError> {
    use Signal::{Angle, BackEmf, Command, Supply, Temperature};
    let signals = [Angle, BackEmf, Command, Supply, Temperature];
    let (capture, moved) = record(client, &signals, |client| arrive(client, end_mdeg))?;
    moved?;
    Ok(capture)
}

/// The means of the records in which the command has had this rate for [`SETTLING`] periods.
fn means(capture: &Capture, rate_mdeg_s: i32) -> Option<Run> {
    let step_mdeg = i64::from(rate_mdeg_s) * capture.period_us / 1_000_000;
    // A command is rounded to 1 mdeg.
    let is_steady =
        |pair: &[Vec<i32>]| (i64::from(pair[1][2] - pair[0][2]).abs() - step_mdeg).abs() <= 2;
    let steady: Vec<bool> = capture.records.windows(2).map(is_steady).collect();
    let first = steady.iter().position(|steady| *steady)? + SETTLING;
    let last = steady.iter().rposition(|steady| *steady)?;
    let records = capture.records.get(first..last)?;
    if records.len() < LEAST_RECORDS {
        return None;
    }
    let sum: f64 = records.iter().map(|record| f64::from(record[1])).sum();
    let back_emf_v = sum / records.len() as f64 * 1e-3;
    let angles = records.iter().enumerate();
    let angles: Vec<_> = angles
        .map(|(i, record)| (capture.time_s(i), f64::from(record[0]) * 1e-3))
        .collect();
    Some((slope(&angles)?.value.to_radians(), back_emf_v))
}

/// The torque constant; its standard error has the share of encoder and gain, which the residuals
/// do not show: they are the same in all runs.
fn torque_constant(runs: &[Run], ratio: f64, span_deg: f64) -> Result<Estimate, CommissionError> {
    let Some(slope) = slope(runs) else {
        return refuse(STEP, "too few rates for a line");
    };
    // A sine of this amplitude changes the mean rate over the span by 2 a sin(span/2)/span at most;
    // the standard deviation of a uniform distribution is this over the root of three.
    let half_turn = (span_deg / 2.0).min(90.0).to_radians().sin();
    let encoder = 2.0 * ECCENTRICITY_DEG * half_turn / span_deg / 3.0_f64.sqrt();
    let common = slope.value * encoder.hypot(GAIN_ERROR / 3.0_f64.sqrt());
    let standard_error = slope.standard_error.hypot(common);
    if slope.value < 3.0 * standard_error {
        return refuse(
            STEP,
            format!(
                "the torque constant cannot be identified: {:.3e} V s/rad of back-EMF with a \
                 standard error of {standard_error:.1e}, expected three of them at least",
                slope.value
            ),
        );
    }
    Ok(Estimate {
        value: slope.value / ratio,
        standard_error: standard_error / ratio,
    })
}
