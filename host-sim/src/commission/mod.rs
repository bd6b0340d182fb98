//! Commissioning of an actuator over its bus: its wiring is checked at limited current; pulses give
//! the resistance, runs over a turn the error of the encoder, runs at constant rate torque constant
//! and friction, excitations inertia and delay; gains follow, and the baseline of the health.
//! Nothing is saved before all steps have succeeded.

mod baseline;
mod centre;
mod comparison;
mod encoder;
mod excite;
mod friction;
mod inertia;
mod motor_fit;
mod page;
mod regression;
mod request;
mod resistance;
mod runs;
mod samples;
mod step;
mod stops;
mod tables;
#[cfg(test)]
mod tests;
mod tuning;
mod winding;
mod winding_fit;
mod wiring;
mod write;

use firmware::capture::Signal;

use crate::can::capture::Capture;
use crate::can::client::{Client, ClientError};

pub use baseline::{Baseline, baseline};
pub use centre::centre;
pub use comparison::Comparison;
pub use encoder::{EncoderError, ErrorPoint, Harmonics};
pub use friction::{Direction, Friction};
pub use inertia::{Contradiction, Dynamics, Parameter};
pub use page::page;
pub use request::{Answer, end_old_requests, is_requested};
pub use runs::ConstantRate;
pub use step::Step;
pub use stops::LEAST_MDEG as LEAST_RANGE_MDEG;
pub use tuning::{Margins, Proposal, Tuning, tune};
pub use wiring::{Pulse, judge};
pub use write::{Kept, write};

/// A value with its standard error.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// Whether it is above zero by three standard errors.
    pub fn is_known(self) -> bool {
        self.value > 3.0 * self.standard_error
    }

    /// The mean of two values whose errors have common sources.
    fn mean(self, other: Self) -> Self {
        Self {
            value: self.value.midpoint(other.value),
            standard_error: self.standard_error.max(other.standard_error),
        }
    }

    /// The standard error as a share of the value.
    fn relative(self) -> f64 {
        self.standard_error / self.value.abs()
    }

    /// Divided by a number that is known.
    fn over(self, divisor: f64) -> Self {
        Self {
            value: self.value / divisor,
            standard_error: self.standard_error / divisor,
        }
    }
}

/// What is measured.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Findings {
    /// The range of the angle, mdeg.
    pub range_mdeg: (i32, i32),
    /// The origin 2041h:3 by which the middle of the range is 0, after [`centre()`], mdeg.
    pub origin_mdeg: Option<i32>,
    /// Resistance of winding, brushes and bridge at 25 deg C, ohm.
    pub resistance_ohm: Estimate,
    /// Inductance of the winding, H.
    pub inductance_h: f64,
    /// The error of the encoder.
    pub encoder: EncoderError,
    /// Torque constant of the motor by the gear ratio 2011h:3, Nm/A.
    pub torque_constant_nm_a: Estimate,
    /// Back-EMF by rate of the output, V s/rad.
    pub back_emf_v_s: Estimate,
    /// The runs at constant rate that give it.
    pub constant_rates: Vec<ConstantRate>,
    /// Friction at the output.
    pub friction: Friction,
    /// Inertia and delay.
    pub dynamics: Dynamics,
    /// Lowest supply voltage of all runs, V.
    pub least_supply_v: f64,
    /// Highest temperature of the board, deg C.
    pub temperature_deg_c: f64,
    /// The gains, after [`tune`].
    pub tuning: Option<Tuning>,
    /// The baseline of the health, after [`baseline()`].
    pub baseline: Option<Baseline>,
}

impl Findings {
    /// The objects of range and origin, and their values, mdeg.
    pub fn positions(&self) -> impl Iterator<Item = (&'static str, i32)> {
        let (low, high) = self.range_mdeg;
        let origin = self.origin_mdeg.map(|origin| (centre::ORIGIN, origin));
        [("607D:1", low), ("607D:2", high)]
            .into_iter()
            .chain(origin)
    }

    /// The other objects in which the findings are stored, and their values. Friction has one value
    /// for both directions; what is not known from zero, or contradicted, is not stored. Where the
    /// viscous friction is not, the Coulomb friction is that beside the present one.
    pub fn objects(&self) -> Vec<(&'static str, f64)> {
        let agrees = |parameter| {
            let mut others = self.dynamics.contradictions.iter();
            others.all(|contradiction| contradiction.parameter != parameter)
        };
        let mut objects = vec![
            ("2011:1", self.resistance_ohm.value),
            ("2011:2", self.torque_constant_nm_a.value),
        ];
        objects.extend(self.encoder.objects());
        if agrees(Parameter::Inertia) {
            objects.push(("2011:4", self.dynamics.inertia_kg_m2.value));
        }
        let Friction { upward, downward } = self.friction;
        let viscous = upward.viscous_nm_s.mean(downward.viscous_nm_s);
        let coulomb = match viscous.is_known() {
            true => upward.coulomb_nm.mean(downward.coulomb_nm),
            false => (upward.coulomb_beside_nm).mean(downward.coulomb_beside_nm),
        };
        if viscous.is_known() {
            objects.push(("2011:5", viscous.value));
        }
        if coulomb.is_known() && agrees(Parameter::Coulomb) {
            objects.push(("2011:6", coulomb.value));
        }
        objects.extend(self.tuning.iter().flat_map(Tuning::objects));
        objects.extend(self.baseline.iter().flat_map(Baseline::objects));
        objects
    }
}

/// Why an actuator is not commissioned.
#[derive(Debug, thiserror::Error)]
pub enum CommissionError {
    /// The bus or the actuator.
    #[error(transparent)]
    Client(#[from] ClientError),
    /// A step refuses.
    #[error("{step}: {why}")]
    Refused {
        /// The step.
        step: Step,
        /// What was found, and what was expected.
        why: String,
    },
}

/// The limits of the motion.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// The range of the angle, which becomes 607Dh unless [`centre()`] follows, mdeg; without it
    /// the stops are found.
    pub range_mdeg: Option<(i32, i32)>,
    /// Highest mean current, in thousandths of the rated current 6075h; a lower 6072h or 6073h
    /// counts.
    pub permille: u16,
    /// Highest rate of the runs, mdeg/s.
    pub rate_mdeg_s: i32,
}

impl Limits {
    /// Limits the current by 6072h, whose value of before is restored with the others. Returns the
    /// limits within what 6072h and 6073h were.
    fn limit_current(&self, client: &mut Client) -> Result<Self, CommissionError> {
        let most = client.integer("6072")?.min(client.integer("6073")?);
        let permille = u16::try_from(most).unwrap_or(u16::MAX).min(self.permille);
        if permille == 0 {
            return refuse(Step::Wiring, "6072h or 6073h is 0, expected a current");
        }
        client.write("6072", &permille.to_string())?;
        Ok(Self { permille, ..*self })
    }
}

/// Relative error of the gain of a measurement: resistors of 1 %.
const GAIN_ERROR: f64 = 0.01;

/// Length of a control period, s.
const PERIOD_S: f64 = model_core::time::CONTROL_PERIOD_US as f64 * 1e-6;

/// The standard deviation of a uniform distribution between minus and plus this value.
fn uniform(largest: f64) -> f64 {
    largest / 3.0_f64.sqrt()
}

/// Checks the wiring and measures. The drive is off afterwards, but for a failure.
///
/// # Errors
/// [`CommissionError`].
pub fn measure(client: &mut Client, limits: &Limits) -> Result<Findings, CommissionError> {
    steps(client, limits, &mut |_| {}).map_err(with_cause)
}

/// Faults that may come before the step that finds their cause: the error code, the step, and the
/// cause.
const CAUSES: [(&str, Step, &str); 2] = [
    // Faults 14 and 20.
    (
        "5210h",
        Step::Current,
        "the gain of the current measurement is wrong, or it is lost",
    ),
    // Faults 2 and 3.
    (
        "7306h",
        Step::Encoder,
        "the magnet is weak or lost: its distance to the encoder is wrong, or it is not centred",
    ),
];

/// An error with the cause of the fault in it.
fn with_cause(error: CommissionError) -> CommissionError {
    let text = error.to_string();
    let cause = CAUSES.iter().find(|(code, ..)| text.contains(code));
    match cause {
        Some((_, step, cause)) => CommissionError::Refused {
            step: *step,
            why: format!("{cause}; {text}"),
        },
        None => error,
    }
}

fn steps(
    client: &mut Client,
    limits: &Limits,
    report: &mut dyn FnMut(&str),
) -> Result<Findings, CommissionError> {
    report("checks the wiring");
    client.quick_stop()?;
    if let Some(range_mdeg) = limits.range_mdeg {
        wiring::check_room(client, range_mdeg)?;
    }
    wiring::check_temperature(client)?;
    // So far above the rate of the runs that the limit does not act on them.
    client.write("6080", &(limits.rate_mdeg_s / 4 * 5).to_string())?;
    let limits = &limits.limit_current(client)?;
    let mut board = samples::Board::of(client)?;
    wiring::check(client, limits, &board)?;
    report("measures the resistance");
    let cold = resistance::measure(client, limits, &mut board)?;
    // By it the board limits the current of what follows.
    board.set_resistance(client, cold.resistance_ohm.value)?;
    let find_stops = |client: &mut Client, report: &mut dyn FnMut(&str)| {
        report("finds the stops");
        stops::find(client, limits)
    };
    let range_mdeg = match limits.range_mdeg {
        Some(range_mdeg) => range_mdeg,
        None => find_stops(client, report)?,
    };
    if encoder::has_span(range_mdeg) {
        report("measures the error of the encoder");
    }
    let encoder = encoder::measure(client, range_mdeg, limits, &board)?;
    // With another correction the stops are at other angles.
    let range_mdeg = match (limits.range_mdeg, &encoder.harmonics) {
        (None, Some(_)) => find_stops(client, report)?,
        _ => range_mdeg,
    };
    report("measures torque constant and friction");
    let runs = runs::measure(
        client,
        (range_mdeg, limits.rate_mdeg_s),
        (&board, &cold.winding),
    )?;
    resistance::check(&cold, &runs.runs)?;
    let constant = runs.back_emf_per_rate()?;
    let held_nm_s = samples::real(client, "2011:5")?;
    let friction = friction::measure(&runs, &cold, constant, held_nm_s)?;
    report("measures inertia and delay");
    let dynamics = inertia::measure(client, range_mdeg, &board, (&cold, constant, &friction))?;
    client.quick_stop()?;
    let ratio = samples::real(client, "2011:3")?;
    Ok(Findings {
        range_mdeg,
        origin_mdeg: None,
        resistance_ohm: cold.resistance_ohm,
        inductance_h: cold.winding.inductance_h,
        encoder,
        torque_constant_nm_a: constant.over(ratio),
        back_emf_v_s: constant,
        constant_rates: runs.runs.iter().map(|run| run.mean).collect(),
        friction,
        dynamics,
        least_supply_v: runs.least_supply_v,
        temperature_deg_c: runs.temperature_deg_c,
        tuning: None,
        baseline: None,
    })
}

/// All steps but the write: measures, finds the gains if `tunes`, and takes the baseline of the
/// health. `report` gets the step that begins. The drive is off afterwards, but for a failure; the
/// parameters are those of before only after [`Kept::restore`].
///
/// # Errors
/// [`CommissionError`].
pub fn find(
    client: &mut Client,
    limits: &Limits,
    (kept, tunes): (&Kept, bool),
    mut report: impl FnMut(&str),
) -> Result<Findings, CommissionError> {
    let mut findings = steps(client, limits, &mut report).map_err(with_cause)?;
    if tunes {
        report("finds gains, and verifies them");
        findings.tuning = Some(tune(client, &findings)?);
    }
    report("takes the baseline of the health");
    findings.baseline = Some(baseline(client, limits, kept, &findings)?);
    Ok(findings)
}

/// A refusal of a step.
fn refuse<T>(step: Step, why: impl Into<String>) -> Result<T, CommissionError> {
    let why = why.into();
    Err(CommissionError::Refused { step, why })
}

/// Records these signals during a motion. The error of the motion follows the recording, which
/// shows why.
fn record(
    client: &mut Client,
    signals: &[Signal],
    motion: impl FnOnce(&mut Client) -> Result<(), ClientError>,
) -> Result<(Capture, Result<(), ClientError>), ClientError> {
    client.write("2030:1", "0")?;
    for sub in 1..=8 {
        let signal = signals.get(sub - 1).map_or(255, |signal| *signal as u8);
        client.write(&format!("2031:{sub}"), &signal.to_string())?;
    }
    client.write("2030:5", "1")?;
    client.write("2030:3", "0")?;
    client.write("2030:1", "1")?;
    let moved = motion(client);
    client.write("2030:1", "0")?;
    match (Capture::upload(client), moved) {
        (Ok(capture), moved) => Ok((capture, moved)),
        // A motion that fails at once leaves no record.
        (Err(_), Err(error)) | (Err(error), Ok(())) => Err(error),
    }
}
