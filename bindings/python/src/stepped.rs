//! An actuator that is stepped by its caller.

use std::sync::{Mutex, MutexGuard, PoisonError};

use host_sim::{
    input::file::{COMMAND, LOAD, Quantity},
    settings::{ModelKind, PlantKind, Pwm, Settings},
};
use model_core::{
    actuator::{self, COMMAND_RANGE, CommandError, InputLevel},
    named::Named,
    parameter::Shown,
    scenario::LONGEST_S,
    time::{TICKS_PER_SECOND, ticks},
};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict},
};
use serde::{Deserialize, Serialize};

use crate::{exception::raised, request::scenario};

/// Ticks between two checks for an interrupt: 10 s, which take the slowest plant less than 0.1 s.
const TICKS_PER_CHECK: u64 = 200_000;

/// The longest run, ticks: four months.
const MOST_TICKS: u64 = (LONGEST_S as u64) * TICKS_PER_SECOND;

/// The outputs of an actuator, in the order of `smart_actuator.Reading`.
type Reading = (f64, f64, f64, f64, f64, f64, f64, f64, f64);

/// The origin of an actuator: version, model, plant, bridge, seed and parameters.
type Origin = (String, ModelKind, PlantKind, Pwm, u64, Vec<f64>);

/// The state, with a delay line of the length of the delay.
type State = actuator::Actuator<Vec<f64>>;

/// An actuator, and the time that its caller has reached.
#[derive(Clone, Serialize, Deserialize)]
struct Stepped {
    actuator: Box<State>,
    /// Time of the caller beyond the tick of the actuator, in ticks: at most half a tick, as each
    /// step ends at the nearest one.
    beyond: f64,
}

impl Stepped {
    /// The ticks of a step of this length, and what remains beyond them.
    fn ticks_for(&self, seconds: f64) -> (u64, f64) {
        let exact = seconds * TICKS_PER_SECOND as f64 + self.beyond;
        // Half a tick of the last step may be more than this one.
        let whole = exact.round().max(0.0);
        (whole as u64, exact - whole)
    }
}

/// An actuator that is stepped by its caller. A lock serialises threads.
#[pyclass(frozen, module = "smart_actuator._native")]
pub struct Actuator {
    settings: Settings,
    state: Mutex<Stepped>,
}

impl Actuator {
    fn with(settings: Settings, state: Stepped) -> Self {
        Self {
            settings,
            state: Mutex::new(state),
        }
    }

    /// Advances by the ticks that `plan` returns for the state, after which the caller is beyond
    /// its tick by the second number, and checks for an interrupt meanwhile.
    fn run(
        &self,
        py: Python<'_>,
        (input, value): (InputLevel, f64),
        plan: impl FnOnce(&Stepped) -> PyResult<(u64, f64)> + Send,
    ) -> PyResult<Reading> {
        py.detach(|| {
            let mut state = self.state();
            let (mut left, beyond) = plan(&state)?;
            if left > MOST_TICKS {
                let problem = format!("a step of {left} ticks, expected {MOST_TICKS} at most");
                return Err(PyValueError::new_err(problem));
            }
            loop {
                let now = left.min(TICKS_PER_CHECK);
                let done = state.actuator.advance_with(input, value, now);
                done.map_err(|error| not_commanded(error, input, value))?;
                left -= now;
                if left == 0 {
                    state.beyond = beyond;
                    return Ok(reading(&state.actuator));
                }
                // Other threads wait for the actuator without the interpreter lock.
                Python::attach(|py| py.check_signals())?;
            }
        })
    }

    /// Call it without the interpreter lock, which could otherwise cause a deadlock.
    fn state(&self) -> MutexGuard<'_, Stepped> {
        // A step does not panic, and no state is invalid: a poisoned lock can be used.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn has_load(&self) -> PyResult<()> {
        match (self.settings.model, self.settings.plant) {
            (ModelKind::Board, PlantKind::Drivetrain) => Ok(()),
            _ => Err(PyValueError::new_err(
                "a load torque applies to plant=\"bench\", no other has a load",
            )),
        }
    }

    fn origin(&self) -> Origin {
        let s = &self.settings;
        let values = s.values().map(|value| value.value).collect();
        let version = env!("CARGO_PKG_VERSION").into();
        (version, s.model, s.plant, s.pwm, s.seed, values)
    }
}

fn invalid(problem: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(format!("not a snapshot of an actuator: {problem}"))
}

/// The settings and the state of a snapshot.
fn kept(bytes: &[u8]) -> PyResult<(Settings, Stepped)> {
    let (origin, rest): (Origin, _) = postcard::take_from_bytes(bytes).map_err(invalid)?;
    let (version, model, plant, pwm, seed, values) = origin;
    if version != env!("CARGO_PKG_VERSION") {
        return Err(invalid(format!("it is of version {version}")));
    }
    let mut settings = Settings::new(model, plant);
    (settings.pwm, settings.seed) = (pwm, seed);
    let names: Vec<_> = settings.values().map(|v| v.parameter.name).collect();
    if names.len() != values.len() {
        return Err(invalid("it has other parameters"));
    }
    for (name, value) in names.into_iter().zip(values) {
        settings.set(name, value).map_err(invalid)?;
    }
    let state = postcard::from_bytes(rest).map_err(invalid)?;
    Ok((settings, state))
}

/// The exception for a number beyond its range.
fn refused(name: &str, value: f64, quantity: &Quantity) -> PyErr {
    let (range, unit) = (&quantity.range, quantity.unit);
    PyValueError::new_err(format!(
        "{name} is {}, expected {} from {} to {} {unit}",
        Shown(value),
        quantity.meaning,
        range.start(),
        range.end()
    ))
}

/// The input of this name.
fn level(name: &str) -> PyResult<InputLevel> {
    InputLevel::named(name).ok_or_else(|| {
        PyValueError::new_err(format!(
            "unknown input `{name}`, expected {}",
            InputLevel::NAMES.join(", ")
        ))
    })
}

/// The exception for a command that is refused.
fn not_commanded(error: CommandError, input: InputLevel, value: f64) -> PyErr {
    match (error, input) {
        (CommandError::Value, InputLevel::Position) => refused("command_deg", value, &COMMAND),
        (CommandError::Value, input) => PyValueError::new_err(format!(
            "the {} is {}, expected a number from {} to {} {}",
            input.name(),
            Shown(value),
            COMMAND_RANGE.start(),
            COMMAND_RANGE.end(),
            input.unit()
        )),
        (error, _) => PyValueError::new_err(error.to_string()),
    }
}

fn reading(state: &State) -> Reading {
    let now = state.reading();
    (
        model_core::time::seconds(state.tick()),
        now.command_deg,
        now.angle_deg,
        now.rate_deg_s,
        now.duty_pct,
        now.angle_meas_deg,
        now.rate_meas_deg_s,
        now.current_a,
        now.back_emf_v,
    )
}

#[pymethods]
impl Actuator {
    #[new]
    fn new(
        model: &str,
        plant: Option<&str>,
        preset: Option<String>,
        seed: u64,
        pwm: &str,
        parameters: Vec<(String, f64)>,
    ) -> PyResult<Self> {
        let scenario = scenario(model, plant, preset, seed, pwm, parameters);
        let settings = scenario.and_then(|s| s.settings()).map_err(raised)?;
        let state = State::try_with_ring(&settings);
        let actuator = state.map_err(|error| raised(error.into()))?;
        let stepped = Stepped {
            actuator: Box::new(actuator),
            beyond: 0.0,
        };
        Ok(Self::with(settings, stepped))
    }

    fn advance(&self, py: Python<'_>, input: &str, value: f64, ticks: u64) -> PyResult<Reading> {
        let command = (level(input)?, value);
        self.run(py, command, |state| Ok((ticks, state.beyond)))
    }

    fn advance_seconds(
        &self,
        py: Python<'_>,
        input: &str,
        value: f64,
        seconds: f64,
    ) -> PyResult<Reading> {
        let command = (level(input)?, value);
        self.run(py, command, |state| Ok(state.ticks_for(seconds)))
    }

    fn advance_to(
        &self,
        py: Python<'_>,
        input: &str,
        value: f64,
        time_s: f64,
    ) -> PyResult<Reading> {
        self.run(py, (level(input)?, value), |state| {
            let (target, now) = (ticks(time_s), state.actuator.tick());
            let step = target.checked_sub(now).ok_or_else(|| {
                let now_s = model_core::time::seconds(now);
                PyValueError::new_err(format!(
                    "time_s is {}, the actuator is at {now_s} s, expected no earlier time",
                    Shown(time_s)
                ))
            })?;
            Ok((step, time_s * TICKS_PER_SECOND as f64 - target as f64))
        })
    }

    fn reading(&self, py: Python<'_>) -> Reading {
        py.detach(|| reading(&self.state().actuator))
    }

    fn place(&self, py: Python<'_>, angle_deg: f64) -> PyResult<()> {
        if !COMMAND.range.contains(&angle_deg) {
            return Err(refused("angle_deg", angle_deg, &COMMAND));
        }
        py.detach(|| {
            let mut state = self.state();
            let now_s = model_core::time::seconds(state.actuator.tick());
            if now_s > 0.0 {
                return Err(PyValueError::new_err(format!(
                    "the actuator is at {now_s} s, expected a place before the first step"
                )));
            }
            let placed = state.actuator.place(angle_deg);
            placed.map_err(|error| PyValueError::new_err(error.to_string()))
        })
    }

    fn set_load_inertia(&self, py: Python<'_>, inertia_kg_m2: f64) -> PyResult<()> {
        self.has_load()?;
        let result = py.detach(|| self.state().actuator.set_load_inertia_kg_m2(inertia_kg_m2));
        result.map_err(|_| {
            PyValueError::new_err(format!(
                "inertia_kg_m2 is {inertia_kg_m2}, expected a finite inertia from 0, kg m^2"
            ))
        })
    }

    fn set_load_torque(&self, py: Python<'_>, torque_nm: f64) -> PyResult<()> {
        self.has_load()?;
        let result = py.detach(|| self.state().actuator.set_load_torque_nm(torque_nm));
        result.map_err(|_| refused("torque_nm", torque_nm, &LOAD))
    }

    #[getter]
    fn tick(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.state().actuator.tick())
    }

    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (s, all) = (&self.settings, PyDict::new(py));
        all.set_item("model", s.model.name())?;
        let plant = (s.model == ModelKind::Board).then(|| s.plant.name());
        all.set_item("plant", plant)?;
        all.set_item("pwm", s.pwm.name())?;
        all.set_item("seed", s.seed)?;
        let parameters = PyDict::new(py);
        for value in s.values() {
            parameters.set_item(value.parameter.name, value.value)?;
        }
        all.set_item("parameters", parameters)?;
        Ok(all)
    }

    fn snapshot<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = py.detach(|| postcard::to_stdvec(&(self.origin(), &*self.state())));
        Ok(PyBytes::new(py, &bytes.map_err(invalid)?))
    }

    fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let (settings, state) = kept(bytes)?;
        if settings != self.settings {
            return Err(PyValueError::new_err(
                "the snapshot is of an actuator with another model, seed or parameters",
            ));
        }
        py.detach(|| *self.state() = state);
        Ok(())
    }

    #[staticmethod]
    fn kept(bytes: &[u8]) -> PyResult<Self> {
        let (settings, state) = kept(bytes)?;
        Ok(Self::with(settings, state))
    }

    fn copy(&self, py: Python<'_>) -> Self {
        let state = py.detach(|| self.state().clone());
        Self {
            settings: self.settings,
            state: Mutex::new(state),
        }
    }
}
