//! Lists the experiments of `assurance/evidence.toml`, or records one.

#![forbid(unsafe_code)]

use std::path::Path;
use std::process::ExitCode;

use clap::Parser;
use evidence::{Error, Evidence, Repository, State, record};

/// Lists the experiments, and which of their results are stale
#[derive(Debug, Parser)]
struct Options {
    /// Lists only those whose results are not of the present sources, and fails if there are any
    #[arg(long, conflicts_with = "update")]
    check: bool,
    /// Records that this experiment has run with the sources of the last commit
    #[arg(long, value_name = "ID", requires = "result")]
    update: Option<String>,
    /// What it found
    #[arg(long, value_name = "TEXT", requires = "update")]
    result: Option<String>,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(2)
        }
    }
}

fn run(options: &Options) -> Result<ExitCode, Error> {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let path = package.with_file_name("evidence.toml");
    let git = Repository::new(package.ancestors().nth(2).unwrap_or(package));
    if let (Some(id), Some(result)) = (&options.update, &options.result) {
        record(&path, &git, id, result)?;
        return Ok(ExitCode::SUCCESS);
    }
    let evidence = Evidence::read(&path)?;
    let mut are_all_shown = true;
    for experiment in &evidence.experiments {
        let state = evidence.state(experiment, &git)?;
        are_all_shown &= state.is_shown();
        if options.check && state.is_shown() {
            continue;
        }
        println!("{state:12} {}: {}", experiment.id, experiment.claim);
        if state == State::Stale {
            let commit = experiment.commit.as_deref().unwrap_or("an unknown commit");
            println!("{:12} last result, of {commit}:", "");
        }
        if let Some(result) = &experiment.result {
            println!("{:12} {result}", "");
        }
    }
    Ok(if options.check && !are_all_shown {
        ExitCode::FAILURE
    } else {
        ExitCode::SUCCESS
    })
}
