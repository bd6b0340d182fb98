//! The third step: runs at constant rate, upward and downward, whose back-EMF against the rate
//! gives the torque constant.

use std::time::Duration;

use super::regression::slope;
use super::samples::{Board, SIGNALS, Sample};
use super::winding::Winding;
use super::write::write_range;
use super::{CommissionError, Estimate, GAIN_ERROR, PERIOD_S, Step, record, refuse, uniform};
use crate::can::client::{Client, ClientError};
use canopen::cia402::statusword;

const STEP: Step = Step::Runs;

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
pub const ECCENTRICITY_DEG: f64 = 1.4;

/// Means of a run at constant rate.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ConstantRate {
    /// Rate, rad/s.
    pub rate_rad_s: f64,
    /// Back-EMF, V.
    pub back_emf_v: f64,
    /// Change of the back-EMF, V/s: the rate still settles.
    pub back_emf_change_v_s: f64,
    /// Current, A.
    pub current_a: f64,
}

/// A run at constant rate.
#[derive(Debug, Clone)]
pub struct Run {
    /// Its means.
    pub mean: ConstantRate,
    /// The samples of the constant rate.
    pub samples: Vec<Sample>,
}

/// All runs.
#[derive(Debug, Clone)]
pub struct Runs {
    /// Each of four rates, upward and downward.
    pub runs: Vec<Run>,
    /// Their span, deg.
    pub span_deg: f64,
    /// Lowest supply voltage, V.
    pub least_supply_v: f64,
    /// Highest temperature of the board, deg C.
    pub temperature_deg_c: f64,
}

/// Runs at four rates up to this one, mdeg/s, in both directions within this range, mdeg.
pub fn measure(
    client: &mut Client,
    ((low, high), rate_mdeg_s): ((i32, i32), i32),
    (board, winding): (&Board, &Winding),
) -> Result<Runs, CommissionError> {
    client.quick_stop()?;
    write_range(client, (low.into(), high.into()))?;
    let (centre, half) = (
        low.midpoint(high),
        ((high - low) / 20 * 9).min(HALF_SPAN_MDEG),
    );
    let ends = (centre - half, centre + half);
    client.enable(1)?;
    client.write("6081", &rate_mdeg_s.to_string())?;
    arrive(client, ends.0)?;
    let mut found = Runs {
        runs: Vec::new(),
        span_deg: f64::from(ends.1 - ends.0) * 1e-3,
        least_supply_v: f64::INFINITY,
        temperature_deg_c: f64::NEG_INFINITY,
    };
    for quarter in [1, 2, 3, 4] {
        let rate = rate_mdeg_s / 4 * quarter;
        client.write("6081", &rate.to_string())?;
        for end in [ends.1, ends.0] {
            let (capture, moved) = record(client, &SIGNALS, |client| arrive(client, end))?;
            moved?;
            let samples = board.samples(&capture);
            for sample in &samples {
                found.least_supply_v = found.least_supply_v.min(sample.driven.supply_v);
                found.temperature_deg_c = found.temperature_deg_c.max(sample.temperature_deg_c);
            }
            let Some(run) = steady(&samples, rate, winding) else {
                let why = format!(
                    "no constant rate of {rate} mdeg/s within {low} to {high} mdeg: expected a \
                     larger range or a lower rate"
                );
                return refuse(STEP, why);
            };
            found.runs.push(run);
        }
    }
    arrive(client, centre)?;
    Ok(found)
}

/// Moves to an angle, and waits until it is reached.
pub fn arrive(client: &mut Client, end_mdeg: i32) -> Result<(), ClientError> {
    client.move_to(end_mdeg)?;
    let reached = |status| status & statusword::TARGET_REACHED != 0;
    client.wait(LONGEST, "expected the angle to be reached", reached)?;
    Ok(())
}

/// The samples in which the command has had this rate for [`SETTLING`] periods.
pub fn constant_rate(samples: &[Sample], rate_mdeg_s: i32) -> Option<&[Sample]> {
    let step_mdeg = (f64::from(rate_mdeg_s) * PERIOD_S) as i32;
    // A command is rounded to 1 mdeg.
    let is_steady = |pair: &[Sample]| {
        ((pair[1].command_mdeg - pair[0].command_mdeg).abs() - step_mdeg).abs() <= 2
    };
    let steady: Vec<bool> = samples.windows(2).map(is_steady).collect();
    let first = steady.iter().position(|steady| *steady)? + SETTLING;
    let last = steady.iter().rposition(|steady| *steady)?;
    let samples = samples.get(first..last)?;
    (samples.len() >= LEAST_RECORDS).then_some(samples)
}

/// The integral of the back-EMF since the first sample, V s.
pub fn flux_v_s(samples: &[Sample]) -> impl Iterator<Item = f64> {
    let mut sum_v = 0.0;
    let sums = samples.windows(2).map(move |pair| {
        sum_v += pair[0].back_emf_v.midpoint(pair[1].back_emf_v);
        sum_v * PERIOD_S
    });
    std::iter::once(0.0).chain(sums)
}

/// The run of these samples of a recording.
fn steady(samples: &[Sample], rate_mdeg_s: i32, winding: &Winding) -> Option<Run> {
    let samples = constant_rate(samples, rate_mdeg_s)?;
    let angles = samples.iter().map(|sample| sample.angle_deg.to_radians());
    let currents = samples
        .iter()
        .map(|sample| winding.current(sample.driven).mean_a);
    // The back-EMF of a straight line through its integral, as the rate is that of the angle: where
    // the rate still changes, both weigh it alike.
    Some(Run {
        mean: ConstantRate {
            rate_rad_s: slope_in_time(angles)?,
            back_emf_v: slope_in_time(flux_v_s(samples))?,
            back_emf_change_v_s: slope_in_time(samples.iter().map(|sample| sample.back_emf_v))?,
            current_a: currents.sum::<f64>() / samples.len() as f64,
        },
        samples: samples.to_vec(),
    })
}

/// The slope of values in each control period, 1/s.
fn slope_in_time(values: impl Iterator<Item = f64>) -> Option<f64> {
    let points = values.enumerate();
    let points = points.map(|(i, value)| (i as f64 * PERIOD_S, value));
    Some(slope(points)?.value)
}

impl Runs {
    /// Back-EMF per rate of the shaft, V s/rad, which is the torque per current, Nm/A. Its standard
    /// error has the share of encoder and gain, which the residuals do not show: they are the same
    /// in all runs.
    pub fn back_emf_per_rate(&self) -> Result<Estimate, CommissionError> {
        let points = self.runs.iter();
        let points = points.map(|run| (run.mean.rate_rad_s, run.mean.back_emf_v));
        let Some(slope) = slope(points) else {
            return refuse(STEP, "too few rates for a line");
        };
        // A sine of this amplitude changes the mean rate over the span by 2 a sin(span/2)/span at
        // most.
        let half_turn = (self.span_deg / 2.0).min(90.0).to_radians().sin();
        let encoder = uniform(2.0 * ECCENTRICITY_DEG * half_turn / self.span_deg);
        let common = slope.value * encoder.hypot(uniform(GAIN_ERROR));
        let standard_error = slope.standard_error.hypot(common);
        if slope.value < 3.0 * standard_error {
            let why = format!(
                "the torque constant cannot be identified: {:.3e} V s/rad of back-EMF with a \
                 standard error of {standard_error:.1e}, expected three of them at least",
                slope.value
            );
            return refuse(STEP, why);
        }
        Ok(Estimate {
            value: slope.value,
            standard_error,
        })
    }
}
