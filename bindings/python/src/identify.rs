//! Identification, in a thread of its own so that an interrupt can end it.

use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use host_sim::error::Error;
use identification::{
    Experiment, Hold, IdentifyError, Model, Options, Progress, Recording,
    assessment::{NonparametricAnalysis, point_to_better},
    data::{Columns, Delimiter, Import, Note},
    document,
    loss::LossChoice,
    models,
    request::{Request, RequestError},
};
use numpy::PyReadonlyArray1;
use pyo3::{
    exceptions::{PyKeyError, PyOSError, PyRuntimeError, PyValueError},
    prelude::*,
};

/// A recording: a file, or columns by name.
#[derive(FromPyObject)]
pub enum Source<'py> {
    File(PathBuf),
    Arrays(BTreeMap<String, PyReadonlyArray1<'py, f64>>),
}

/// A dictionary with all of these keys: the options of the import.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Reading {
    columns: Vec<(String, String)>,
    delimiter: Option<String>,
    window: Option<(f64, f64)>,
    keep_clipped: bool,
    keep_bad: bool,
    hold: Option<String>,
    known: Vec<(String, f64)>,
}

/// A dictionary with all of these keys: the options of the search.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Search {
    models: Vec<String>,
    fix: Vec<(String, f64)>,
    free: Vec<String>,
    bound: Vec<(String, f64, f64)>,
    start: Vec<(String, f64)>,
    own: Vec<String>,
    share: Vec<String>,
    starts: usize,
    seed: u64,
    loss: String,
    threads: usize,
}

/// Time between two checks for an interrupt.
const CHECK_PERIOD: Duration = Duration::from_millis(50);

/// All results, as the JSON of `actuator identify --json`.
#[pyfunction]
pub fn identify(
    py: Python<'_>,
    data: Vec<Source<'_>>,
    validate: Vec<Source<'_>>,
    reading: Reading,
    search: Search,
) -> PyResult<String> {
    let job = Job::of(data, validate, reading, search)?;
    let (stop, caller) = (AtomicBool::new(false), std::thread::current());
    std::thread::scope(|scope| {
        let stop = &stop;
        let worker = scope.spawn(move || {
            let result = job.run(stop);
            caller.unpark();
            result
        });
        while !worker.is_finished() {
            py.detach(|| std::thread::park_timeout(CHECK_PERIOD));
            if let Err(interruption) = py.check_signals() {
                stop.store(true, Ordering::Relaxed);
                // Waits for the end of the worker, without the interpreter lock.
                let _ = py.detach(|| worker.join());
                return Err(interruption);
            }
        }
        let ended = worker.join();
        ended.map_err(|_| PyRuntimeError::new_err("the search ended unexpectedly"))
    })?
}

/// An identification, without Python types.
struct Job {
    data: Vec<Given>,
    validate: Vec<Given>,
    import: Import,
    models: Vec<Arc<dyn Model>>,
    request: Request,
    threads: usize,
}

/// A recording as given.
enum Given {
    File(PathBuf),
    Recording(Box<Recording>),
}

impl Job {
    fn of(
        data: Vec<Source<'_>>,
        validate: Vec<Source<'_>>,
        reading: Reading,
        search: Search,
    ) -> PyResult<Self> {
        let mut import = reading.import()?;
        let (models, threads) = (search.models().map_err(exception)?, search.threads);
        // A shaft that friction holds looks like a clipped sensor.
        import.keep_clipped |= models.iter().any(|model| model.has_friction());
        let request = search.request()?;
        request.check(&models).map_err(of_request)?;
        let given = |sources: Vec<Source<'_>>, what| {
            let numbered = sources.into_iter().enumerate();
            let one = |(index, source): (usize, Source<'_>)| match source {
                Source::File(path) => Ok(Given::File(path)),
                Source::Arrays(columns) => {
                    let name = format!("{what}[{index}]");
                    recording(name, &columns, &import).map(|r| Given::Recording(Box::new(r)))
                }
            };
            numbered.map(one).collect::<PyResult<Vec<_>>>()
        };
        Ok(Self {
            data: given(data, "data")?,
            validate: given(validate, "validate")?,
            import,
            models,
            request,
            threads,
        })
    }

    /// Reads the files, fits the models, and returns the document.
    fn run(self, stop: &AtomicBool) -> PyResult<String> {
        let mut notes = Vec::new();
        let mut ready = |given: Vec<Given>| -> PyResult<Vec<Experiment>> {
            let one = |given| self.import.experiment(given, &mut notes);
            given.into_iter().map(one).collect()
        };
        let (fitted, held_out) = (ready(self.data)?, ready(self.validate)?);
        // The threads are created for this call: a forked process would lack those of a global
        // pool.
        let threads = rayon::ThreadPoolBuilder::new().num_threads(self.threads);
        let threads = threads
            .build()
            .map_err(|error| PyRuntimeError::new_err(error.to_string()))?;
        let runs = (&fitted[..], &held_out[..]);
        let mut found = Vec::new();
        for model in self.models {
            let search = || self.request.assess(model, runs, &found, &Stop(stop));
            let assessed = threads.install(search).map_err(invalid)?;
            found.push(assessed);
        }
        point_to_better(&mut found);
        let nonparametric = NonparametricAnalysis::of(&fitted);
        Ok(document::text(&found, None, &nonparametric, &notes))
    }
}

/// Imports a given recording.
trait Ready {
    fn experiment(&self, given: Given, notes: &mut Vec<Note>) -> PyResult<Experiment>;
}

impl Ready for Import {
    fn experiment(&self, given: Given, notes: &mut Vec<Note>) -> PyResult<Experiment> {
        let (name, recording) = match given {
            Given::Recording(recording) => (recording.name.clone(), *recording),
            Given::File(path) => {
                let imported = self
                    .read(&path, &mut |_, _| {})
                    .map_err(|error| exception(error.into()))?;
                notes.extend(imported.notes);
                (path.display().to_string(), imported.recording)
            }
        };
        let unusable = |error| IdentifyError::Recording { name, error };
        Experiment::try_new(recording)
            .map_err(unusable)
            .map_err(invalid)
    }
}

/// Ends the search after an interrupt.
struct Stop<'a>(&'a AtomicBool);

impl Progress for Stop<'_> {
    fn is_stopped(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

impl Reading {
    fn import(self) -> PyResult<Import> {
        let choice = |(what, column): &(String, String)| {
            let parsed = format!("{what}={column}").parse();
            parsed.map_err(|error| PyValueError::new_err(format!("columns: {error}")))
        };
        Ok(Import {
            columns: Columns(self.columns.iter().map(choice).collect::<PyResult<_>>()?),
            delimiter: match self.delimiter.as_deref() {
                None => None,
                Some("comma") => Some(Delimiter::Character(b',')),
                Some("semicolon") => Some(Delimiter::Character(b';')),
                Some("tab") => Some(Delimiter::Character(b'\t')),
                Some("blanks") => Some(Delimiter::Blanks),
                Some(other) => {
                    return Err(PyValueError::new_err(format!(
                        "delimiter is `{other}`, expected comma, semicolon, tab or blanks"
                    )));
                }
            },
            window_s: self.window,
            keep_clipped: self.keep_clipped,
            keep_bad: self.keep_bad,
            hold: match self.hold.as_deref() {
                None => Hold::Auto,
                Some("zero") => Hold::Zero,
                Some("smooth") => Hold::Smooth,
                Some(other) => {
                    return Err(PyValueError::new_err(format!(
                        "hold is `{other}`, expected zero or smooth"
                    )));
                }
            },
            constants: self.known.into_iter().collect(),
        })
    }
}

impl Search {
    fn models(&self) -> Result<Vec<Arc<dyn Model>>, Error> {
        let known = models::all();
        let names = || known.iter().map(|model| model.name());
        let unknown = |name: &str| {
            let expected = names().collect::<Vec<_>>().join(", ");
            Error::unknown("model", name, names(), expected)
        };
        let one = |name: &String| models::named(name).ok_or_else(|| unknown(name));
        self.models.iter().map(one).collect()
    }

    fn request(self) -> PyResult<Request> {
        let loss = LossChoice::named(&self.loss).ok_or_else(|| {
            PyValueError::new_err(format!(
                "loss is `{}`, expected {}",
                self.loss,
                LossChoice::NAMES.join(", ")
            ))
        })?;
        Ok(Request {
            fix: self.fix,
            free: self.free,
            bound: self.bound,
            start: self.start,
            own: self.own,
            share: self.share,
            options: Options {
                starts: self.starts,
                seed: self.seed,
                loss,
                ..Options::default()
            },
        })
    }
}

/// The optional columns of a recording.
const OPTIONAL: [&str; 4] = ["rate_deg_s", "duty_pct", "current_ma", "supply_v"];
/// The required columns of a recording.
const REQUIRED: [&str; 3] = ["time_s", "command_deg", "angle_deg"];

fn recording(
    name: String,
    columns: &BTreeMap<String, PyReadonlyArray1<'_, f64>>,
    import: &Import,
) -> PyResult<Recording> {
    let is_known = |key: &str| REQUIRED.contains(&key) || OPTIONAL.contains(&key);
    if let Some(key) = columns.keys().find(|key| !is_known(key)) {
        let known = [&REQUIRED[..], &OPTIONAL[..]].concat().join(", ");
        return Err(PyKeyError::new_err(format!(
            "{name} has a column `{key}`, expected {known}"
        )));
    }
    let column = |key: &str| Some(columns.get(key)?.as_array().to_vec());
    let required = |key: &str| {
        let missing = || PyKeyError::new_err(format!("{name} has no column `{key}`"));
        column(key).ok_or_else(missing)
    };
    Ok(Recording {
        time_s: required("time_s")?,
        command_deg: required("command_deg")?,
        angle_deg: required("angle_deg")?,
        rate_deg_s: column("rate_deg_s"),
        duty_pct: column("duty_pct"),
        current_ma: column("current_ma"),
        supply_v: column("supply_v"),
        hold: import.hold,
        constants: import.constants.clone(),
        name,
        ..Recording::default()
    })
}

fn invalid(error: IdentifyError) -> PyErr {
    PyValueError::new_err(error.to_string())
}

fn of_request(error: RequestError) -> PyErr {
    match error {
        RequestError::UnknownParameter { name, known } => {
            let expected = known.join(", ");
            exception(Error::unknown("parameter", &name, known, expected))
        }
        RequestError::Conflict(problem) => PyValueError::new_err(problem),
    }
}

/// `KeyError` for a parameter that no model has, `OSError` for a file that cannot be read,
/// `ValueError` for everything else.
fn exception(error: Error) -> PyErr {
    match &error {
        Error::UnknownName {
            kind: "parameter", ..
        } => PyKeyError::new_err(error.to_string()),
        Error::Read { path, source } => match source.raw_os_error() {
            // The subclass of the number, such as FileNotFoundError.
            Some(number) => {
                PyOSError::new_err((number, source.to_string(), path.display().to_string()))
            }
            None => PyOSError::new_err(error.to_string()),
        },
        _ => PyValueError::new_err(error.to_string()),
    }
}
