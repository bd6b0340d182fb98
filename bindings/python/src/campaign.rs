//! Many runs on all cores.

use host_sim::{
    error::Error,
    scenario::Setting,
    simulate::{self, Simulation, extremes::Extremes},
};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::prelude::*;

use crate::{
    exception::exception,
    request::{Plan, Request},
};

/// Runs of each thread between two checks for an interrupt.
const RUNS_PER_CHECK: usize = 64;

fn numbers(ends: &Extremes) -> [f64; 6] {
    [
        ends.least_angle_deg,
        ends.greatest_angle_deg,
        ends.least_rate_deg_s,
        ends.greatest_rate_deg_s,
        ends.last.angle_deg,
        ends.last.rate_deg_s,
    ]
}

/// A plan, with values for some of its parameters for each run.
struct Campaign {
    plan: Plan,
    names: Vec<String>,
    /// Run after run, one value per name.
    values: Vec<f64>,
}

impl Campaign {
    fn simulation(&self, index: usize) -> Result<Simulation, Error> {
        let width = self.names.len();
        let values = &self.values[index * width..][..width];
        let more = self.names.iter().zip(values);
        let more = more.map(|(name, value)| Setting::new(name.as_str(), *value));
        self.plan.simulation(more)
    }
}

/// Six numbers per run, run after run.
///
/// The threads are created for this call: a forked process would lack those of a global pool.
#[pyfunction]
pub fn monte_carlo<'py>(
    py: Python<'py>,
    request: Request<'py>,
    names: Vec<String>,
    values: PyReadonlyArray2<'py, f64>,
    threads: usize,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (runs, plan) = (values.as_array().nrows(), request.plan()?);
    // A copy: other threads may write to the array while the interpreter lock is released.
    let values = values.as_array().iter().copied().collect();
    let campaign = Campaign {
        plan,
        names,
        values,
    };
    let threads = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let threads = threads.map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
    let mut all = Vec::with_capacity(6 * runs);
    let mut first = 0;
    while first < runs {
        let end = runs.min(first + RUNS_PER_CHECK * threads.current_num_threads());
        let simulation = |index| {
            let simulation = campaign.simulation(index);
            simulation.map_err(|error| (index, error))
        };
        let run = || -> Result<Vec<_>, _> {
            let simulations: Vec<_> = (first..end)
                .into_par_iter()
                .map(simulation)
                .collect::<Result<_, _>>()?;
            let results = (first..end).zip(simulate::extremes::campaign(&simulations));
            let numbers = |(index, result): (usize, Result<Extremes, Error>)| {
                result
                    .map(|ends| numbers(&ends))
                    .map_err(|error| (index, error))
            };
            results.map(numbers).collect()
        };
        let done = py.detach(|| threads.install(run));
        let done = done.map_err(|(index, error)| exception(&error, &format!("run {index}: ")))?;
        all.extend(done.into_iter().flatten());
        py.check_signals()?;
        first = end;
    }
    Ok(all.into_pyarray(py))
}
