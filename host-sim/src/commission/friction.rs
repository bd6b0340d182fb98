//! Friction by direction, from the current of the runs at constant rate.
//!
//! ```text
//! k i = c + b w + J w'        upward, and likewise downward
//! ```
//!
//! The rate and its change are those of the back-EMF: the position loop settles so slowly that the
//! torque of the remaining change is not small against friction. The mean current is that of the
//! measured winding with the duty, the supply and the back-EMF, not that of its samples: at a
//! constant rate the current is a small part of what pulses. An error of a gain of the voltages is
//! in proportion to the rate, and therefore one of the viscous friction alone.

use super::regression::{regression, slope};
use super::resistance::Cold;
use super::runs::{Run, Runs};
use super::samples::Sample;
use super::winding::Winding;
use super::{CommissionError, Estimate, GAIN_ERROR, PERIOD_S, Step, refuse, uniform};

const STEP: Step = Step::Friction;

/// Samples of a point of the lines: longer than the residuals are correlated, by the time constant
/// of the loops.
const BLOCK: usize = 25;

/// Coulomb and viscous friction in one direction.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Direction {
    /// Coulomb friction, Nm.
    pub coulomb_nm: Estimate,
    /// Viscous friction, Nm s/rad.
    pub viscous_nm_s: Estimate,
    /// Coulomb friction beside the viscous friction of 2011h:5, Nm: together they make the current
    /// of the runs too.
    pub coulomb_beside_nm: Estimate,
}

/// Friction in both directions.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Friction {
    /// Of a rising angle.
    pub upward: Direction,
    /// Of a falling angle.
    pub downward: Direction,
}

/// Friction of the runs, with the back-EMF per rate, and with the viscous friction of 2011h:5.
pub fn measure(
    runs: &Runs,
    cold: &Cold,
    back_emf_per_rate: Estimate,
    held_nm_s: f64,
) -> Result<Friction, CommissionError> {
    let of = |sign: f64| {
        let runs: Vec<&Run> = runs
            .runs
            .iter()
            .filter(|r| r.mean.rate_rad_s * sign > 0.0)
            .collect();
        direction(&runs, sign, cold, (back_emf_per_rate, held_nm_s))
    };
    let friction = Friction {
        upward: of(1.0)?,
        downward: of(-1.0)?,
    };
    for (name, direction) in [("upward", friction.upward), ("downward", friction.downward)] {
        let Estimate {
            value,
            standard_error,
        } = direction.coulomb_nm;
        if value < -3.0 * standard_error {
            let why = format!(
                "{value:.4} +- {standard_error:.4} Nm of Coulomb friction {name}, expected a \
                 positive value: a load drives the shaft, or the current measurement is wrong"
            );
            return refuse(STEP, why);
        }
    }
    Ok(friction)
}

fn direction(
    runs: &[&Run],
    sign: f64,
    cold: &Cold,
    (constant, held_nm_s): (Estimate, f64),
) -> Result<Direction, CommissionError> {
    let points = points(runs, sign, &cold.winding, constant.value);
    let held_a = held_nm_s / constant.value;
    let beside = points.iter();
    let beside = beside.map(|([one, rate, change], a)| ([*one, *change], a - held_a * rate));
    let found = regression(&points).zip(regression(&beside.collect::<Vec<_>>()));
    let Some((found, beside)) = found else {
        return refuse(STEP, "too few rates for a line");
    };
    let gains = constant.relative().hypot(cold.resistance_ohm.relative());
    let torque = |current: Estimate, common_nm: f64| {
        let value = current.value * constant.value;
        let of_current = current.standard_error * constant.value;
        Estimate {
            value,
            standard_error: of_current.hypot(value * gains).hypot(common_nm),
        }
    };
    // The difference of the voltages of supply and back-EMF, each measured with resistors.
    let voltages = uniform(GAIN_ERROR).hypot(uniform(GAIN_ERROR));
    let braking_nm_s = constant.value.powi(2) / cold.winding.resistance_ohm;
    Ok(Direction {
        coulomb_nm: torque(found.estimate(0), 0.0),
        viscous_nm_s: torque(found.estimate(1), braking_nm_s * voltages),
        coulomb_beside_nm: torque(beside.estimate(0), 0.0),
    })
}

/// Rate, its change, and mean current, of blocks of samples; with the sign of the direction.
fn points(
    runs: &[&Run],
    sign: f64,
    winding: &Winding,
    back_emf_per_rate: f64,
) -> Vec<([f64; 3], f64)> {
    let mut points = Vec::new();
    for run in runs {
        for block in run.samples.chunks_exact(BLOCK.min(run.samples.len())) {
            let mean = |value: &dyn Fn(&Sample) -> f64| {
                block.iter().map(value).sum::<f64>() / block.len() as f64 * sign
            };
            let voltages = block.iter().enumerate();
            let voltages = voltages.map(|(i, s)| (i as f64 * PERIOD_S, s.back_emf_v));
            let change_v_s = slope(voltages).map_or(0.0, |slope| slope.value * sign);
            let rate_rad_s = mean(&|s| s.back_emf_v) / back_emf_per_rate;
            let change_rad_s2 = change_v_s / back_emf_per_rate;
            let current_a = mean(&|s| winding.current(s.driven).mean_a);
            points.push(([1.0, rate_rad_s, change_rad_s2], current_a));
        }
    }
    points
}
