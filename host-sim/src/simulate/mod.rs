//! Runs a model on a command, row by row.
//!
//! Row `i` is the state at tick `i`, after what the control and the PWM do at that instant and
//! before the plant moves on.

mod board;
pub mod extremes;
mod float;

use model_core::{
    models::{black_box_1::BlackBox1, black_box_2::BlackBox2, grey_box::GreyBox},
    time::ticks,
};

use crate::{
    error::Error,
    input::{Command, CommandPath, Sequence},
    settings::{ModelKind, Settings},
    trace::Trace,
};

/// Columns that every model has.
const COMMON_COLUMNS: [&str; 8] = [
    "t",
    "command",
    "command_delayed",
    "angle_deg",
    "rate_deg_s",
    "duty_pct",
    "angle_meas_deg",
    "rate_meas_deg_s",
];

/// Everything that a run depends on.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The model and its parameters.
    pub settings: Settings,
    /// What is commanded.
    pub command: Command,
    /// How the command is called.
    pub input: String,
    /// A torque on the load of the bench, Nm, beside that of its parameters.
    pub load: Option<Sequence>,
    /// How many ticks to run, from tick 0.
    pub ticks: u64,
    /// Every how many ticks a row is made; not 0.
    pub every: u64,
}

/// Takes the rows of a run as they are made.
pub trait Rows {
    /// Takes one row, with one value a column.
    ///
    /// # Errors
    /// Whatever keeps it from taking more; the run ends with it.
    fn row(&mut self, values: &[f64]) -> Result<(), Error>;
}

impl Rows for Trace {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        self.push(values);
        Ok(())
    }
}

impl Simulation {
    /// What is run, in a line.
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

    /// How many rows there will be.
    pub fn rows(&self) -> u64 {
        self.ticks.div_ceil(self.every.max(1))
    }

    /// Runs and records everything.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters that do not go together.
    pub fn record(&self) -> Result<Trace, Error> {
        // Room for an hour at 1 ms at the most: longer traces grow as they come.
        let room = self.rows().min(3_600_000) as usize;
        let mut trace = Trace::new(&self.columns(), room);
        self.run(&mut trace)?;
        Ok(trace)
    }

    /// Runs and hands out the rows.
    ///
    /// # Errors
    /// [`Error::Parameter`] for parameters that do not go together, and whatever `rows` says.
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

    fn path(&self) -> CommandPath<'_> {
        CommandPath {
            command: &self.command,
            delay_ticks: ticks(self.settings.setup.delay_s),
            host_ticks: ticks(self.settings.setup.host_period_s),
        }
    }
}
