//! What is counted, and how: figures that depend on the commit and the compiler alone.

use std::process::Command;

use crate::Error;

/// A command, and the lines of its output that are figures.
#[derive(Debug)]
pub struct Measurement {
    /// Heading of the figures.
    pub what: &'static str,
    /// Arguments of cargo.
    arguments: &'static str,
    /// A line is a figure if it contains one of these.
    markers: &'static [&'static str],
}

/// The figures of one command.
#[derive(Debug)]
pub struct Measured {
    /// The command.
    pub measurement: &'static Measurement,
    /// Its lines.
    pub lines: Vec<String>,
}

/// Every measurement, in the order of the page. Sizes and instructions on a PC are golden files.
pub static MEASUREMENTS: [Measurement; 3] = [
    Measurement {
        what: "Instructions of a control period on the board",
        arguments: "test-all --test board -- --nocapture --test-threads 1 below_300 instructions_of_a_control_period",
        markers: &["instructions", "all handlers"],
    },
    Measurement {
        what: "Longest communication cycle, start of the control step, stack",
        arguments: "test-all --test board -- --nocapture --test-threads 1 the_communication_ends",
        markers: &["the loop,", "starts", "stack:"],
    },
    Measurement {
        what: "From the last byte of a command on the serial line to its duty",
        arguments: "test-all --test board -- --nocapture --test-threads 1 a_command_reaches",
        markers: &["from the last byte"],
    },
];

impl Measurement {
    /// The command line.
    pub fn command(&self) -> String {
        format!("cargo {}", self.arguments)
    }

    /// Runs the command and takes its figures.
    ///
    /// # Errors
    /// If the command cannot be started, fails, or prints no figure.
    pub fn run(&'static self) -> Result<Measured, Error> {
        let text = cargo(self.arguments.split_whitespace())?;
        let is_figure = |line: &&str| self.markers.iter().any(|marker| line.contains(marker));
        let lines = text.lines().filter(is_figure);
        let lines: Vec<_> = lines
            .map(|line| without_test_name(line).to_owned())
            .collect();
        if lines.is_empty() {
            return Err(Error::NoFigure {
                command: self.command(),
                marker: self.markers.join("\" or \""),
            });
        }
        Ok(Measured {
            measurement: self,
            lines,
        })
    }
}

/// Runs cargo in the workspace and returns what it prints.
///
/// # Errors
/// If it cannot be started or fails.
pub fn cargo<'a>(arguments: impl IntoIterator<Item = &'a str>) -> Result<String, Error> {
    let arguments: Vec<_> = arguments.into_iter().collect();
    let command = format!("cargo {}", arguments.join(" "));
    let program = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let output = Command::new(program)
        .current_dir(cross_build::workspace())
        .args(&arguments)
        .output();
    let output = output.map_err(|source| Error::Start {
        command: command.clone(),
        source,
    })?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() {
        return Ok(text);
    }
    let output = format!("{text}{}", String::from_utf8_lossy(&output.stderr));
    Err(Error::Failed { command, output })
}

/// A line without the name of its test, which the test runner prints before the first line of a
/// test.
fn without_test_name(line: &str) -> &str {
    match line.split_once(" ... ") {
        Some((name, rest)) if name.starts_with("test ") => rest,
        _ => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_a_test_is_no_part_of_a_figure() {
        assert_eq!(
            without_test_name("test a::b ... flash 1 bytes"),
            "flash 1 bytes"
        );
        assert_eq!(without_test_name("flash 1 bytes"), "flash 1 bytes");
    }
}
