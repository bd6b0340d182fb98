//! A single run with all of its columns.

use std::sync::Arc;

use host_sim::{
    error::Error,
    simulate::{Rows, RunProgress, Simulation},
};
use model_core::time::seconds;
use numpy::IntoPyArray;
use pyo3::{exceptions::PyMemoryError, prelude::*, types::PyDict};

use crate::{
    exception::raised,
    request::Request,
    watch::{self, Report},
};

/// The most numbers in a trace: 4 GiB. A larger one is most likely a mistake in duration or
/// `every`, and would end the process instead of raising an exception.
const MOST_NUMBERS: u64 = 1 << 29;

/// The columns of a growing trace.
struct Columns(Vec<Vec<f64>>);

impl Columns {
    fn room_for(simulation: &Simulation) -> PyResult<Self> {
        let (rows, columns) = (simulation.rows(), simulation.columns().len());
        let too_long = || {
            PyMemoryError::new_err(format!(
                "a trace of {rows} rows and {columns} columns, expected {MOST_NUMBERS} numbers at \
                 most: shorten the duration or raise `every`"
            ))
        };
        if rows.saturating_mul(columns as u64) > MOST_NUMBERS {
            return Err(too_long());
        }
        let mut values = vec![Vec::new(); columns];
        for column in &mut values {
            let room = column.try_reserve_exact(rows as usize);
            room.map_err(|_| too_long())?;
        }
        Ok(Self(values))
    }
}

impl Rows for Columns {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        for (column, value) in self.0.iter_mut().zip(values) {
            column.push(*value);
        }
        Ok(())
    }
}

/// The title of a run and its columns by name. Progress is reported in simulated seconds.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    request: Request<'py>,
    report: Report<'py>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let mut simulation = request.plan()?.simulation([].into_iter()).map_err(raised)?;
    let progress = Arc::new(RunProgress::default());
    simulation.progress = Some(Arc::clone(&progress));
    let mut columns = Columns::room_for(&simulation)?;
    let (title, names, ticks) = (simulation.title(), simulation.columns(), simulation.ticks);
    let job = move || simulation.run(&mut columns).map(|()| columns);
    let done = || (seconds(progress.ticks()), seconds(ticks));
    let columns = watch::run(py, &report, done, || progress.stop(), job)?;
    let by_name = PyDict::new(py);
    for (name, values) in names.into_iter().zip(columns.map_err(raised)?.0) {
        by_name.set_item(name, values.into_pyarray(py))?;
    }
    Ok((title, by_name))
}
