//! `actuator`: the smart actuator on a PC.

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match host_sim::cli::Arguments::parse().run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => failure.report(),
    }
}
