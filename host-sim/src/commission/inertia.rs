//! The last measurement: two excitations around the centre of the range give inertia and delay,
//! each for itself.
//!
//! The board records both in each control period. The motor model of [`identification`] is fitted
//! to them with resistance and torque constant held, and to each with both of these one standard
//! error greater: what that changes is a part of the standard errors. The second excitation
//! validates the first.

use std::time::Duration;

use identification::{Experiment, Fit, Hold, Options, Problem, Quiet, Recording, fit, models};

use super::resistance::{COPPER_K, Cold, winding_deg_c};
use super::runs::{Runs, arrive};
use super::samples::{Board, SIGNALS, Sample, real};
use super::winding::Winding;
use super::{CommissionError, Estimate, Limits, PERIOD_S, record, refuse};
use crate::can::client::{Client, ClientError};
use crate::can::excitation;

const STEP: &str = "inertia and delay";

/// An excitation: its name, and the values of the sub-indices of 2020h.
type Excitation = (&'static str, &'static [(u8, i32)]);

/// Settings of 2020h that the excitations change.
pub const SETTINGS: [&str; 9] = [
    "2020:3", "2020:4", "2020:5", "2020:6", "2020:7", "2020:8", "2020:9", "2020:11", "2020:12",
];

/// A chirp over the band of the position loop, within 5 deg.
const CHIRP: Excitation = (
    "the chirp",
    &[(3, 5), (4, 5_000), (5, 300), (6, 4_000), (7, 4_000), (12, 1)],
);

/// Eight odd multiples of 0.4 Hz, to 6 Hz.
const MULTISINE: Excitation = (
    "the multisine",
    &[(3, 9), (4, 2_000), (5, 400), (11, 8), (12, 2)],
);

/// Longest excitation.
const LONGEST: Duration = Duration::from_secs(10);

/// Time at rest before each excitation.
const REST: Duration = Duration::from_millis(200);

/// The supply of a recording whose duty is computed from the voltage, V: any.
const SUPPLY_V: f64 = 10.0;

/// Standard errors of the ends of an interval of 95 %.
const INTERVAL: f64 = 2.0;

/// What the excitations give.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Dynamics {
    /// Inertia at the output, kg m^2.
    pub inertia_kg_m2: Estimate,
    /// Time from the control period that decides a duty to the one that measures its effect, s.
    pub delay_s: Estimate,
    /// What the second excitation contradicts.
    pub contradictions: Vec<String>,
}

/// Excites, and fits.
pub fn measure(
    client: &mut Client,
    limits: &Limits,
    board: &Board,
    known: (&Cold, Estimate, &Runs),
) -> Result<Dynamics, CommissionError> {
    let (low, high) = limits.range_mdeg;
    let start = Start {
        inertia_kg_m2: real(client, "2011:4")?,
        coulomb_nm: real(client, "2011:6")?,
    };
    let mut fitted = Vec::new();
    for (name, settings) in [CHIRP, MULTISINE] {
        let (samples, warm_k) = excite(client, low.midpoint(high), board, settings)?;
        let motor = Motor::of(known.0, known.1, warm_k);
        fitted.push((name, Fitted::of(&samples, &motor, &start)?));
    }
    let [(first, one), (second, other)] = &fitted[..] else {
        return refuse(STEP, "no excitation");
    };
    println!("{first} {:?} {:?} {second} {:?} {:?}", one.inertia_kg_m2, one.delay_s, other.inertia_kg_m2, other.delay_s);
    let pairs = [
        ("inertia", "kg m^2", one.inertia_kg_m2, other.inertia_kg_m2),
        ("delay", "s", one.delay_s, other.delay_s),
    ];
    let contradictions = pairs.iter().filter_map(|(name, unit, one, other)| {
        let (one, other) = (one.of_fit, other.of_fit);
        let reach = INTERVAL * (one.standard_error + other.standard_error);
        ((one.value - other.value).abs() > reach).then(|| {
            format!(
                "{name} {:.3e} +- {:.1e} {unit} of {first}, {:.3e} +- {:.1e} {unit} of {second}",
                one.value, one.standard_error, other.value, other.standard_error
            )
        })
    });
    Ok(Dynamics {
        contradictions: contradictions.collect(),
        inertia_kg_m2: one.inertia_kg_m2.whole(),
        delay_s: one.delay_s.whole(),
    })
}

/// The samples of an excitation, and how much warmer than 25 deg C the winding was.
fn excite(
    client: &mut Client,
    centre_mdeg: i32,
    board: &Board,
    settings: &[(u8, i32)],
) -> Result<(Vec<Sample>, f64), CommissionError> {
    for (sub, value) in settings {
        client.write(&format!("2020:{sub}"), &value.to_string())?;
    }
    client.enable(1)?;
    arrive(client, centre_mdeg)?;
    client.pause(REST)?;
    let (capture, moved) = record(client, &SIGNALS, |client| {
        excitation::start(client)?;
        let done = wait(client);
        let stopped = match done {
            Ok(()) => Ok(()),
            Err(_) => client.write("2020:1", "0"),
        };
        done.and(stopped)
    })?;
    moved?;
    let warm_k = winding_deg_c(client)? - super::resistance::COLD_DEG_C;
    Ok((board.samples(&capture), warm_k))
}

fn wait(client: &mut Client) -> Result<(), ClientError> {
    let step = Duration::from_millis(20);
    for _ in 0..LONGEST.as_millis() / step.as_millis() {
        client.pause(step)?;
        if client.integer("2020:2")? == 0 {
            return Ok(());
        }
        if client.status()? & 0x6F != 0x27 {
            break;
        }
    }
    client.fail_in_state("expected the excitation to end")
}

/// Where the search starts.
struct Start {
    inertia_kg_m2: f64,
    coulomb_nm: f64,
}

/// What is held.
struct Motor {
    winding: Winding,
    /// Standard error of its resistance, ohm.
    resistance_error_ohm: f64,
    torque_per_current_nm_a: Estimate,
}

impl Motor {
    fn of(cold: &Cold, torque_per_current_nm_a: Estimate, warm_k: f64) -> Self {
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

/// An estimate by a fit, and the share of its error that comes from what is held.
#[derive(Debug, Clone, Copy)]
struct Fitting {
    of_fit: Estimate,
    of_held: f64,
}

impl Fitting {
    fn whole(self) -> Estimate {
        Estimate {
            value: self.of_fit.value,
            standard_error: self.of_fit.standard_error.hypot(self.of_held),
        }
    }
}

struct Fitted {
    inertia_kg_m2: Fitting,
    delay_s: Fitting,
}

const INERTIA: &str = "motor_inertia_kg_m2";
const DELAY: &str = "delay_s";

impl Fitted {
    fn of(samples: &[Sample], motor: &Motor, start: &Start) -> Result<Self, CommissionError> {
        let constant = motor.torque_per_current_nm_a;
        let resistance_ohm = motor.winding.resistance_ohm;
        let experiment = experiment(samples, &motor.winding)?;
        let starting = [
            (INERTIA, start.inertia_kg_m2),
            ("coulomb_friction_nm", start.coulomb_nm),
            (DELAY, PERIOD_S),
        ];
        let held = |constant_nm_a: f64, ohm: f64, starts: &[(&str, f64)], count: usize| {
            solve(&experiment, (constant_nm_a, ohm), starts, count)
        };
        let here = held(constant.value, resistance_ohm, &starting, STARTS)?;
        let found: Vec<_> = here.estimates.iter().filter(|e| !e.fixed).collect();
        let found: Vec<_> = found.iter().map(|e| (e.name, e.value)).collect();
        let others = [
            held(constant.value + constant.standard_error, resistance_ohm, &found, 1)?,
            held(constant.value, resistance_ohm + motor.resistance_error_ohm, &found, 1)?,
        ];
        for e in here.estimates.iter().filter(|e| !e.fixed) { println!("   {} {:.5} se {:.5} col {:.5}", e.name, e.value, e.standard_error, e.standard_error_coloured); }
        println!("   noise {} fit {}", here.noise_deg, here.fit_percent);
        let fitting = |name: &'static str| {
            let of_fit = determined(&here, name)?;
            let shifts = others.iter().filter_map(|fit| fit.value(name));
            let of_held = shifts.map(|value| value - of_fit.value).fold(0.0, f64::hypot);
            Ok::<_, CommissionError>(Fitting { of_fit, of_held })
        };
        Ok(Self {
            inertia_kg_m2: fitting(INERTIA)?,
            delay_s: fitting(DELAY)?,
        })
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
        time_s: pairs().enumerate().map(|(i, _)| i as f64 * PERIOD_S).collect(),
        command_deg: pairs().map(|pair| f64::from(pair[0].command_mdeg) * 1e-3).collect(),
        angle_deg: pairs().map(|pair| pair[0].angle_deg).collect(),
        duty_pct: Some(duty_pct.collect()),
        supply_v: Some(vec![SUPPLY_V; samples.len().saturating_sub(1)]),
        hold: Hold::Zero,
        ..Recording::default()
    };
    Experiment::try_new(recording).or_else(|error| refuse(STEP, error.to_string()))
}

fn solve(
    experiment: &Experiment,
    (torque_per_current_nm_a, resistance_ohm): (f64, f64),
    starting: &[(&str, f64)],
    starts: usize,
) -> Result<Fit, CommissionError> {
    let Some(model) = models::named("motor-m1") else {
        return refuse(STEP, "there is no model motor-m1");
    };
    let solve = || {
        let mut problem = Problem::try_new(model, vec![experiment.clone()])?;
        problem.fix("torque_constant_nm_a", torque_per_current_nm_a)?;
        problem.fix("winding_resistance_ohm", resistance_ohm)?;
        problem.free("load_torque_nm")?;
        if std::env::var("BL").is_ok() || true { problem.free("backlash_deg")?; problem.start("backlash_deg", 0.1)?; }
        for (name, value) in starting {
            problem.start(name, *value)?;
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
    match found {
        Some(estimate) => Ok(estimate),
        _ => refuse(STEP, format!("{name} cannot be identified from the excitation")),
    }
}
