//! Derivatives of a response by its parameters and by its command, by the dual numbers of the
//! identification.

use std::sync::{
    Arc,
    atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed},
};

use identification::{COMMANDS_PER_PASS, Experiment, Hold, Model, Recording, models};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1};
use pyo3::{
    exceptions::{PyKeyError, PyValueError},
    prelude::*,
};

use crate::watch::{self, Report};

/// The response, deg, and its derivatives by the parameters `by`, one after the other.
type Derived<'py> = (Bound<'py, PyArray1<f64>>, Vec<Bound<'py, PyArray1<f64>>>);

/// A model, its parameters in order, and the run that it simulates.
struct Prepared {
    model: Arc<dyn Model>,
    values: Vec<f64>,
    run: Experiment,
    /// The instants of the caller; some more may follow.
    rows: usize,
}

/// Least number of samples of a recording, which a response need not have.
const LEAST_SAMPLES: usize = 8;

/// Appends instants and repeats the last values up to [`LEAST_SAMPLES`].
fn fill(time_s: &mut Vec<f64>, columns: [Option<&mut Vec<f64>>; 2]) {
    if time_s.is_empty() {
        return;
    }
    while time_s.len() < LEAST_SAMPLES {
        // NaN and infinity are refused afterwards.
        time_s.push(time_s[time_s.len() - 1] + 1e-3);
    }
    for column in columns.into_iter().flatten() {
        if let Some(last) = column.last().copied() {
            column.resize(column.len().max(LEAST_SAMPLES), last);
        }
    }
}

fn index_of(model: &dyn Model, name: &str) -> PyResult<usize> {
    model.parameter_index(name).ok_or_else(|| {
        let names: Vec<_> = model.parameters().iter().map(|p| p.name).collect();
        PyKeyError::new_err(format!(
            "{} has no parameter `{name}`, expected one of {}",
            model.name(),
            names.join(", ")
        ))
    })
}

impl Prepared {
    /// Where `has_others`, `values` may contain parameters that the model does not have: those of
    /// the simulator.
    fn new(
        model: &str,
        mut time_s: Vec<f64>,
        mut command_deg: Vec<f64>,
        mut duty_pct: Option<Vec<f64>>,
        (values, has_others): (&[(String, f64)], bool),
    ) -> PyResult<Self> {
        let rows = time_s.len();
        if [Some(&command_deg), duty_pct.as_ref()]
            .into_iter()
            .flatten()
            .all(|c| c.len() == rows)
        {
            fill(&mut time_s, [Some(&mut command_deg), duty_pct.as_mut()]);
        }
        let model = models::named(model).ok_or_else(|| {
            let names: Vec<_> = models::all().iter().map(|model| model.name()).collect();
            PyValueError::new_err(format!(
                "`{model}` has no derivatives, expected one of {}",
                names.join(", ")
            ))
        })?;
        let mut all: Vec<f64> = model.parameters().iter().map(|p| p.default).collect();
        for (name, value) in values {
            let found = index_of(model.as_ref(), name);
            if !has_others && let Err(unknown) = found {
                return Err(unknown);
            }
            if let Ok(index) = found {
                let known = &model.parameters()[index];
                // What is unlimited in the simulator has a limit here that nothing reaches.
                let is_unlimited = known.is_limit && *value == f64::INFINITY;
                let value = if is_unlimited { known.max } else { *value };
                let checked = known.parameter.check(value);
                checked.map_err(|error| PyValueError::new_err(error.to_string()))?;
                all[index] = value;
            }
        }
        let recording = Recording {
            name: model.name().into(),
            // Nothing is compared, but an angle that never changes is refused.
            angle_deg: (0..time_s.len()).map(|i| i as f64).collect(),
            command_deg,
            duty_pct,
            time_s,
            hold: Hold::Zero,
            ..Recording::default()
        };
        let refused =
            |error: identification::RecordingError| PyValueError::new_err(error.to_string());
        model.accepts(&recording).map_err(refused)?;
        let run = Experiment::try_new(recording).map_err(refused)?;
        Ok(Self {
            model,
            values: all,
            run,
            rows,
        })
    }
}

/// The angle of a model at the instants of a command that is held between them, and its derivatives
/// by parameters.
#[pyfunction]
pub fn sensitivity<'py>(
    py: Python<'py>,
    model: &str,
    time_s: PyReadonlyArray1<'py, f64>,
    command_deg: PyReadonlyArray1<'py, f64>,
    duty_pct: Option<PyReadonlyArray1<'py, f64>>,
    values: (Vec<(String, f64)>, bool),
    by: Vec<String>,
) -> PyResult<Derived<'py>> {
    let owned = |array: PyReadonlyArray1<'py, f64>| array.as_array().to_vec();
    let duty_pct = duty_pct.map(owned);
    let values = (values.0.as_slice(), values.1);
    let prepared = Prepared::new(model, owned(time_s), owned(command_deg), duty_pct, values)?;
    let Prepared {
        model,
        values,
        run,
        rows,
    } = &prepared;
    let free = by.iter().map(|name| index_of(model.as_ref(), name));
    let free = free.collect::<PyResult<Vec<_>>>()?;
    let (angles, slopes) = py.detach(|| {
        let mut angles = vec![f64::NAN; run.len()];
        let mut slopes = vec![vec![f64::NAN; run.len()]; free.len()];
        model.sensitivity(run, values, &free, &mut |i, angle_deg, slope| {
            angles[i] = angle_deg;
            for (column, slope) in slopes.iter_mut().zip(slope) {
                column[i] = *slope;
            }
        });
        for column in slopes.iter_mut().chain([&mut angles]) {
            column.truncate(*rows);
        }
        (angles, slopes)
    });
    let slopes = slopes.into_iter().map(|column| column.into_pyarray(py));
    Ok((angles.into_pyarray(py), slopes.collect()))
}

/// The derivatives of the angle at each instant, by rows, by the commands that begin at the
/// instants `starts`, of which the first is 0. `report(done, total)` is called with numbers of
/// commands; its exception or an interrupt ends the call.
#[pyfunction]
pub fn command_sensitivity<'py>(
    py: Python<'py>,
    model: &str,
    time_s: PyReadonlyArray1<'py, f64>,
    command_deg: PyReadonlyArray1<'py, f64>,
    starts: Vec<usize>,
    values: (Vec<(String, f64)>, bool),
    report: Report<'py>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let owned = |array: PyReadonlyArray1<'py, f64>| array.as_array().to_vec();
    let values = (values.0.as_slice(), values.1);
    let mut prepared = Prepared::new(model, owned(time_s), owned(command_deg), None, values)?;
    prepared.run = prepared.run.with_segments_at(&starts);
    let (rows, width) = (prepared.rows, prepared.run.command.len());
    let (is_stopped, done) = (
        Arc::new(AtomicBool::new(false)),
        Arc::new(AtomicUsize::new(0)),
    );
    let job = {
        let (is_stopped, done) = (is_stopped.clone(), done.clone());
        move || {
            let Prepared {
                model, values, run, ..
            } = prepared;
            let mut slopes = vec![0.0; rows * width];
            for first in (0..width).step_by(COMMANDS_PER_PASS) {
                if is_stopped.load(Relaxed) {
                    break;
                }
                model.command_sensitivity(&run, &values, first..width, &mut |i, _, slope| {
                    let place = i * width + first;
                    if let Some(row) = slopes.get_mut(place..place + slope.len()) {
                        row.copy_from_slice(slope);
                    }
                });
                done.store(width.min(first + COMMANDS_PER_PASS), Relaxed);
            }
            slopes
        }
    };
    let progress = || (done.load(Relaxed) as f64, width as f64);
    let stop = || is_stopped.store(true, Relaxed);
    let slopes = watch::run(py, &report, progress, stop, job)?;
    slopes.into_pyarray(py).reshape([rows, width])
}
