//! An actuator that is stepped by its caller.

use std::sync::{Mutex, MutexGuard, PoisonError};

use host_sim::settings::{ModelKind, PlantKind, Pwm, Settings};
use model_core::{actuator, named::Named};
use pyo3::{
    exceptions::PyValueError,
    prelude::*,
    types::{PyBytes, PyDict},
};

use crate::{exception::raised, request::scenario};

/// Ticks between two checks for an interrupt: 100 s.
const TICKS_PER_CHECK: u64 = 2_000_000;

/// The outputs of an actuator, in the order of `smart_actuator.Reading`.
type Reading = (f64, f64, f64, f64, f64, f64, f64, f64, f64);

/// The origin of an actuator: version, model, plant, bridge, seed and parameters.
type Origin = (String, ModelKind, PlantKind, Pwm, u64, Vec<f64>);

/// The state, with a delay line of the length of the delay.
type State = actuator::Actuator<Vec<f64>>;

/// An actuator that is stepped by its caller. A lock serialises threads.
#[pyclass(frozen, module = "smart_actuator._native")]
pub struct Actuator {
    settings: Settings,
    state: Mutex<Box<State>>,
}

impl Actuator {
    fn with(settings: Settings, state: State) -> Self {
        Self {
            settings,
            state: Mutex::new(Box::new(state)),
        }
    }

    /// Call it without the interpreter lock, which could otherwise cause a deadlock.
    fn state(&self) -> MutexGuard<'_, Box<State>> {
        // A step does not panic, and no state is invalid: a poisoned lock can be used.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
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
fn kept(bytes: &[u8]) -> PyResult<(Settings, State)> {
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
        Ok(Self::with(
            settings,
            state.map_err(|error| raised(error.into()))?,
        ))
    }

    fn advance(&self, py: Python<'_>, command_deg: f64, ticks: u64) -> PyResult<Reading> {
        let mut left = ticks;
        loop {
            let now = left.min(TICKS_PER_CHECK);
            let result = py.detach(|| {
                let mut state = self.state();
                state.advance(command_deg, now).map(|()| reading(&state))
            });
            let refused = || format!("command_deg is {command_deg}, expected a finite angle, deg");
            let reading = result.map_err(|_| PyValueError::new_err(refused()))?;
            left -= now;
            if left == 0 {
                return Ok(reading);
            }
            py.check_signals()?;
        }
    }

    fn reading(&self, py: Python<'_>) -> Reading {
        py.detach(|| reading(&self.state()))
    }

    fn set_load_torque(&self, py: Python<'_>, torque_nm: f64) -> PyResult<()> {
        if (self.settings.model, self.settings.plant) != (ModelKind::Board, PlantKind::Drivetrain) {
            return Err(PyValueError::new_err(
                "a load torque applies to plant=\"bench\", no other has a load",
            ));
        }
        let result = py.detach(|| self.state().set_load_torque_nm(torque_nm));
        let refused = || format!("torque_nm is {torque_nm}, expected a finite torque, Nm");
        result.map_err(|_| PyValueError::new_err(refused()))
    }

    #[getter]
    fn tick(&self, py: Python<'_>) -> u64 {
        py.detach(|| self.state().tick())
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
        let bytes = py.detach(|| postcard::to_stdvec(&(self.origin(), &**self.state())));
        Ok(PyBytes::new(py, &bytes.map_err(invalid)?))
    }

    fn restore(&self, py: Python<'_>, bytes: &[u8]) -> PyResult<()> {
        let (settings, state) = kept(bytes)?;
        if settings != self.settings {
            return Err(PyValueError::new_err(
                "the snapshot is of an actuator with another model, seed or parameters",
            ));
        }
        py.detach(|| **self.state() = state);
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
