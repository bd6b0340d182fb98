//! Tests of the program `actuator` through its command line.

mod abuse;
#[cfg(feature = "board")]
mod board;
mod bus;
mod dronecan;
mod errors;
mod export;
mod fmu;
#[cfg(feature = "board")]
mod gdb;
mod identify;
mod image;
mod input_file;
mod mujoco;
mod options;
mod parameters;
mod recordings;
mod scenario;
#[cfg(target_os = "linux")]
mod serve;
mod served;
mod servos;
mod silent;
mod simulate;
#[cfg(unix)]
mod stop;
mod tables;
mod trace_file;
mod tune;

use std::path::{Path, PathBuf};

use assert_cmd::{Command, cargo::cargo_bin_cmd};
use tempfile::TempDir;

/// The program with a temporary working directory.
struct Cli {
    directory: TempDir,
}

impl Cli {
    fn new() -> Self {
        let directory = tempfile::tempdir().expect("a temporary directory can be made");
        Self { directory }
    }

    /// The program with these arguments, separated by blanks.
    fn actuator(&self, arguments: &str) -> Command {
        let mut command = cargo_bin_cmd!("actuator");
        command.current_dir(self.directory.path());
        command.args(arguments.split_whitespace());
        command
    }

    fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.directory.path().join(name)
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("the temporary directory can be written");
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.path(name)).expect("the file was written")
    }

    /// Output of `actuator simulate ARGUMENTS --csv -`.
    fn trace(&self, arguments: &str) -> Csv {
        Csv::parse(&self.text(&format!("simulate {arguments} --csv -")))
    }

    /// Standard output of a successful run.
    fn text(&self, arguments: &str) -> String {
        let output = self.actuator(arguments).assert().success();
        String::from_utf8(output.get_output().stdout.clone()).expect("the output is UTF-8")
    }

    /// Asserts that the program ends with this status and writes exactly this to standard error.
    #[track_caller]
    fn assert_error(&self, arguments: &str, status: i32, message: &str) {
        let assert = self.actuator(arguments).assert().code(status);
        let error = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
        assert!(
            error.contains(message),
            "{arguments}\n{error}\nlacks: {message}"
        );
        assert!(assert.get_output().stdout.is_empty(), "{arguments}");
    }
}

/// A table of numbers.
struct Csv {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Csv {
    fn parse(text: &str) -> Self {
        let mut lines = text.lines();
        let names = lines.next().unwrap_or_default().split(',');
        let names: Vec<String> = names.map(str::to_owned).collect();
        let number = |field: &str| field.parse().unwrap_or_else(|_| panic!("number: {field}"));
        let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(number).collect()).collect();
        assert!(rows.iter().all(|row| row.len() == names.len()));
        Self { names, rows }
    }

    fn column(&self, name: &str) -> Vec<f64> {
        let index = self.names.iter().position(|n| n == name);
        let index = index.unwrap_or_else(|| panic!("column {name}"));
        self.rows.iter().map(|row| row[index]).collect()
    }
}
