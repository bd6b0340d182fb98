//! Runs a model on a command, row by row.
//!
//! Row `i` is the state at tick `i`, after what the control and the PWM do at that instant and
//! before the plant moves on.

mod board;
pub mod closed_loop;
pub mod extremes;
mod float;

use model_core::{
    models::{black_box_1::BlackBox1, black_box_2::BlackBox2, grey_box::GreyBox},
    plant::Pwm,
    time::{TICKS_PER_SECOND, ticks},
};

use crate::{
    error::Error,
    input::{Command, CommandPath, Sequence},
    settings::{ModelSettings, Settings},
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
    /// How the bridge is switched.
    pub pwm: Pwm,
    /// Seed of all that is random.
    pub seed: u64,
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
        format!("{} on {}", self.settings.kind().name(), self.input)
    }

    /// The names of the columns.
    pub fn columns(&self) -> Vec<&'static str> {
        let more = match &self.settings.model {
            ModelSettings::Board(settings) => board::columns(settings),
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
        match &self.settings.model {
            ModelSettings::BlackBox1(p) => float::run(BlackBox1::try_new(*p)?, self, &path, rows),
            ModelSettings::BlackBox2(p) => float::run(BlackBox2::try_new(*p)?, self, &path, rows),
            ModelSettings::GreyBox(p) => float::run(GreyBox::try_new(*p)?, self, &path, rows),
            ModelSettings::Board(settings) => board::run(settings, self, &path, rows),
        }
    }

    fn path(&self) -> CommandPath {
        CommandPath {
            command: self.command.clone(),
            delay_ticks: ticks(self.settings.setup.delay_s),
            host_ticks: ticks(self.settings.setup.host_period_s),
        }
    }
}

/// The time of a tick, s, with the last bit as a decimal fraction has it.
fn time_s(tick: u64) -> f64 {
    tick as f64 / TICKS_PER_SECOND as f64
}
