//! What is timed, and how: figures that depend on the machine and on what else it does.

use std::{path::PathBuf, process::Command, time::Instant};

use crate::{Error, measurement::cargo};

/// A figure of one run.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Benchmarks that print their figures.
const BENCHMARKS: [&str; 2] = [
    "bench -p host-sim --bench board_loop --bench server --locked",
    "bench -p board-tests --bench emulated --profile release --ignore-rust-version --locked",
];

/// Whole processes of the program `actuator`: name and arguments. `RECORDING` is replaced by a
/// recording of 1,250 samples, `PAGE` for a file that is written.
const PROCESSES: [(&str, &str); 3] = [
    ("actuator --help", "--help"),
    ("report", "report --out PAGE"),
    (
        "identify of 1,250 samples with 8 starts",
        "identify RECORDING --model black-box-1 --starts 8 --json PAGE",
    ),
];

/// Starts of a process before those that are timed, so that its file and those that it reads are in
/// memory.
const UNTIMED_STARTS: usize = 3;

/// Starts of a process that are timed; their median is the figure.
const TIMED_STARTS: usize = 21;

/// Prepared programs and files.
#[derive(Debug)]
pub struct Timings {
    program: PathBuf,
    recording: PathBuf,
    page: PathBuf,
}

impl Timings {
    /// Builds everything that is timed, and makes the recording.
    ///
    /// # Errors
    /// If a build or the simulation of the recording fails.
    pub fn prepare() -> Result<Self, Error> {
        cargo("build --release -p actuator --locked".split(' '))?;
        for benchmark in BENCHMARKS {
            cargo(benchmark.split(' ').chain(["--no-run"]))?;
        }
        let target = cross_build::workspace().join("target");
        let timings = Self {
            program: target.join("release/actuator"),
            recording: target.join("figures-recording.csv"),
            page: target.join("figures-page.json"),
        };
        timings.process("simulate black-box-1 --input pulse --every 80 --csv RECORDING")?;
        Ok(timings)
    }

    /// Times everything once.
    ///
    /// # Errors
    /// If a program fails.
    pub fn run(&self) -> Result<Vec<Figure>, Error> {
        let mut figures = Vec::new();
        for benchmark in BENCHMARKS {
            let text = cargo(benchmark.split(' '))?;
            figures.extend(text.lines().filter_map(figure));
        }
        for (name, arguments) in PROCESSES {
            figures.push(Figure {
                name: format!("whole process: {name}"),
                value: self.median_ms(arguments)?,
                unit: "ms".into(),
            });
        }
        Ok(figures)
    }

    /// The median of the times from the start of a process to its end.
    fn median_ms(&self, arguments: &str) -> Result<f64, Error> {
        let mut times_ms = Vec::new();
        for _ in 0..UNTIMED_STARTS + TIMED_STARTS {
            let start = Instant::now();
            self.process(arguments)?;
            times_ms.push(start.elapsed().as_secs_f64() * 1e3);
        }
        let timed = &mut times_ms[UNTIMED_STARTS..];
        Ok(*timed
            .select_nth_unstable_by(TIMED_STARTS / 2, f64::total_cmp)
            .1)
    }

    fn process(&self, arguments: &str) -> Result<(), Error> {
        let command = || format!("actuator {arguments}");
        let path = |word: &str| match word {
            "RECORDING" => self.recording.clone(),
            "PAGE" => self.page.clone(),
            word => word.into(),
        };
        let output = Command::new(&self.program)
            .args(arguments.split(' ').map(path))
            .output();
        let output = output.map_err(|source| Error::Start {
            command: command(),
            source,
        })?;
        if output.status.success() {
            return Ok(());
        }
        Err(Error::Failed {
            command: command(),
            output: String::from_utf8_lossy(&output.stderr).into_owned(),
        })
    }
}

/// The figure of a line `figure NAME = VALUE UNIT`.
fn figure(line: &str) -> Option<Figure> {
    let (name, rest) = line.strip_prefix("figure ")?.split_once(" = ")?;
    let (value, unit) = rest.split_once(' ')?;
    Some(Figure {
        name: name.to_owned(),
        value: value.parse().ok()?,
        unit: unit.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_has_name_value_and_unit() {
        let expected = Figure {
            name: "60 s: this to C".into(),
            value: 1.5,
            unit: "times".into(),
        };
        assert_eq!(figure("figure 60 s: this to C = 1.5 times"), Some(expected));
        assert_eq!(figure("Running benches"), None);
    }
}
