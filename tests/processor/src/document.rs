//! The results as Markdown, and their place in `docs/emulated-board.md`.

use std::fmt::Write as _;

use virtual_board::run::Firmware;

use crate::shadow::Shadow;

/// The functions that are listed: interrupt, number of its exception, and what it does.
pub const HANDLERS: [(&str, u32, &str); 8] = [
    ("DMA2_STREAM0", 72, "control step"),
    ("TIM1_UP_TIM10", 41, "PWM edge"),
    ("TIM1_CC", 43, "sampling instants"),
    ("UART7", 98, "turn of the CANopen node"),
    ("UART8", 99, "parameter store and log"),
    ("CAN1_RX0", 36, "received frames"),
    ("CAN1_TX", 35, "frames to transmit"),
    ("CAN1_SCE", 38, "state of the bus"),
];

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

/// What was compared.
///
/// # Panics
/// If the program lacks one of the interrupts.
pub fn comparison(shadow: &Shadow, firmware: &Firmware, end_ns: u64) -> String {
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
    for (name, exception, function) in HANDLERS {
        assert!(firmware.functions().any(|other| other == name), "no {name}");
        let ended = compared.handlers.get(&exception).copied().unwrap_or(0);
        row(&format!("ends of `{name}`: {function}"), grouped(ended));
    }
    row("differences", "0".into());
    text
}

/// Replaces the text between the marks of this name in `docs/emulated-board.md`.
///
/// # Errors
/// The document cannot be changed, or has no such marks.
pub fn write(name: &str, text: &str) -> Result<(), String> {
    let path = cross_build::workspace().join("docs/emulated-board.md");
    let document = std::fs::read_to_string(&path).map_err(|error| error.to_string())?;
    let (begin, end) = (
        format!("<!-- {name} -->\n"),
        format!("<!-- end of {name} -->"),
    );
    let missing = || format!("{} has no marks {begin:?}", path.display());
    let (before, rest) = document.split_once(&begin).ok_or_else(missing)?;
    let (_, after) = rest.split_once(&end).ok_or_else(missing)?;
    let document = format!("{before}{begin}{text}{end}{after}");
    std::fs::write(&path, document).map_err(|error| error.to_string())
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
