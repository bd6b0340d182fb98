//! The results as Markdown.

use std::fmt::Write as _;
use std::path::Path;

use program_handlers::Handler;

use crate::shadow::Shadow;

const HEAD: &str = "\
# Two processors

Written by `bash assurance/processor/ci.sh --seconds 300 --write`; `docs/emulated-board.md` says what is
compared.

";

/// A number with a comma between thousands.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut grouped = String::new();
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            grouped.push(',');
        }
        grouped.push(digit);
    }
    grouped
}

/// What was compared, with the ends of these handlers.
pub fn comparison(shadow: &Shadow, handlers: &[Handler], end_ns: u64) -> String {
    let compared = &shadow.compared;
    let mut text = String::from("| compared | number |\n|---|---|\n");
    let mut row = |what: &str, number: String| {
        let _ = writeln!(text, "| {what} | {number} |");
    };
    row("virtual time, s", grouped(end_ns / 1_000_000_000));
    row("instructions", grouped(compared.instructions));
    row("all registers", grouped(compared.registers));
    row("all RAM", grouped(compared.memories));
    row(
        "reads and writes of peripherals",
        grouped(shadow.accesses()),
    );
    row(
        "stretches that were not compared",
        grouped(compared.unstopped),
    );
    for handler in handlers {
        let ended = compared.handlers.get(&handler.exception);
        row(
            &format!("ends of `{}`: {}", handler.interrupt, handler.task),
            grouped(ended.copied().unwrap_or(0)),
        );
    }
    row("differences", "0".into());
    text
}

/// Writes the results.
///
/// # Errors
/// The file cannot be written.
pub fn write(text: &str) -> std::io::Result<()> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("results.md");
    std::fs::write(path, format!("{HEAD}{text}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_grouped_in_thousands() {
        let numbers = [7, 123, 1_234, 1_234_567].map(grouped);
        assert_eq!(numbers, ["7", "123", "1,234", "1,234,567"]);
    }
}
