//! Many actuators that are stepped together, on all cores.

use std::sync::{Mutex, PoisonError};

use host_sim::{
    error::Error,
    scenario::Scenario,
    settings::Settings,
    simulate::batch::{Batch, BatchState, Refused},
};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{
    exception::{exception, raised},
    request::scenario,
};

/// Numbers of a state: angle, rate, measured angle, measured rate.
const COLUMNS: usize = 4;

/// Many actuators with the same model, some of whose parameters differ.
#[pyclass(frozen, module = "smart_actuator._native")]
pub struct ActuatorBatch {
    scenario: Scenario,
    /// Parameters that differ.
    names: Vec<String>,
    threads: ThreadPool,
    state: Mutex<State>,
}

struct State {
    batch: Batch,
    states: Vec<BatchState>,
}

impl ActuatorBatch {
    /// The settings of an actuator with these values of the parameters that differ.
    fn settings(&self, values: &[f64]) -> Result<Settings, Error> {
        let mut settings = self.scenario.settings()?;
        for (name, value) in self.names.iter().zip(values) {
            model_core::scenario::set(&mut settings, name, *value)?;
        }
        Ok(settings)
    }
}

fn refused(Refused { index, error }: Refused) -> PyErr {
    exception(&(*error).into(), &format!("actuator {index}: "))
}

#[pymethods]
impl ActuatorBatch {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "the Python module names them")]
    fn new(
        model: &str,
        plant: Option<&str>,
        preset: Option<String>,
        seed: u64,
        parameters: Vec<(String, f64)>,
        names: Vec<String>,
        values: PyReadonlyArray2<'_, f64>,
        ticks: u64,
        threads: usize,
    ) -> PyResult<Self> {
        let scenario =
            scenario(model, plant, preset, seed, "average", parameters).map_err(raised)?;
        let threads = ThreadPoolBuilder::new().num_threads(threads).build();
        let threads = threads.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let empty = Batch::try_new(&[], ticks).map_err(refused)?;
        let mut this = Self {
            scenario,
            names,
            threads,
            state: Mutex::new(State {
                batch: empty,
                states: Vec::new(),
            }),
        };
        let rows = values.as_array();
        let mut settings = Vec::with_capacity(rows.nrows());
        for (index, row) in rows.outer_iter().enumerate() {
            let one = this.settings(&row.to_vec());
            let mut one = one.map_err(|error| exception(&error, &format!("actuator {index}: ")))?;
            // Independent noise.
            one.seed = seed.wrapping_add(index as u64);
            settings.push(one);
        }
        let batch = this.threads.install(|| Batch::try_new(&settings, ticks));
        this.state = Mutex::new(State {
            batch: batch.map_err(refused)?,
            states: vec![BatchState::default(); settings.len()],
        });
        Ok(this)
    }

    /// Steps with a command each, deg, and writes the states, actuator after actuator, to `out`.
    fn step<'py>(
        &self,
        py: Python<'py>,
        commands: PyReadonlyArray1<'py, f64>,
        out: &Bound<'py, PyArray2<f64>>,
    ) -> PyResult<()> {
        let commands = commands.as_slice()?.to_vec();
        let mut out = out.try_readwrite()?;
        let rows = out.as_slice_mut()?;
        py.detach(|| {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            let State { batch, states } = &mut *state;
            self.threads.install(|| batch.step(&commands, states));
            for (row, state) in rows.chunks_exact_mut(COLUMNS).zip(states) {
                row.copy_from_slice(&[
                    state.angle_deg,
                    state.rate_deg_s,
                    state.angle_meas_deg,
                    state.rate_meas_deg_s,
                ]);
            }
        });
        Ok(())
    }

    /// Replaces actuators by index, in increasing order, with others at rest; a row of values each.
    fn replace(
        &self,
        py: Python<'_>,
        indices: Vec<usize>,
        values: PyReadonlyArray2<'_, f64>,
        seed: u64,
    ) -> PyResult<()> {
        let mut fresh = Vec::with_capacity(indices.len());
        for (index, row) in indices.into_iter().zip(values.as_array().outer_iter()) {
            let one = self.settings(&row.to_vec());
            let mut one = one.map_err(|error| exception(&error, &format!("actuator {index}: ")))?;
            one.seed = seed.wrapping_add(index as u64);
            fresh.push((index, one));
        }
        py.detach(|| {
            let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
            let batch = &mut state.batch;
            self.threads.install(|| batch.replace(&fresh))
        })
        .map_err(refused)
    }
}
