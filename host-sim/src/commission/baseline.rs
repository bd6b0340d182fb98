//! The last step before the write: the baseline of the health 2053h, from the means 2052h of moves
//! with what is to be stored.

use std::time::Duration;

use super::runs::arrive;
use super::write::{Kept, write_range};
use super::{CommissionError, Findings, Limits};
use crate::can::client::{Client, ClientError};

/// Time of motion each way, s: twice that of the fewest control periods.
const TIME_S: f64 = 8.0;

/// Time in which the control loop takes a parameter, some control periods.
const CHANGE: Duration = Duration::from_millis(20);

/// Fewest control periods of a mean, each way: 2052h has its results from then on.
const LEAST_SAMPLES: i64 = 1024;

/// The share of the range in which the moves stay.
const SHARE: f64 = 0.9;

/// Largest half of a move, mdeg: its time is bounded, as that of the runs.
const HALF_WAY_MDEG: i32 = 45_000;

/// The baseline of the health.
#[derive(Debug, Clone, Default, serde::Serialize)]
pub struct Baseline {
    /// Current against friction, mA.
    pub friction_ma: f64,
    /// Constant of the back-EMF, V s/deg.
    pub constant_v_s_deg: f64,
    /// Standard errors of both, and of the two that follow, in their units; `None` after too few
    /// motions. That of the friction is that of the load too.
    pub standard_errors: [Option<f64>; 4],
    /// Resistance of the supply, mohm; 0 where the moves do not show it, as the play.
    pub supply_mohm: i64,
    /// Play between motor and shaft, mdeg.
    pub play_mdeg: i64,
    /// Current against a load in the positive direction, mA; it has no baseline of its own.
    pub load_ma: f64,
    /// Control periods of the means.
    pub samples: i64,
    /// Why it is not stored, if it is not.
    pub without_baseline: Option<String>,
}

impl Baseline {
    /// The objects that are stored, and their values.
    pub fn objects(&self) -> Vec<(&'static str, f64)> {
        if self.without_baseline.is_some() {
            return Vec::new();
        }
        let values = [
            (self.friction_ma * 1e1).round(),
            (self.constant_v_s_deg * 1e6).round(),
            self.supply_mohm as f64,
            self.play_mdeg as f64,
        ];
        let values = BASELINE.into_iter().zip(values);
        // What the moves do not show keeps its baseline.
        values.filter(|(_, value)| *value > 0.0).collect()
    }
}

/// The objects of the baseline: friction, constant, resistance of the supply and play.
pub const BASELINE: [&str; 4] = ["2053:1", "2053:2", "2053:9", "2053:10"];

/// The greatest resistance that 2053h:9 takes, mohm.
const MOST_MOHM: i64 = 60_000;

/// Moves to and fro with the parameters of before and what is to be stored, and reads the means.
/// The drive is off afterwards, with these parameters.
///
/// # Errors
/// [`CommissionError`]; means that are not known are no error.
pub fn baseline(
    client: &mut Client,
    limits: &Limits,
    kept: &Kept,
    findings: &Findings,
) -> Result<Baseline, CommissionError> {
    client.quick_stop()?;
    kept.restore(client)?;
    limits.limit_current(client)?;
    let (low, high) = findings.range_mdeg;
    write_range(client, (low.into(), high.into()))?;
    let objects = findings.objects();
    let mut values = objects.iter();
    values.try_for_each(|(object, value)| client.write(object, &value.to_string()))?;
    // Without a baseline nothing warns, and a changed one begins the means anew.
    let [friction, constant, ..] = BASELINE;
    client.write(constant, "0")?;
    client.write(friction, "1")?;
    client.pause(CHANGE)?;
    client.write(friction, "0")?;
    client.pause(CHANGE)?;
    client.enable(1)?;
    // The friction is comparable with that of the same motions only: those of the axis, whose rate
    // exceeds that of the profile by up to a third, within the limit of the rate.
    let limit_mdeg_s = i64::from(limits.rate_mdeg_s) * 3 / 4;
    let rate_mdeg_s = client.integer("6081")?.min(limit_mdeg_s);
    client.write("6081", &rate_mdeg_s.to_string())?;
    let centre_mdeg = low.midpoint(high);
    let half_mdeg = ((f64::from(high - low) / 2.0 * SHARE) as i32).min(HALF_WAY_MDEG);
    let way_s = f64::from(2 * half_mdeg) / rate_mdeg_s.max(1) as f64;
    for _ in 0..(TIME_S / way_s).ceil() as u32 {
        arrive(client, centre_mdeg + half_mdeg)?;
        arrive(client, centre_mdeg - half_mdeg)?;
    }
    arrive(client, centre_mdeg)?;
    client.quick_stop()?;
    Ok(read(client)?)
}

/// The means.
fn read(client: &mut Client) -> Result<Baseline, ClientError> {
    let friction = client.integer("2052:1")?;
    let constant = client.integer("2052:3")?;
    let samples = client.integer("2052:4")?;
    let without_baseline = if samples < LEAST_SAMPLES {
        Some(format!(
            "{samples} control periods above 40 deg/s each way, expected {LEAST_SAMPLES} at least: \
             a greater range or a higher rate"
        ))
    } else if friction <= 0 || constant <= 0 {
        Some(format!(
            "friction of {:.1} mA and constant of {constant} uV s/deg, expected both above zero",
            friction as f64 / 10.0
        ))
    } else {
        None
    };
    let mut standard_error = |object: &str, unit: f64| {
        let error = client.integer(object)?;
        Ok::<_, ClientError>((error > 0).then_some(error as f64 * unit))
    };
    let standard_errors = [
        standard_error("2054:1", 0.1)?,
        standard_error("2054:2", 1e-6)?,
        standard_error("2054:3", 1.0)?,
        standard_error("2054:4", 1.0)?,
    ];
    Ok(Baseline {
        friction_ma: friction as f64 / 10.0,
        constant_v_s_deg: constant as f64 * 1e-6,
        standard_errors,
        supply_mohm: client.integer("2052:9")?.min(MOST_MOHM),
        play_mdeg: client.integer("2052:10")?,
        load_ma: client.integer("2052:2")? as f64 / 10.0,
        samples,
        without_baseline,
    })
}
