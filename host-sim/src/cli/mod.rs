//! The command line of `actuator`.

#[cfg(feature = "board")]
mod board;
mod compare;
mod experiment;
mod fmu;
mod identify;
mod output;
mod parameters;
mod report;
mod simulate;
mod tune;

use clap::{Parser, Subcommand};

pub use output::Failure;

/// A smart RC-servo actuator on the desk: its control core, its models and its bench.
///
/// Exit status: 0 done, 1 a file could not be read or written, 2 the command line, a parameter or
/// an input is not what was expected.
#[derive(Debug, Parser)]
#[command(name = "actuator", version, max_term_width = 100)]
pub struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(feature = "board")]
    Board(board::Board),
    Compare(compare::Compare),
    Experiment(experiment::Experiment),
    Fmu(fmu::Fmu),
    Identify(identify::Identify),
    Simulate(simulate::Simulate),
    Tune(tune::Tune),
    Report(report::Report),
}

impl Arguments {
    /// Does what the command line says.
    ///
    /// # Errors
    /// What went wrong, with its exit status.
    pub fn run(self) -> Result<(), Failure> {
        match self.command {
            #[cfg(feature = "board")]
            Command::Board(board) => board.run(),
            Command::Compare(compare) => compare.run(),
            Command::Experiment(experiment) => experiment.run(),
            Command::Fmu(fmu) => fmu.run(),
            Command::Identify(identify) => identify.run(),
            Command::Simulate(simulate) => simulate.run(),
            Command::Tune(tune) => tune.run(),
            Command::Report(report) => report.run(),
        }
    }
}
