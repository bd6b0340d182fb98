//! `actuator`: the smart actuator on the command line.
//!
//! A module for each command maps its options to a call of a library, and prints the result.

/// Writes a line to standard error.
macro_rules! note {
    ($($text:tt)*) => {
        $crate::output::note(format_args!($($text)*))
    };
}

#[cfg(feature = "board")]
mod board;
mod bounded;
mod can;
mod compare;
mod completions;
#[cfg(feature = "board")]
mod emulated;
mod error;
mod experiment;
mod export;
mod fmu;
mod identify;
mod image;
mod interrupt;
mod manual;
mod mujoco;
mod origin;
mod output;
mod parameters;
mod report;
mod simulate;
mod studio;
#[cfg(unix)]
mod terminal;
mod tune;

use std::{
    env,
    error::Error as _,
    io::{self, IsTerminal},
    num::{ParseFloatError, ParseIntError},
    process::{self, ExitCode},
};

use clap::{Parser, Subcommand, error::ContextKind};

use error::Error;

/// A smart RC-servo actuator: simulation, identification, tuning and CAN.
///
/// Exit status: 0 success, 1 a file or a bus cannot be read or written, 2 the command line, a
/// parameter or an input is invalid, 3 an actuator refuses or a fit has not converged, 4 an
/// actuator stopped at one of its limits, 130 interrupted.
#[derive(Debug, Parser)]
#[command(name = "actuator", version, max_term_width = 100)]
#[command(mut_subcommands(with_negative_numbers))]
struct Arguments {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(feature = "board")]
    Board(board::Board),
    #[command(name = "busload")]
    BusLoad(can::BusLoad),
    Commission(can::Commission),
    Compare(compare::Compare),
    Completions(completions::Completions),
    Demo(studio::Demo),
    Excite(can::Excite),
    Experiment(experiment::Experiment),
    Export(export::Export),
    Faults(can::Faults),
    Fmu(fmu::Fmu),
    Mujoco(mujoco::Mujoco),
    Get(can::Get),
    Identify(identify::Identify),
    Image(image::Image),
    Manual(manual::Manual),
    Monitor(can::Monitor),
    Move(can::Move),
    Record(can::Record),
    Restore(can::Restore),
    Save(can::Save),
    Scan(can::Scan),
    Serve(can::Serve),
    Set(can::Set),
    Simulate(simulate::Simulate),
    Stop(can::Stop),
    Studio(studio::Studio),
    Tune(tune::Tune),
    Update(can::Update),
    Report(report::Report),
}

/// Lets every option take a negative number, so that the check of its range refuses it.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    command.mut_args(|arg| {
        let takes_values = arg.get_action().takes_values();
        arg.allow_negative_numbers(takes_values)
    })
}

/// What the program answers without a command.
const FIRST_STEPS: &str = "\
Begin with one of these:

  actuator demo                      a tour in the browser: move, break, identify and tune an actuator
  actuator studio                    simulated actuators in the browser, or those of a bus
  actuator report                    the paper's figures, simulated, as a page
  actuator simulate board --plot run.html
                                     a pulse on the board, as a plot
  actuator identify RECORDING        a model of a recorded servo, with standard errors
  actuator export fitted.toml --to mujoco-position
                                     that model as the actuator of another simulator
  actuator scan --bus can0           the actuators on a bus

`actuator help` lists all commands, `actuator help COMMAND` the options of one.
";

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Those of the command.
    fn run(self) -> Result<(), Error> {
        let Some(command) = self.command else {
            return output::print(FIRST_STEPS);
        };
        match command {
            #[cfg(feature = "board")]
            Command::Board(board) => board.run(),
            Command::BusLoad(bus_load) => bus_load.run(),
            Command::Commission(commission) => commission.run(),
            Command::Compare(compare) => compare.run(),
            Command::Completions(completions) => completions.run(),
            Command::Demo(demo) => demo.run(),
            Command::Excite(excite) => excite.run(),
            Command::Experiment(experiment) => experiment.run(),
            Command::Export(export) => export.run(),
            Command::Faults(faults) => faults.run(),
            Command::Fmu(fmu) => fmu.run(),
            Command::Mujoco(mujoco) => mujoco.run(),
            Command::Get(get) => get.run(),
            Command::Identify(identify) => identify.run(),
            Command::Image(image) => image.run(),
            Command::Manual(manual) => manual.run(),
            Command::Monitor(monitor) => monitor.run(),
            Command::Move(to) => to.run(),
            Command::Record(record) => record.run(),
            Command::Restore(restore) => restore.run(),
            Command::Save(save) => save.run(),
            Command::Scan(scan) => scan.run(),
            Command::Serve(serve) => serve.run(),
            Command::Set(set) => set.run(),
            Command::Stop(stop) => stop.run(),
            Command::Simulate(simulate) => simulate.run(),
            Command::Studio(studio) => studio.run(),
            Command::Tune(tune) => tune.run(),
            Command::Update(update) => update.run(),
            Command::Report(report) => report.run(),
        }
    }
}

/// The whole command line.
fn command() -> clap::Command {
    <Arguments as clap::CommandFactory>::command()
}

/// The answer, which names the expected number in place of the parser's problem.
fn with_the_expected(answer: clap::Error) -> clap::Error {
    let expected = match answer.source() {
        Some(problem) if problem.is::<ParseIntError>() => "a whole number",
        Some(problem) if problem.is::<ParseFloatError>() => "a number",
        _ => return answer,
    };
    let (Some(argument), Some(value)) = (
        answer.get(ContextKind::InvalidArg),
        answer.get(ContextKind::InvalidValue),
    ) else {
        return answer;
    };
    clap::Error::raw(
        answer.kind(),
        format!("{argument} is {value}, expected {expected}\n"),
    )
}

/// The arguments. Requested text, as that of `--help`, goes to a pipe or a file in one
/// piece: line by line its reader would be woken for each.
fn arguments() -> Arguments {
    Arguments::try_parse()
        .map_err(with_the_expected)
        .unwrap_or_else(|answer| {
            let is_plain = !io::stdout().is_terminal() && env::var_os("CLICOLOR_FORCE").is_none();
            if !answer.use_stderr() && is_plain {
                let printed = output::print(&answer.render().to_string());
                process::exit(printed.map_or(1, |()| answer.exit_code()));
            }
            let printed = answer.print();
            process::exit(printed.map_or(1, |()| answer.exit_code()))
        })
}

fn main() -> ExitCode {
    interrupt::handle();
    let status = match arguments().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    };
    if output::is_note_lost() {
        return ExitCode::FAILURE;
    }
    status
}
