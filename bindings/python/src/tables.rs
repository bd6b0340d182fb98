//! Tables of the parameters, presets and inputs, as lists of dictionaries.

use model_core::{excitation::catalogue::Input, parameter::Parameter, presets::PRESETS};
use pyo3::{
    prelude::*,
    types::{PyDict, PyList},
};

use crate::{exception::raised, request::scenario};

fn row<'py>(py: Python<'py>, parameter: &Parameter) -> PyResult<Bound<'py, PyDict>> {
    let (row, p) = (PyDict::new(py), parameter);
    for (key, text) in [("name", p.name), ("symbol", p.symbol), ("unit", p.unit)] {
        row.set_item(key, text)?;
    }
    for (key, value) in [("min", p.min), ("max", p.max), ("default", p.default)] {
        row.set_item(key, value)?;
    }
    for (key, text) in [("source", p.source), ("meaning", p.meaning)] {
        row.set_item(key, text)?;
    }
    Ok(row)
}

fn rows<'py, 'a>(
    py: Python<'py>,
    parameters: impl IntoIterator<Item = &'a Parameter>,
) -> PyResult<Bound<'py, PyList>> {
    let rows = PyList::empty(py);
    for parameter in parameters {
        rows.append(row(py, parameter)?)?;
    }
    Ok(rows)
}

#[pyfunction]
pub fn parameters<'py>(
    py: Python<'py>,
    model: &str,
    plant: Option<&str>,
) -> PyResult<Bound<'py, PyList>> {
    let scenario = scenario(model, plant, None, 0, "average", Vec::new());
    let settings = scenario.and_then(|s| s.settings()).map_err(raised)?;
    rows(py, settings.values().map(|value| value.parameter))
}

#[pyfunction]
pub fn presets(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let all = PyList::empty(py);
    for preset in PRESETS {
        let (row, values) = (PyDict::new(py), PyDict::new(py));
        for (name, value) in preset.values {
            values.set_item(name, value)?;
        }
        row.set_item("name", preset.name)?;
        row.set_item("summary", preset.summary)?;
        row.set_item("warning", preset.warning)?;
        row.set_item("models", preset.models)?;
        row.set_item("values", values)?;
        all.append(row)?;
    }
    Ok(all)
}

#[pyfunction]
pub fn inputs(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let all = PyList::empty(py);
    for input in Input::NAMES.iter().filter_map(|name| Input::named(name)) {
        let row = PyDict::new(py);
        row.set_item("name", input.name())?;
        row.set_item("summary", input.summary())?;
        row.set_item("parameters", rows(py, input.table())?)?;
        all.append(row)?;
    }
    Ok(all)
}
