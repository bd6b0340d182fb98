//! Runs a model on a command, row by row.
//!
//! Row `i` is the state at tick `i`, after the updates of control and PWM at that instant and
//! before the plant is stepped.

pub mod batch;
mod board;
pub mod extremes;
mod float;
mod progress;

use std::sync::Arc;

pub use progress::RunProgress;

use model_core::{
    actuator::Reading,
    models::{black_box_1::BlackBox1, black_box_2::BlackBox2, grey_box::GreyBox},
    time::ticks,
};

use crate::{
    error::Error,
    input::{Command, CommandPath, Sequence},
    settings::{ModelKind, Settings},
    trace::Trace,
};

/// Columns that every model has: time, command, and of [`Reading::COLUMNS`] all but current and
/// back-EMF.
const COMMON_COLUMNS: [&str; 8] = {
    let [a, b, c, d, e, f, ..] = Reading::COLUMNS;
    ["time_s", "command_deg", a, b, c, d, e, f]
};

/// A run with all of its inputs.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The model and its parameters.
    pub settings: Settings,
    /// The command.
    pub command: Command,
    /// The name of the command.
    pub input: String,
    /// A torque on the load of the bench, Nm, in addition to that of its parameters.
    pub load: Option<Sequence>,
    /// Number of ticks.
    pub ticks: u64,
    /// Ticks between two rows; not 0.
    pub every: u64,
    /// Counts the ticks, and can end the run.
    pub progress: Option<Arc<RunProgress>>,
}

/// A sink for the rows of a run.
pub trait Rows {
    /// Writes one row, with one value per column.
    ///
    /// # Errors
    /// Any error of the sink; it ends the run.
    fn row(&mut self, values: &[f64]) -> Result<(), Error>;
}

impl Rows for Trace {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.push(values);
        Ok(())
    }
}

impl Simulation {
    /// Model and input.
    pub fn title(&self) -> String {
        format!("{} on {}", self.settings.model, self.input)
    }

    /// The names of the columns.
    pub fn columns(&self) -> Vec<&'static str> {
        let more = match self.settings.model {
            ModelKind::Board => board::columns(self.settings.plant),
            _ => Vec::new(),
        };
        COMMON_COLUMNS.into_iter().chain(more).collect()
    }

    /// Number of rows.
    pub fn rows(&self) -> u64 {
        self.ticks.div_ceil(self.every.max(1))
    }

    /// Runs and records everything.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters that exclude each other.
    pub fn record(&self) -> Result<Trace, Error> {
        // Reserves at most an hour at 1 ms: longer traces grow.
        let room = self.rows().min(3_600_000) as usize;
        let mut trace = Trace::new(&self.columns(), room);
        self.run(&mut trace)?;
        Ok(trace)
    }

    /// Runs and writes the rows.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters that exclude each other; those of `rows`;
    /// [`Error::Interrupted`].
    pub fn run(&self, rows: &mut dyn Rows) -> Result<(), Error> {
        let path = self.path();
        let settings = &self.settings;
        match settings.model {
            ModelKind::BlackBox1 => {
                float::run(BlackBox1::try_new(settings.black_box_1)?, self, &path, rows)
            }
            ModelKind::BlackBox2 => {
                float::run(BlackBox2::try_new(settings.black_box_2)?, self, &path, rows)
            }
            ModelKind::GreyBox => {
                float::run(GreyBox::try_new(settings.grey_box)?, self, &path, rows)
            }
            ModelKind::Board => board::run(self, &path, rows),
        }
    }

    /// Counts the ticks of a check at this tick, if there is one: those up to the next check.
    #[inline(always)]
    fn check(&self, tick: u64) -> Result<(), Error> {
        match &self.progress {
            Some(progress) if tick.is_multiple_of(progress::CHECK_TICKS) => {
                progress.advance((self.ticks - tick).min(progress::CHECK_TICKS))
            }
            _ => Ok(()),
        }
    }

    fn path(&self) -> CommandPath<'_> {
        CommandPath {
            command: &self.command,
            delay_ticks: ticks(self.settings.setup.delay_s),
            host_ticks: ticks(self.settings.setup.host_period_s),
        }
    }
}
