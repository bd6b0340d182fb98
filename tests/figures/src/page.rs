//! The page.

use std::fmt::Write as _;

use crate::{machine::Machine, measurement::Measured};

/// The page as Markdown.
pub fn markdown(machine: &Machine, measured: &[Measured]) -> String {
    let mut text = format!(
        "# Figures\n\nWritten by `cargo run --release -p figures`; the lines below each command \
         are its output.\n\n\
         | | |\n|---|---|\n| commit | {} |\n| date | {} |\n| processor | {} |\n\
         | load average before | {} |\n| compiler | {} |\n\n\
         Counts of instructions and bytes depend on the commit and the compiler alone. Times and \
         ratios of times depend on the machine and its load.\n",
        machine.commit, machine.date, machine.processor, machine.load, machine.compiler
    );
    for Measured { measurement, lines } in measured {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n## {}\n\n    {}\n\n```text\n{}\n```\n",
            measurement.what,
            measurement.command(),
            lines.join("\n")
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::MEASUREMENTS;

    #[test]
    fn a_section_holds_command_and_lines() {
        let machine = Machine {
            commit: "abc".into(),
            date: "2026-01-01".into(),
            processor: "p".into(),
            load: "0.1".into(),
            compiler: "rustc".into(),
        };
        let measured = Measured {
            measurement: &MEASUREMENTS[0],
            lines: vec!["flash 1 bytes".into()],
        };
        let text = markdown(&machine, &[measured]);
        assert!(text.contains("| commit | abc |"));
        assert!(text.contains("```text\nflash 1 bytes\n```"));
    }
}
