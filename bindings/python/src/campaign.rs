//! Many runs on all cores.

use std::{ops::Range, sync::Arc};

use host_sim::{
    error::Error,
    scenario::Setting,
    simulate::{self, RunProgress, Simulation, extremes::Extremes},
};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray2};
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::prelude::*;

use crate::{
    exception::exception,
    request::{Plan, Request},
    watch::{self, Report},
};

/// Runs of each thread whose descriptions are in memory at a time.
const RUNS_PER_BLOCK: usize = 64;

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

    /// The extremes of these runs, on all cores.
    fn block(
        &self,
        runs: Range<usize>,
        progress: &Arc<RunProgress>,
    ) -> Result<Vec<[f64; 6]>, (usize, Error)> {
        let simulation = |index| {
            let simulation = self.simulation(index).map_err(|error| (index, error))?;
            Ok(Simulation {
                progress: Some(Arc::clone(progress)),
                ..simulation
            })
        };
        let simulations = runs.clone().into_par_iter().map(simulation);
        let simulations = simulations.collect::<Result<Vec<_>, _>>()?;
        let results = runs.zip(simulate::extremes::campaign(&simulations));
        let numbers = |(index, result): (usize, Result<Extremes, Error>)| match result {
            Ok(ends) => Ok(numbers(&ends)),
            Err(error) => Err((index, error)),
        };
        results.map(numbers).collect()
    }
}

/// Six numbers per run, run after run. Progress is reported in runs.
///
/// The threads are created for this call: a forked process would lack those of a global pool.
#[pyfunction]
pub fn monte_carlo<'py>(
    py: Python<'py>,
    request: Request<'py>,
    names: Vec<String>,
    values: PyReadonlyArray2<'py, f64>,
    threads: usize,
    report: Report<'py>,
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
    let progress = Arc::new(RunProgress::default());
    // Runs may differ in length by parameters of the input: that of the first is used for all.
    let first = (runs > 0).then(|| campaign.simulation(0));
    let first = first.transpose();
    let first = first.map_err(|error| exception(&error, "run 0: "))?;
    let ticks_per_run = first.map_or(1, |first| first.ticks);
    let done = || {
        let done = progress.ticks() / ticks_per_run;
        (done.min(runs as u64) as f64, runs as f64)
    };
    let of_job = Arc::clone(&progress);
    let job = move || {
        let mut all = Vec::with_capacity(6 * runs);
        let block = RUNS_PER_BLOCK * threads.current_num_threads();
        for first in (0..runs).step_by(block) {
            let runs = first..runs.min(first + block);
            let ends = threads.install(|| campaign.block(runs, &of_job))?;
            all.extend(ends.into_iter().flatten());
        }
        Ok(all)
    };
    let all = watch::run(py, &report, done, || progress.stop(), job)?;
    let all =
        all.map_err(|(index, error): (usize, Error)| exception(&error, &format!("run {index}: ")))?;
    Ok(all.into_pyarray(py))
}
