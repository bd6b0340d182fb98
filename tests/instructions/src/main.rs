//! Counts instructions by `valgrind --tool=callgrind` and compares them with golden counts.
//!
//! Times on a shared machine vary by tens of percent, counts by less than one. This program runs
//! itself in valgrind once for each workload, with the name of the workload as its argument; only
//! what runs below `counted_work` is counted.

mod golden;
mod workloads;

use std::{path::PathBuf, process::Command, process::ExitCode};

use golden::Golden;
use workloads::WORKLOADS;

/// Relative difference from the golden count that is accepted.
const TOLERANCE: f64 = 0.03;

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
enum Error {
    #[error("cannot run `{0}`: {1}; `apt-get install valgrind` installs it")]
    Start(&'static str, std::io::Error),
    #[error("valgrind counts no instruction of {workload}:\n{output}")]
    NoCount { workload: String, output: String },
    #[error("{}: {source}", path.display())]
    File {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{}: `{line}` is no name with a count", path.display())]
    Line { path: PathBuf, line: String },
    #[error("there is no workload {0}")]
    Unknown(String),
}

fn main() -> ExitCode {
    let result = match std::env::args().nth(1) {
        Some(name) => workload(&name).map(|()| true),
        None => compare(),
    };
    match result {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

/// Runs a workload: in valgrind, called by [`count`].
fn workload(name: &str) -> Result<(), Error> {
    let found = WORKLOADS.iter().find(|workload| workload.name == name);
    (found.ok_or_else(|| Error::Unknown(name.to_owned()))?.run)();
    Ok(())
}

/// Counts all workloads and compares or renews the golden counts; returns whether all are within
/// the tolerance.
fn compare() -> Result<bool, Error> {
    let golden = Golden::read()?;
    let mut counted = Golden::default();
    let mut is_good = true;
    println!(
        "{:<28} {:>14} {:>10} {:>8}",
        "", "instructions", "of each", "change"
    );
    for workload in &WORKLOADS {
        let count = count(workload.name)?;
        let each = count / workload.parts;
        counted.push(workload.name, count);
        let change = golden
            .of(workload.name)
            .map(|old| count as f64 / old as f64 - 1.0);
        let text = change.map_or("new".into(), |change| format!("{:+.1} %", 100.0 * change));
        println!("{:<28} {count:>14} {each:>10} {text:>8}", workload.name);
        is_good &= change.is_some_and(|change| change.abs() <= TOLERANCE);
    }
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        counted.write()?;
        return Ok(true);
    }
    if !is_good {
        eprintln!(
            "counts differ by more than {} %; where that is meant: \
             UPDATE_GOLDEN=1 cargo run --profile bench -p instruction-counts",
            100.0 * TOLERANCE
        );
    }
    Ok(is_good)
}

/// Instructions of a workload.
fn count(name: &str) -> Result<u64, Error> {
    let program = std::env::current_exe().map_err(|error| Error::Start("current_exe", error))?;
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg("--toggle-collect=*counted_work*")
        .arg(program)
        .arg(name)
        .output()
        .map_err(|error| Error::Start("valgrind", error))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let collected = text.lines().find_map(|line| line.split_once("Collected :"));
    let count = collected.and_then(|(_, count)| count.trim().parse().ok());
    match count {
        Some(count) if output.status.success() && count > 0 => Ok(count),
        _ => Err(Error::NoCount {
            workload: name.to_owned(),
            output: text.into_owned(),
        }),
    }
}
