//! Derivatives of a response by its parameters, by the dual numbers of the identification.

use identification::{Experiment, Hold, Recording, models};
use numpy::{IntoPyArray, PyArray1, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyKeyError, PyValueError},
    prelude::*,
};

/// The response, deg, and its derivatives by the parameters `by`, one after the other.
type Derived<'py> = (Bound<'py, PyArray1<f64>>, Vec<Bound<'py, PyArray1<f64>>>);

/// The angle of a model at the instants of a command that is held between them.
///
/// `values` may contain parameters that the model does not have: those of the simulator.
#[pyfunction]
pub fn sensitivity<'py>(
    py: Python<'py>,
    model: &str,
    time_s: PyReadonlyArray1<'py, f64>,
    command_deg: PyReadonlyArray1<'py, f64>,
    duty_pct: Option<PyReadonlyArray1<'py, f64>>,
    values: Vec<(String, f64)>,
    by: Vec<String>,
) -> PyResult<Derived<'py>> {
    let found = models::named(model).ok_or_else(|| {
        let names: Vec<_> = models::all().iter().map(|model| model.name()).collect();
        PyValueError::new_err(format!(
            "`{model}` has no derivatives, expected one of {}",
            names.join(", ")
        ))
    })?;
    let index = |name: &str| {
        found.parameter_index(name).ok_or_else(|| {
            let names: Vec<_> = found.parameters().iter().map(|p| p.name).collect();
            PyKeyError::new_err(format!(
                "{model} has no parameter `{name}`, expected one of {}",
                names.join(", ")
            ))
        })
    };
    let free = by.iter().map(|name| index(name));
    let free = free.collect::<PyResult<Vec<_>>>()?;
    let mut all: Vec<f64> = found.parameters().iter().map(|p| p.default).collect();
    for (name, value) in &values {
        if let Ok(index) = index(name) {
            let known = &found.parameters()[index];
            // What is unlimited in the simulator has a limit here that nothing reaches.
            let is_unlimited = known.is_limit && *value == f64::INFINITY;
            let value = if is_unlimited { known.max } else { *value };
            let checked = known.parameter.check(value);
            checked.map_err(|error| PyValueError::new_err(error.to_string()))?;
            all[index] = value;
        }
    }
    let time_s = time_s.as_array().to_vec();
    let recording = Recording {
        name: model.into(),
        // Nothing is compared, but an angle that never changes is refused.
        angle_deg: (0..time_s.len()).map(|i| i as f64).collect(),
        command_deg: command_deg.as_array().to_vec(),
        duty_pct: duty_pct.map(|duty| duty.as_array().to_vec()),
        time_s,
        hold: Hold::Zero,
        ..Recording::default()
    };
    let refused = |error: identification::RecordingError| PyValueError::new_err(error.to_string());
    found.accepts(&recording).map_err(refused)?;
    let run = Experiment::try_new(recording).map_err(refused)?;
    let (angles, slopes) = py.detach(|| {
        let mut angles = vec![f64::NAN; run.len()];
        let mut slopes = vec![vec![f64::NAN; run.len()]; free.len()];
        found.sensitivity(&run, &all, &free, &mut |i, angle_deg, slope| {
            angles[i] = angle_deg;
            for (column, slope) in slopes.iter_mut().zip(slope) {
                column[i] = *slope;
            }
        });
        (angles, slopes)
    });
    let slopes = slopes.into_iter().map(|column| column.into_pyarray(py));
    Ok((angles.into_pyarray(py), slopes.collect()))
}
