//! Identification.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

use crate::watch::{self, Report};
use host_sim::error::Error;
use identification::{
    Experiment, Hold, IdentifyError, Model, Options, Progress,
    assessment::{NonparametricAnalysis, point_to_better},
    data::{Columns, Delimiter, Import, Note, Quantity, Table},
    document,
    loss::LossChoice,
    models,
    request::{Request, RequestError, check_files, known_constants, may_lack_command},
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

/// A tuple: a recording, the window of it that is used, s, and the known constants of its run.
#[derive(FromPyObject)]
pub struct Run<'py>(Source<'py>, Option<(f64, f64)>, Vec<(String, f64)>);

/// A dictionary with all of these keys: the options of the import that all recordings share.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Reading {
    columns: Vec<(String, String)>,
    joint: Option<String>,
    rate_hz: Option<f64>,
    delimiter: Option<String>,
    keep_clipped: bool,
    keep_bad: bool,
    hold: Option<String>,
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

/// All results, as the JSON of `actuator identify --json`. Progress is reported in models.
#[pyfunction]
pub fn identify<'py>(
    py: Python<'py>,
    data: Vec<Run<'py>>,
    validate: Vec<Run<'py>>,
    reading: Reading,
    search: Search,
    report: Report<'py>,
) -> PyResult<String> {
    let job = Job::of(data, validate, reading, search)?;
    let models = job.models.len() as f64;
    let progress = Arc::new(SearchProgress::default());
    let of_job = Arc::clone(&progress);
    watch::run(
        py,
        &report,
        || (progress.models(), models),
        || progress.stop(),
        move || job.run(&of_job),
    )?
}

/// An identification, without Python types.
struct Job {
    data: Vec<Given>,
    validate: Vec<Given>,
    models: Vec<Arc<dyn Model>>,
    request: Request,
    threads: usize,
}

/// A recording as given, and the options of its import.
struct Given {
    content: Content,
    import: Import,
}

enum Content {
    File(PathBuf),
    Table(Box<Table>),
}

impl Given {
    /// The recording of this name, with the options that all recordings share.
    fn of(
        name: &str,
        Run(source, window_s, known): Run<'_>,
        models: &[Arc<dyn Model>],
        shared: &Import,
    ) -> PyResult<Self> {
        let constants = known_constants(models, &known).map_err(|error| match error {
            RequestError::Conflict(problem) => RequestError::Conflict(format!("{name}: {problem}")),
            unknown => unknown,
        });
        let import = Import {
            window_s,
            constants: constants.map_err(of_request)?,
            ..shared.clone()
        };
        let content = match source {
            Source::File(path) => Content::File(path),
            Source::Arrays(columns) => Content::Table(Box::new(table(name, &columns, &import)?)),
        };
        Ok(Self { content, import })
    }

    fn file(&self) -> Option<&Path> {
        match &self.content {
            Content::File(path) => Some(path),
            Content::Table(_) => None,
        }
    }

    /// Imports the recordings.
    fn experiments(self, notes: &mut Vec<Note>) -> PyResult<Vec<Experiment>> {
        let (path, imported) = match self.content {
            Content::Table(table) => {
                let imported = self.import.recording(&table).map(|one| vec![one]);
                (table.path, imported)
            }
            Content::File(path) => {
                let imported = self.import.read_all(&path, &mut |_, _| {});
                (path, imported)
            }
        };
        let mut experiments = Vec::new();
        for imported in imported.map_err(|error| exception(error.into()))? {
            notes.extend(imported.notes);
            let name = path.display().to_string();
            let unusable = |error| invalid(IdentifyError::Recording { name, error });
            experiments.push(Experiment::try_new(imported.recording).map_err(unusable)?);
        }
        Ok(experiments)
    }
}

impl Job {
    fn of(
        data: Vec<Run<'_>>,
        validate: Vec<Run<'_>>,
        reading: Reading,
        search: Search,
    ) -> PyResult<Self> {
        let (models, threads) = (search.models().map_err(exception)?, search.threads);
        let mut shared = reading.import(&models)?;
        // A shaft that friction holds looks like a clipped sensor.
        shared.keep_clipped |= models.iter().any(|model| model.has_friction());
        let request = search.request()?;
        request.check(&models).map_err(of_request)?;
        let given = |runs: Vec<Run<'_>>, what| {
            let one = |(index, run)| Given::of(&format!("{what}[{index}]"), run, &models, &shared);
            let numbered = runs.into_iter().enumerate();
            numbered.map(one).collect::<PyResult<Vec<_>>>()
        };
        let (data, validate) = (given(data, "data")?, given(validate, "validate")?);
        let [fitted, held_out] = [&data, &validate].map(|given| given.iter());
        let (fitted, held_out) = (
            fitted.filter_map(Given::file),
            held_out.filter_map(Given::file),
        );
        check_files(fitted, held_out).map_err(of_request)?;
        Ok(Self {
            data,
            validate,
            models,
            request,
            threads,
        })
    }

    /// Reads the files, fits the models, and returns the document.
    fn run(self, progress: &SearchProgress) -> PyResult<String> {
        let mut notes = Vec::new();
        let mut ready = |given: Vec<Given>| -> PyResult<Vec<Experiment>> {
            let each = given.into_iter().map(|given| given.experiments(&mut notes));
            Ok(each.collect::<PyResult<Vec<_>>>()?.concat())
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
            let search = || self.request.assess(model, runs, &found, progress);
            let assessed = threads.install(search).map_err(invalid)?;
            found.push(assessed);
            progress.next_model();
        }
        point_to_better(&mut found);
        let nonparametric = NonparametricAnalysis::of(&fitted);
        Ok(document::text(&found, None, &nonparametric, &notes))
    }
}

/// Counts the models and starts of a search, and ends it.
#[derive(Default)]
struct SearchProgress {
    is_stopped: AtomicBool,
    /// Models that are fitted.
    models: AtomicUsize,
    /// Share of the starts of the present model, thousandths.
    starts: AtomicUsize,
}

impl SearchProgress {
    fn models(&self) -> f64 {
        let starts = self.starts.load(Ordering::Relaxed) as f64 / 1000.0;
        self.models.load(Ordering::Relaxed) as f64 + starts
    }

    fn next_model(&self) {
        self.starts.store(0, Ordering::Relaxed);
        self.models.fetch_add(1, Ordering::Relaxed);
    }

    fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }
}

impl Progress for SearchProgress {
    fn done(&self, done: usize, of: usize, _: f64) {
        // A model counts as fitted only with its assessment.
        let share = (1000 * done / of.max(1)).min(999);
        self.starts.store(share, Ordering::Relaxed);
    }

    fn is_stopped(&self) -> bool {
        self.is_stopped.load(Ordering::Relaxed)
    }
}

impl Reading {
    fn import(self, models: &[Arc<dyn Model>]) -> PyResult<Import> {
        let choice = |(what, column): &(String, String)| {
            let parsed = format!("{what}={column}").parse();
            parsed.map_err(|error| PyValueError::new_err(format!("columns: {error}")))
        };
        Ok(Import {
            columns: Columns {
                selected: self.columns.iter().map(choice).collect::<PyResult<_>>()?,
                joint: self.joint,
            },
            rate_hz: self.rate_hz,
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
            may_lack_command: may_lack_command(models),
            ..Import::default()
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

/// The required quantities, with the names of their columns in a trace.
const REQUIRED: [(Quantity, &str); 3] = [
    (Quantity::Time, "time_s"),
    (Quantity::Command, "command_deg"),
    (Quantity::Angle, "angle_deg"),
];

/// The columns of a recording as a table, whose lines are the rows counted from 1.
fn table(
    name: &str,
    columns: &BTreeMap<String, PyReadonlyArray1<'_, f64>>,
    import: &Import,
) -> PyResult<Table> {
    let mut table = Table {
        path: name.into(),
        ..Table::default()
    };
    for (column, values) in columns {
        table.names.push(column.clone());
        table.columns.push(values.as_array().to_vec());
    }
    let chosen = &import.columns.selected;
    let is_chosen = |quantity| chosen.iter().any(|column| column.quantity == quantity);
    let may_lack = |quantity| match quantity {
        Quantity::Time => import.rate_hz.is_some(),
        Quantity::Command => import.may_lack_command,
        _ => false,
    };
    for (quantity, usual) in REQUIRED {
        let is_named = import.columns.joint.is_some();
        if !may_lack(quantity)
            && !is_chosen(quantity)
            && !is_named
            && quantity.find(&table.names) == Ok(None)
        {
            let (what, names) = (quantity.name(), table.names.join(", "));
            return Err(PyKeyError::new_err(format!(
                "{name} has no column of the {what}: the columns are {names}, expected `{usual}` or \
                 columns={{\"{what}\": \"COLUMN:UNIT\"}}"
            )));
        }
    }
    let rows = table.columns.first().map_or(0, Vec::len);
    let uneven = |values: &&Vec<f64>| values.len() != rows;
    if let Some(index) = table.columns.iter().position(|values| uneven(&values)) {
        let (first, other) = (&table.names[0], &table.names[index]);
        return Err(PyValueError::new_err(format!(
            "{name}: {other} has {} samples, expected {rows} as {first} has",
            table.columns[index].len()
        )));
    }
    table.lines = (1..=rows as u64).collect();
    Ok(table)
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
        _ => PyValueError::new_err(of_package(&error.to_string())),
    }
}

/// A message of the program as one of the package, which nobody builds with other features.
fn of_package(message: &str) -> String {
    match message.split_once(", which this program was built without") {
        Some((what, _)) => format!(
            "{what}, which this package does not read, expected a data frame or arrays by name: \
             identify(pandas.read_parquet(...)) or identify({{\"time_s\": ..., ...}})"
        ),
        None => message.into(),
    }
}
