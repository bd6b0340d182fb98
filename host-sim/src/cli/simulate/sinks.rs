//! Where the rows of a run go.

use std::path::PathBuf;

use indicatif::ProgressBar;

use crate::{
    cli::output::{self, CsvSink},
    error::Error,
    plot,
    report::{Cell, Table, figures},
    simulate::{Rows, Simulation},
    trace::Trace,
};

/// The most rows that are kept for a plot: some 0.4 GB, and more than any screen resolves.
const MOST_PLOTTED: u64 = 2_000_000;

/// A CSV file or a summary, and a plot where one is wanted.
pub struct Sinks {
    table: TableSink,
    plot: Option<PlotSink>,
    progress: ProgressBar,
}

enum TableSink {
    Csv(CsvSink),
    Summary(Summary),
}

struct PlotSink {
    path: PathBuf,
    title: String,
    trace: Trace,
}

impl Sinks {
    /// Opens what the rows of this run go to.
    pub fn create(
        simulation: &Simulation,
        csv: Option<PathBuf>,
        plot: Option<PathBuf>,
    ) -> Result<Self, Error> {
        let columns = simulation.columns();
        let plot = plot.map(|path| PlotSink::create(simulation, path));
        Ok(Self {
            plot: plot.transpose()?,
            table: match csv {
                Some(path) => TableSink::Csv(CsvSink::create(&path, &columns)?),
                None => TableSink::Summary(Summary::new(&columns)),
            },
            progress: output::progress(simulation.rows(), "rows"),
        })
    }

    /// Writes what is left.
    pub fn finish(self) -> Result<(), Error> {
        self.progress.finish_and_clear();
        match self.table {
            TableSink::Csv(csv) => csv.finish()?,
            TableSink::Summary(summary) => output::print_table(&summary.table())?,
        }
        self.plot.map_or(Ok(()), PlotSink::finish)
    }
}

impl Rows for Sinks {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        match &mut self.table {
            TableSink::Csv(csv) => csv.numbers(values)?,
            TableSink::Summary(summary) => summary.take(values),
        }
        if let Some(plot) = &mut self.plot {
            plot.trace.push(values);
        }
        self.progress.inc(1);
        Ok(())
    }
}

impl PlotSink {
    fn create(simulation: &Simulation, path: PathBuf) -> Result<Self, Error> {
        plot::Format::of(&path)?;
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

    fn finish(self) -> Result<(), Error> {
        plot::save(&figures::of_trace(&self.title, &self.trace), &self.path)?;
        eprintln!("plot: {}", self.path.display());
        Ok(())
    }
}

/// Least, greatest and last value of every column.
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

    fn take(&mut self, values: &[f64]) {
        for ((_, [least, greatest, last]), value) in self.rows.iter_mut().zip(values) {
            *least = least.min(*value);
            *greatest = greatest.max(*value);
            *last = *value;
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
