//! Models as actuators of other simulators.

use host_sim::error::Error;
use identification::export::{self as targets, TARGETS};
use pyo3::{exceptions::PyValueError, prelude::*, types::PyDict};

use crate::{exception::raised, request::Request};

#[pyfunction]
pub fn export<'py>(
    py: Python<'py>,
    to: &str,
    request: Request<'py>,
    step_s: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let target = targets::named(to).ok_or_else(|| {
        let names = TARGETS.map(|target| target.name()).join(", ");
        PyValueError::new_err(format!("to is '{to}', expected {names}"))
    })?;
    let described = request.plan()?.described().map_err(raised)?;
    let found = py
        .detach(|| targets::export(&described.settings, target, &described.input, step_s))
        .map_err(|error| raised(Error::Conflict(error.to_string())))?;
    let result = PyDict::new(py);
    result.set_item("text", found.text)?;
    result.set_item("validation", found.validation)?;
    result.set_item("error_deg", found.error_deg)?;
    result.set_item("spread_deg", found.spread_deg)?;
    result.set_item("lost", found.lost)?;
    Ok(result)
}
