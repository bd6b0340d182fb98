//! The console: commands from standard input, executed by a CANopen client of the board.

use std::io::BufRead;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, Sender, TryRecvError};
use std::time::Duration;

use canopen::cia402::{controlword, statusword};
use host_sim::can::client::{Client, ClientError};
use virtual_board::run::{ClientSide, Requests};

use super::Target;
use super::link::VirtualLink;
use crate::can::record;
use crate::error::Error;

/// The node of the emulated board.
const NODE: u8 = 1;

/// A line of the console.
#[derive(Debug, Clone, PartialEq)]
enum Command {
    /// Move to this angle, deg.
    Angle(f64),
    /// Enable operation.
    Enable,
    /// Disable the power stage.
    Disable,
    /// Quick stop.
    Stop,
    /// Reset the faults.
    Acknowledge,
    /// Save the parameters.
    Save,
    /// Begin or end the capture.
    Capture(bool),
    /// Save the capture into this file.
    SaveCapture(PathBuf),
    /// Send servo pulses of this width, us; `None` ends them.
    Servo(Option<f64>),
    /// End the run.
    End,
}

/// Greatest angle, deg.
const GREATEST_DEG: f64 = 180.0;

fn parse(line: &str) -> Result<Command, String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    Ok(match words[..] {
        ["enable"] => Command::Enable,
        ["disable"] => Command::Disable,
        ["stop"] => Command::Stop,
        ["ack"] => Command::Acknowledge,
        ["save"] => Command::Save,
        ["capture", "start"] => Command::Capture(true),
        ["capture", "stop"] => Command::Capture(false),
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
        _ => return Err(format!("`{line}` is not a command")),
    })
}

fn number(word: &str, what: &str, least: f64, most: f64, unit: &str) -> Result<f64, String> {
    let value = word.parse().ok();
    value
        .filter(|value| (least..=most).contains(value))
        .ok_or_else(|| format!("`{word}`: expected {what} {least} to {most} {unit}"))
}

/// Reads lines of standard input until its end.
pub(super) fn read(lines: &Sender<String>) {
    for line in std::io::stdin().lock().lines().map_while(Result::ok) {
        let line = line.trim();
        if !line.is_empty() && lines.send(line.to_owned()).is_err() {
            return;
        }
    }
}

/// Executes the lines until the run ends.
pub(super) fn run(lines: &Receiver<String>, side: ClientSide, target_deg: Target) {
    let requests = side.requests();
    let mut console = Console {
        client: Client::new(Box::new(VirtualLink(side)), NODE),
        requests,
        target_deg,
    };
    // The end of the run ends the link.
    let _ = console.run(lines);
}

struct Console {
    client: Client,
    requests: Requests,
    target_deg: Target,
}

impl Console {
    fn run(&mut self, lines: &Receiver<String>) -> Result<(), Error> {
        self.wait_for_start()?;
        loop {
            match lines.try_recv() {
                Ok(line) => self.line(&line)?,
                Err(TryRecvError::Empty) => self.client.pause(Duration::from_millis(10))?,
                Err(TryRecvError::Disconnected) => self.client.pause(Duration::MAX)?,
            }
        }
    }

    /// Waits until the board has started; earlier lines are executed after that.
    fn wait_for_start(&mut self) -> Result<(), Error> {
        // No bit of the state is set in NOT READY TO SWITCH ON.
        const STATE: u16 = 0x6f;
        loop {
            self.client.pause(Duration::from_millis(10))?;
            if self.client.status().is_ok_and(|status| status & STATE != 0) {
                return Ok(());
            }
        }
    }

    /// Executes a line; an error is reported, and the console continues.
    fn line(&mut self, line: &str) -> Result<(), Error> {
        let command = match parse(line) {
            Ok(command) => command,
            Err(message) => {
                note!("{message}");
                return Ok(());
            }
        };
        if let Err(error) = self.execute(command) {
            note!("error: {error}");
        }
        Ok(())
    }

    fn execute(&mut self, command: Command) -> Result<(), Error> {
        match command {
            Command::Angle(deg) => self.go_to(deg),
            Command::Enable => Ok(self.client.enable(1)?),
            Command::Disable => Ok(self.client.disable()?),
            Command::Stop => Ok(self.client.control(controlword::ENABLE_VOLTAGE)?),
            Command::Acknowledge => Ok(self.client.reset_fault()?),
            Command::Save => Ok(self.client.write("1010:1", SAVE)?),
            Command::Capture(starts) => {
                let value = if starts { "1" } else { "0" };
                Ok(self.client.write("2030:1", value)?)
            }
            Command::SaveCapture(path) => {
                let rows = record::save_capture(&mut self.client, &path)?;
                note!("capture: {}: {rows} records", path.display());
                Ok(())
            }
            Command::Servo(pulse_us) => {
                let set = self.requests.act(move |view| view.set_servo_us(pulse_us));
                Ok(set.map_err(ClientError::from)?)
            }
            Command::End => Ok(self.requests.end().map_err(ClientError::from)?),
        }
    }

    fn go_to(&mut self, deg: f64) -> Result<(), Error> {
        if self.client.status()? & statusword::OPERATION_ENABLED == 0 {
            return Ok(self.client.fail_in_state("type `enable` first")?);
        }
        if let Ok(mut target_deg) = self.target_deg.lock() {
            *target_deg = Some(deg);
        }
        Ok(self.client.move_to((deg * 1e3).round() as i32)?)
    }
}

/// "save", the signature that 1010h expects.
const SAVE: &str = "0x65766173";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_command_or_an_error_with_the_expected_value() {
        assert_eq!(parse("enable"), Ok(Command::Enable));
        assert_eq!(parse("-12.5"), Ok(Command::Angle(-12.5)));
        assert_eq!(parse("servo 1500"), Ok(Command::Servo(Some(1500.0))));
        assert_eq!(parse("servo off"), Ok(Command::Servo(None)));
        assert_eq!(parse("capture start"), Ok(Command::Capture(true)));
        let save = Command::SaveCapture("run.csv".into());
        assert_eq!(parse("capture save run.csv"), Ok(save));
        let error = parse("999").unwrap_err();
        assert_eq!(error, "`999`: expected an angle of -180 to 180 deg");
        assert_eq!(parse("go on"), Err("`go on` is not a command".into()));
    }
}
