//! The page.

use std::fmt::Write as _;

use crate::{history::Entry, machine::Machine, measurement::Measured};

/// The first line of the part with the counts.
const COUNTS: &str = "## Counts\n";

/// The part with the times, as Markdown: the last entry of each processor, the newest first.
pub fn times(entries: &[Entry]) -> String {
    let mut text = "# Figures\n\nWritten by `cargo run --release -p figures`.\n\n## Times\n\nSeveral \
         runs on each processor, with pauses between them; times depend on the machine and its load. \
         s/s are simulated seconds per second; a ratio above one is in favour of the first. \
         Rivals in C alternate with this program in each run. `figures.jsonl` keeps all \
         measurements. Figures of the control loop: [tracking](tracking.md), by `cargo run \
         --release -p tracking`.\n"
        .to_owned();
    let mut processors = Vec::new();
    for entry in entries.iter().rev() {
        if !processors.contains(&&entry.processor) {
            processors.push(&entry.processor);
            text += &times_of(entry);
        }
    }
    text + "\n"
}

fn times_of(entry: &Entry) -> String {
    let mut text = format!(
        "\n### {}\n\n{} runs of commit {}, {}, load average before: {}\n\n\
         | figure | least | median | greatest | unit |\n|---|---|---|---|---|\n",
        entry.processor, entry.runs, entry.commit, entry.date, entry.load
    );
    let mut group = "";
    for (name, range) in &entry.figures {
        let (of, what) = name.split_once(": ").unwrap_or(("", name));
        // Writing to a string does not fail.
        if of != group && !of.is_empty() {
            let _ = writeln!(text, "| **{of}** |||||");
        }
        group = of;
        let _ = writeln!(
            text,
            "| {what} | {} | {} | {} | {} |",
            rounded(range.least),
            rounded(range.median),
            rounded(range.greatest),
            range.unit
        );
    }
    text
}

/// The part with the counts, as Markdown.
pub fn counts(machine: &Machine, measured: &[Measured]) -> String {
    let mut text = format!(
        "{COUNTS}\nThe lines below each command are its output. They depend on the commit \
         and the compiler alone, as do sizes\nand instructions on a PC, which are in \
         [tests/golden](../tests/golden).\n\n{}",
        origin(machine)
    );
    for Measured { measurement, lines } in measured {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n### {}\n\n    {}\n\n```text\n{}\n```\n",
            measurement.what,
            measurement.command(),
            lines.join("\n")
        );
    }
    text
}

/// The part with the counts of a page.
pub fn counts_of(page: &str) -> &str {
    page.find(COUNTS).map_or("", |start| &page[start..])
}

fn origin(machine: &Machine) -> String {
    format!(
        "| | |\n|---|---|\n| commit | {} |\n| date | {} |\n| compiler | {} |\n",
        machine.commit, machine.date, machine.compiler
    )
}

/// Three digits.
fn rounded(value: f64) -> String {
    match value.abs() {
        100.0.. => format!("{value:.0}"),
        10.0.. => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::MEASUREMENTS;

    #[test]
    fn a_section_holds_command_and_lines_and_is_found_again() {
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
        let counts = counts(&machine, &[measured]);
        assert!(counts.contains("| commit | abc |"));
        assert!(counts.contains("```text\nflash 1 bytes\n```"));
        let page = times(&[Entry::of(&machine, &[])]) + &counts;
        assert_eq!(counts_of(&page), counts);
    }

    #[test]
    fn the_last_entry_of_each_processor_is_on_the_page_the_newest_first() {
        let entry = |commit: &str, processor: &str| {
            let machine = Machine {
                commit: commit.into(),
                date: "2026-01-01".into(),
                processor: processor.into(),
                load: "0.1".into(),
                compiler: "rustc".into(),
            };
            Entry::of(&machine, &[])
        };
        let page = times(&[entry("a", "p"), entry("b", "q"), entry("c", "p")]);
        let headings: Vec<_> = page
            .lines()
            .filter(|line| line.starts_with("### "))
            .collect();
        assert_eq!(headings, ["### p", "### q"]);
        assert!(page.contains("commit c,") && !page.contains("commit a,"));
    }
}
