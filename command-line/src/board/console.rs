//! What is typed, and the frames that it becomes (`firmware::frames`).

use std::io::BufRead;
use std::path::PathBuf;
use std::sync::mpsc::Sender;

use virtual_board::can::{Frame, Id};

/// A line of the console.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Command {
    /// Command this angle, deg, from now on.
    Angle(f64),
    /// Send this order.
    Order(u8),
    /// Send servo pulses of this length, us, or none.
    Servo(Option<f64>),
    /// Save the capture into this file.
    SaveCapture(PathBuf),
    /// End the run.
    End,
}

/// The request of a frame that only commands.
pub(super) const NO_ORDER: u8 = 0;

/// The order that closes the loop.
pub(super) const ENABLE: u8 = 1;

/// The command frame of node 1.
const COMMAND: u16 = 0x201;

/// Greatest angle, deg.
const GREATEST_DEG: f64 = 180.0;

fn parse(line: &str) -> Result<Command, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    Ok(match words[..] {
        ["enable"] => Command::Order(ENABLE),
        ["disable"] => Command::Order(2),
        ["stop"] => Command::Order(3),
        ["ack"] => Command::Order(4),
        ["save"] => Command::Order(7),
        ["capture", "start"] => Command::Order(11),
        ["capture", "stop"] => Command::Order(12),
        ["capture", "save", path] => Command::SaveCapture(path.into()),
        ["end"] => Command::End,
        ["servo", "off"] => Command::Servo(None),
        ["servo", us] => Command::Servo(Some(number(us, "a pulse of", 1.0, 19_000.0, "us")?)),
        [deg] => Command::Angle(number(
            deg,
            "an angle of",
            -GREATEST_DEG,
            GREATEST_DEG,
            "deg",
        )?),
        _ => return Err(format!("`{line}` is no command")),
    })
}

fn number(word: &str, what: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    let value = word.parse().ok();
    value
        .filter(|value| (least..=most).contains(value))
        .ok_or_else(|| format!("`{word}`: expected {what} {least} to {most} {unit}"))
}

/// Reads the terminal until it ends.
pub(super) fn read(typed: &Sender<Command>) {
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        if line.trim().is_empty() {
            continue;
        }
        match parse(line.trim()) {
            Ok(command) => {
                if typed.send(command).is_err() {
                    return;
                }
            }
            Err(message) => eprintln!("{message}"),
        }
    }
}

/// A command frame.
pub(super) fn frame(angle_deg: f64, order: u8) -> Frame {
    let [a, b, c, d] = ((angle_deg * 1e3).round() as i32).to_le_bytes();
    Frame::data_frame(Id::Standard(COMMAND), &[a, b, c, d, order])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_commands_or_say_what_was_expected() {
        assert_eq!(parse("enable"), Ok(Command::Order(ENABLE)));
        assert_eq!(parse("-12.5"), Ok(Command::Angle(-12.5)));
        assert_eq!(parse("servo 1500"), Ok(Command::Servo(Some(1500.0))));
        assert_eq!(parse("servo off"), Ok(Command::Servo(None)));
        assert_eq!(parse("capture start"), Ok(Command::Order(11)));
        let save = Command::SaveCapture("run.csv".into());
        assert_eq!(parse("capture save run.csv"), Ok(save));
        let error = parse("999").unwrap_err();
        assert_eq!(error, "`999`: expected an angle of -180 to 180 deg");
        assert_eq!(parse("go on"), Err("`go on` is no command".into()));
    }

    #[test]
    fn an_angle_goes_out_in_thousandths() {
        let frame = frame(-1.5, 1);
        assert_eq!(frame.payload(), [0x24, 0xfa, 0xff, 0xff, 1]);
    }
}
