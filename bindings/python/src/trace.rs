//! A single run with all of its columns.

use host_sim::{
    error::Error,
    simulate::{Rows, Simulation},
};
use numpy::IntoPyArray;
use pyo3::{exceptions::PyMemoryError, prelude::*, types::PyDict};

use crate::{exception::raised, request::Request};

/// The most numbers in a trace: 4 GiB. A larger one is most likely a mistake in duration or
/// `every`, and would end the process instead of raising an exception.
const MOST_NUMBERS: u64 = 1 << 29;

/// Rows between two checks for an interrupt.
const ROWS_PER_CHECK: usize = 1 << 16;

/// The columns of a growing trace.
struct Columns {
    values: Vec<Vec<f64>>,
    /// The exception of an interrupt.
    interruption: Option<PyErr>,
}

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
        Ok(Self {
            values,
            interruption: None,
        })
    }
}

impl Rows for Columns {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        for (column, value) in self.values.iter_mut().zip(values) {
            column.push(*value);
        }
        let rows = self.values.first().map_or(0, Vec::len);
        if rows.is_multiple_of(ROWS_PER_CHECK)
            && let Err(interruption) = Python::attach(|py| py.check_signals())
        {
            self.interruption = Some(interruption);
            return Err(Error::Conflict("interrupted".into()));
        }
        Ok(())
    }
}

/// The title of a run and its columns by name.
#[pyfunction]
pub fn simulate<'py>(
    py: Python<'py>,
    request: Request<'py>,
) -> PyResult<(String, Bound<'py, PyDict>)> {
    let simulation = request.plan()?.simulation([].into_iter()).map_err(raised)?;
    let mut columns = Columns::room_for(&simulation)?;
    let result = py.detach(|| simulation.run(&mut columns));
    if let Some(interruption) = columns.interruption {
        return Err(interruption);
    }
    result.map_err(raised)?;
    let by_name = PyDict::new(py);
    for (name, values) in simulation.columns().into_iter().zip(columns.values) {
        by_name.set_item(name, values.into_pyarray(py))?;
    }
    Ok((simulation.title(), by_name))
}
