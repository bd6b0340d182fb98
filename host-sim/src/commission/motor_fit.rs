//! Inertia, delay and friction from a recording of an excitation.
//!
//! The motor model of [`identification`] is fitted with resistance and torque constant held, and
//! again with each of these one standard error greater: what that changes is a part of the standard
//! errors. A delay that the recording determines worse than the board's timing, [`timing`], is held
//! at that. An eccentric magnet scales the measured angle around the centre of the excitation, and
//! with it the inertia. Free are inertia, delay, friction, a load, and the backlash, which a delay
//! would otherwise stand for.

use identification::{Experiment, Fit, Hold, Options, Problem, Quiet, Recording, fit, models};
use model_core::time::PWM_RATE_HZ;

use super::comparison::Comparison;
use super::resistance::{COPPER_K, Cold, TEMPERATURE_K};
use super::runs::ECCENTRICITY_DEG;
use super::samples::Sample;
use super::tuning::DELAY_S;
use super::winding::Winding;
use super::{CommissionError, Estimate, PERIOD_S, Step, refuse, uniform};

const STEP: Step = Step::Dynamics;

/// The supply of a recording whose duty is computed from the voltage, V: any.
const SUPPLY_V: f64 = 10.0;

/// Starting value of the backlash, one count of the encoder, deg: without any it has no slope.
const START_BACKLASH_DEG: f64 = 0.1;

/// Length of a PWM period, s.
const PWM_PERIOD_S: f64 = 1.0 / PWM_RATE_HZ as f64;

/// The delay of the board's timing. What the model leaves out changes it by half a PWM period at
/// most: a drive begins at the start of a period, the current follows it, and the gears yield.
pub fn timing() -> Estimate {
    Estimate {
        value: DELAY_S,
        standard_error: uniform(PWM_PERIOD_S / 2.0),
    }
}

/// The part of that by which two recordings differ: from the mean of their duties a drive is off by
/// a quarter of a period at most.
fn of_duties_s() -> f64 {
    uniform(PWM_PERIOD_S / 4.0)
}

/// Where the search starts.
pub struct Start {
    /// Inertia, kg m^2.
    pub inertia_kg_m2: f64,
    /// Coulomb friction, Nm.
    pub coulomb_nm: f64,
}

/// What is held.
pub struct Motor {
    winding: Winding,
    /// Standard error of its resistance, ohm.
    resistance_error_ohm: f64,
    torque_per_current_nm_a: Estimate,
}

impl Motor {
    /// With a winding that is so much warmer than 25 deg C, K.
    pub fn of(cold: &Cold, torque_per_current_nm_a: Estimate, warm_k: f64) -> Self {
        let Estimate {
            value,
            standard_error,
        } = cold.resistance_ohm;
        let ratio = 1.0 + COPPER_K * warm_k;
        Self {
            winding: Winding {
                resistance_ohm: value * ratio,
                ..cold.winding
            },
            resistance_error_ohm: standard_error * ratio,
            torque_per_current_nm_a,
        }
    }
}

/// An estimate by a fit, with the shares of its error.
#[derive(Debug, Clone, Copy)]
pub struct Fitting {
    value: f64,
    /// Of the fit.
    of_fit: f64,
    /// Of the temperature of the winding and of a held delay, which differ between two recordings.
    of_recording: f64,
    /// Of what is held, which two recordings have in common.
    of_held: f64,
}

impl Fitting {
    /// With the whole error.
    pub fn whole(self) -> Estimate {
        Estimate {
            value: self.value,
            standard_error: self.of_fit.hypot(self.of_held),
        }
    }

    /// With the error that it does not have in common with that of another recording.
    pub fn against_another(self) -> Estimate {
        Estimate {
            value: self.value,
            standard_error: self.of_fit.hypot(self.of_recording),
        }
    }
}

/// The motor of a recording.
pub struct Fitted {
    /// Inertia at the output, kg m^2.
    pub inertia_kg_m2: Fitting,
    /// Delay, s, where the recording determines it.
    pub delay_s: Option<Fitting>,
    /// Coulomb friction, Nm, where the recording determines it.
    pub coulomb_nm: Option<Fitting>,
    /// Free play, deg, where the recording determines it.
    pub backlash_deg: Option<Estimate>,
    /// The recording against the fit.
    pub comparison: Comparison,
    /// The values that do not belong to the recording alone.
    values: Vec<(&'static str, f64)>,
}

const INERTIA: &str = "motor_inertia_kg_m2";
const DELAY: &str = "delay_s";
const COULOMB: &str = "coulomb_friction_nm";
const VISCOUS: &str = "viscous_friction_nm_s_deg";
const BACKLASH: &str = "backlash_deg";

impl Fitted {
    /// Fits the samples of a recording.
    pub fn of(samples: &[Sample], motor: &Motor, start: &Start) -> Result<Self, CommissionError> {
        let constant = motor.torque_per_current_nm_a;
        let resistance_ohm = motor.winding.resistance_ohm;
        let experiment = experiment(samples, &motor.winding)?;
        let mut starting = vec![
            (INERTIA, start.inertia_kg_m2),
            (COULOMB, start.coulomb_nm),
            (BACKLASH, START_BACKLASH_DEG),
        ];
        let mut values = Held {
            constant_nm_a: constant.value,
            resistance_ohm,
            delay_s: None,
        };
        starting.push((DELAY, PERIOD_S));
        let mut here = solve(&experiment, &values, (&[], &starting), STARTS)?;
        let known = timing();
        let is_better = |delay: Estimate| delay.standard_error < known.standard_error;
        if !determined(&here, DELAY).is_ok_and(is_better) {
            starting.pop();
            values.delay_s = Some(known.value);
            here = solve(&experiment, &values, (&[], &starting), STARTS)?;
        }
        let found: Vec<_> = here.estimates.iter().filter(|e| !e.fixed).collect();
        let found: Vec<_> = found.iter().map(|e| (e.name, e.value)).collect();
        let other = |values: Held| solve(&experiment, &values, (&[], &found), 1);
        let with_constant = other(Held {
            constant_nm_a: constant.value + constant.standard_error,
            ..values
        })?;
        let with_resistance = other(Held {
            resistance_ohm: resistance_ohm + motor.resistance_error_ohm,
            ..values
        })?;
        let with_delay = values.delay_s.map(|delay_s| {
            other(Held {
                delay_s: Some(delay_s + known.standard_error),
                ..values
            })
        });
        let with_delay = with_delay.transpose()?;
        let fitting = |name: &'static str| {
            let Estimate {
                value,
                standard_error,
            } = determined(&here, name)?;
            let shift = |fit: &Fit| fit.value(name).map_or(f64::NAN, |other| other - value);
            let of_resistance = shift(&with_resistance);
            let of_delay = with_delay.as_ref().map_or(0.0, shift);
            let of_other_delay = of_delay / known.standard_error * of_duties_s();
            // The same magnet made the error of the constant.
            let of_angle = match name {
                INERTIA => value * uniform(ECCENTRICITY_DEG.to_radians()),
                _ => 0.0,
            };
            let share = resistance_ohm / motor.resistance_error_ohm;
            let of_motor = of_resistance.hypot(shift(&with_constant).abs() + of_angle);
            Ok::<_, CommissionError>(Fitting {
                value,
                of_fit: standard_error.hypot(if name == DELAY { of_duties_s() } else { 0.0 }),
                of_recording: (of_resistance * share * uniform(COPPER_K * TEMPERATURE_K))
                    .hypot(of_other_delay),
                of_held: of_motor.hypot(of_delay),
            })
        };
        Ok(Self {
            inertia_kg_m2: fitting(INERTIA)?,
            delay_s: match values.delay_s {
                None => Some(fitting(DELAY)?),
                Some(_) => None,
            },
            coulomb_nm: fitting(COULOMB).ok(),
            backlash_deg: determined(&here, BACKLASH).ok(),
            comparison: comparison(&experiment, &here),
            values: [INERTIA, COULOMB, VISCOUS, BACKLASH, DELAY]
                .into_iter()
                .filter_map(|name| Some((name, here.value(name)?)))
                .collect(),
        })
    }

    /// Another recording against this motor.
    pub fn predict(
        &self,
        samples: &[Sample],
        motor: &Motor,
    ) -> Result<Comparison, CommissionError> {
        let experiment = experiment(samples, &motor.winding)?;
        let held = Held {
            constant_nm_a: motor.torque_per_current_nm_a.value,
            resistance_ohm: motor.winding.resistance_ohm,
            delay_s: None,
        };
        let fit = solve(&experiment, &held, (&self.values, &[]), 1)?;
        Ok(comparison(&experiment, &fit))
    }
}

fn comparison(experiment: &Experiment, fit: &Fit) -> Comparison {
    let recording = &experiment.recording;
    let fitted = fit.experiments.first();
    Comparison {
        command_deg: recording.command_deg.clone(),
        measured_deg: recording.angle_deg.clone(),
        predicted_deg: fitted.map_or_else(Vec::new, |fitted| fitted.predicted_deg.clone()),
    }
}

/// Starting points of the first search.
const STARTS: usize = 4;

/// The experiment of a recording. Its voltage is that which makes the mean current of each control
/// period, with dead times and window.
fn experiment(samples: &[Sample], winding: &Winding) -> Result<Experiment, CommissionError> {
    let pairs = || samples.windows(2);
    let duty_pct = pairs().map(|pair| {
        let driven = pair[1].driven;
        let resistive_v = winding.current(driven).mean_a * winding.resistance_ohm;
        (resistive_v + driven.back_emf_v) / SUPPLY_V * 100.0
    });
    let recording = Recording {
        name: "excitation".into(),
        time_s: pairs()
            .enumerate()
            .map(|(i, _)| i as f64 * PERIOD_S)
            .collect(),
        command_deg: pairs()
            .map(|pair| f64::from(pair[0].command_mdeg) * 1e-3)
            .collect(),
        angle_deg: pairs().map(|pair| pair[0].angle_deg).collect(),
        duty_pct: Some(duty_pct.collect()),
        supply_v: Some(vec![SUPPLY_V; samples.len().saturating_sub(1)]),
        hold: Hold::Zero,
        ..Recording::default()
    };
    Experiment::try_new(recording).or_else(|error| refuse(STEP, error.to_string()))
}

/// What a fit holds.
#[derive(Debug, Clone, Copy)]
struct Held {
    /// Torque per current, Nm/A.
    constant_nm_a: f64,
    /// Resistance, ohm.
    resistance_ohm: f64,
    /// Delay, s, unless it is free.
    delay_s: Option<f64>,
}

/// Values of parameters, by their names.
type Values<'a> = &'a [(&'a str, f64)];

fn solve(
    experiment: &Experiment,
    held: &Held,
    (fixed, starting): (Values<'_>, Values<'_>),
    starts: usize,
) -> Result<Fit, CommissionError> {
    let Some(model) = models::named("motor-m1") else {
        return refuse(STEP, "there is no model motor-m1");
    };
    let solve = || {
        let mut problem = Problem::try_new(model, vec![experiment.clone()])?;
        problem.fix("torque_constant_nm_a", held.constant_nm_a)?;
        problem.fix("winding_resistance_ohm", held.resistance_ohm)?;
        if let Some(delay_s) = held.delay_s {
            problem.fix(DELAY, delay_s)?;
        }
        problem.free("load_torque_nm")?;
        problem.free(BACKLASH)?;
        for (name, value) in fixed {
            problem.fix(name, *value)?;
        }
        for (name, value) in starting {
            // The objects have wider ranges than the search.
            let specs = problem.specs.iter();
            let bounds = specs.filter(|spec| spec.parameter.name == *name);
            let within = bounds.fold(*value, |value, spec| value.max(spec.low).min(spec.high));
            problem.start(name, within)?;
        }
        let options = Options {
            starts,
            ..Options::default()
        };
        fit(&problem, &options, &Quiet)
    };
    solve().or_else(|error: identification::IdentifyError| refuse(STEP, error.to_string()))
}

/// An estimate that the fit determines.
fn determined(fit: &Fit, name: &'static str) -> Result<Estimate, CommissionError> {
    let found = fit.estimate(name).filter(|e| !e.is_undetermined());
    let found = found.map(|e| Estimate {
        value: e.value,
        standard_error: e.standard_error_coloured.max(e.standard_error),
    });
    found.map_or_else(
        || {
            refuse(
                STEP,
                format!("{name} cannot be identified from the excitation"),
            )
        },
        Ok,
    )
}
