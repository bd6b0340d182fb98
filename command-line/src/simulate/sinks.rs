//! Sinks for the rows of a run: files, plots and standard output.

use std::{
    io::{self, BufWriter, StdoutLock, Write},
    path::{Path, PathBuf},
};

use indicatif::ProgressBar;

use crate::output;
use host_sim::{
    error::Error,
    file::{self, WriteError},
    plot,
    scenario::Scenario,
    simulate::{Rows, Simulation},
    table::{Cell, Table},
    trace::Trace,
    trace_file::{Description, Format, TraceFile, csv::Csv},
};

/// Maximum number of rows of a plot, which takes about 0.4 GB.
const MOST_PLOTTED: u64 = 2_000_000;

/// The outputs that the options select.
pub struct Outputs {
    /// CSV, regardless of the name; without it a summary is printed.
    pub csv: Option<PathBuf>,
    /// Trace files, in the format of their suffix.
    pub files: Vec<PathBuf>,
    /// A plot.
    pub plot: Option<PathBuf>,
}

/// All sinks of a run.
pub struct Sinks {
    sinks: Vec<Box<dyn Sink>>,
    progress: ProgressBar,
}

/// A sink for the rows of a run.
trait Sink: Rows {
    /// Completes the output.
    fn finish(self: Box<Self>) -> Result<(), crate::Error>;
}

impl Sinks {
    /// Opens the sinks for this run, which has `read` these files.
    pub fn create(
        scenario: &Scenario,
        simulation: &Simulation,
        outputs: Outputs,
        read: &[&PathBuf],
    ) -> Result<Self, Error> {
        outputs.check(read)?;
        let description = Description::of(scenario, simulation)?;
        let file = |path: &Path, format, announced_path| {
            let file = TraceFile::create(path, format, simulation, &description)?;
            Ok::<Box<dyn Sink>, Error>(Box::new(FileSink {
                file,
                announced_path,
            }))
        };
        let mut sinks = Vec::new();
        for path in outputs.files {
            sinks.push(file(&path, Format::of(&path)?, Some(path.clone()))?);
        }
        if let Some(path) = outputs.plot {
            sinks.push(Box::new(PlotSink::create(simulation, path)?));
        }
        // Created last, so that no header is written if another sink fails.
        let table: Box<dyn Sink> = match &outputs.csv {
            None => Box::new(Summary::new(&simulation.columns())),
            Some(path) if output::is_standard_output(path) => {
                Box::new(StandardOutput::create(simulation)?)
            }
            Some(path) => file(path, Format::Csv, None)?,
        };
        sinks.insert(0, table);
        Ok(Self {
            sinks,
            progress: output::progress(simulation.rows(), "rows"),
        })
    }

    /// Completes the output.
    pub fn finish(self) -> Result<(), crate::Error> {
        self.progress.finish_and_clear();
        self.sinks.into_iter().try_for_each(Sink::finish)
    }
}

impl Rows for Sinks {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        for sink in &mut self.sinks {
            sink.row(values)?;
        }
        self.progress.inc(1);
        Ok(())
    }
}

impl Outputs {
    /// Checks in advance that each name has a known suffix, occurs once, and is not that of a file
    /// that is read.
    fn check(&self, read: &[&PathBuf]) -> Result<(), Error> {
        for path in &self.files {
            Format::of(path)?;
        }
        if let Some(path) = &self.plot {
            plot::Format::of(path)?;
        }
        let csv = self
            .csv
            .iter()
            .filter(|path| !output::is_standard_output(path));
        let csv = csv.map(|path| ("--csv", path.as_path()));
        let files = self.files.iter().map(|path| ("--out", path.as_path()));
        let plot = self.plot.iter().map(|path| ("--plot", path.as_path()));
        let all: Vec<_> = csv.chain(files).chain(plot).collect();
        Ok(file::check(&all, read.iter().copied())?)
    }
}

/// CSV on standard output.
struct StandardOutput(Csv<BufWriter<StdoutLock<'static>>>);

impl StandardOutput {
    fn create(simulation: &Simulation) -> Result<Self, Error> {
        let out = BufWriter::new(io::stdout().lock());
        Csv::create(out, &simulation.columns())
            .map(Self)
            .map_err(Self::failed)
    }

    fn failed(source: io::Error) -> Error {
        WriteError::new(Path::new("-"), source).into()
    }
}

impl Rows for StandardOutput {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.0.row(values).map_err(Self::failed)
    }
}

impl Sink for StandardOutput {
    fn finish(self: Box<Self>) -> Result<(), crate::Error> {
        Ok(self.0.finish().flush().map_err(Self::failed)?)
    }
}

/// A file. If `announced_path` is set, the name is printed to standard error on completion.
struct FileSink {
    file: TraceFile,
    announced_path: Option<PathBuf>,
}

impl Rows for FileSink {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.file.row(values)
    }
}

impl Sink for FileSink {
    fn finish(self: Box<Self>) -> Result<(), crate::Error> {
        self.file.finish()?;
        if let Some(path) = self.announced_path {
            note!("trace: {}", path.display());
        }
        Ok(())
    }
}

struct PlotSink {
    path: PathBuf,
    title: String,
    trace: Trace,
}

impl PlotSink {
    fn create(simulation: &Simulation, path: PathBuf) -> Result<Self, Error> {
        let rows = simulation.rows();
        if rows > MOST_PLOTTED {
            return Err(Error::Conflict(format!(
                "the plot would have {rows} rows, expected at most {MOST_PLOTTED}: a greater \
                 --every or a smaller --duration"
            )));
        }
        Ok(Self {
            path,
            title: simulation.title(),
            trace: Trace::new(&simulation.columns(), rows as usize),
        })
    }
}

impl Rows for PlotSink {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.trace.row(values)
    }
}

impl Sink for PlotSink {
    fn finish(self: Box<Self>) -> Result<(), crate::Error> {
        plot::save(&plot::of_trace(&self.title, &self.trace), &self.path)?;
        note!("plot: {}", self.path.display());
        Ok(())
    }
}

/// Minimum, maximum and last value of every column.
struct Summary {
    rows: Vec<(&'static str, [f64; 3])>,
}

impl Summary {
    fn new(columns: &[&'static str]) -> Self {
        let none = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN];
        Self {
            rows: columns.iter().map(|name| (*name, none)).collect(),
        }
    }

    fn table(&self) -> Table {
        let columns = ["column", "least", "greatest", "last"];
        let mut table = Table::new("", &columns.map(|name| (name, "")));
        for (name, numbers) in &self.rows {
            let numbers = numbers.map(|value| Cell::Number(value, 3));
            table.push([Cell::from(*name)].into_iter().chain(numbers));
        }
        table
    }
}

impl Rows for Summary {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        for ((_, [least, greatest, last]), value) in self.rows.iter_mut().zip(values) {
            *least = least.min(*value);
            *greatest = greatest.max(*value);
            *last = *value;
        }
        Ok(())
    }
}

impl Sink for Summary {
    fn finish(self: Box<Self>) -> Result<(), crate::Error> {
        output::print_table(&self.table())
    }
}
