//! `actuator monitor`: live telemetry of an actuator.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::io::IsTerminal;
use std::sync::atomic::Ordering;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::{AtNode, length, print_json, servo::Servo, telemetry::watch};
use crate::error::Error;
use crate::interrupt;
use crate::output::print;
use host_sim::can::client::state_name;
use host_sim::can::telemetry::Telemetry;

/// Shows angle, rate, current, back-EMF, duty, state and faults of an actuator
///
/// Of a servo: goal, angle, rate, duty, current, supply, temperature and errors.
/// On a terminal as curves of the last seconds, updated ten times a second; otherwise, and with
/// --json, as lines.
#[derive(Debug, Args)]
pub struct Monitor {
    /// Duration, s [default: until an interrupt (Ctrl-C)]
    #[arg(long = "for", value_name = "SECONDS")]
    seconds: Option<f64>,
    #[command(flatten)]
    at: AtNode,
}

/// Quantities: prefix of the name of the column, label, and least span of the curve.
type Quantities = &'static [(&'static str, &'static str, f64)];

/// Those of an actuator.
const OF_ACTUATOR: Quantities = &[
    ("angle", "angle     deg", 1.0),
    ("angular_rate", "rate    deg/s", 10.0),
    ("motor_current", "current    mA", 50.0),
    ("back_emf", "back-EMF   mV", 100.0),
    ("motor_duty", "duty        %", 5.0),
];

/// Those of a servo.
const OF_SERVO: Quantities = &[
    ("command_deg", "command   deg", 1.0),
    ("angle_deg", "angle     deg", 1.0),
    ("rate_deg_s", "rate    deg/s", 10.0),
    ("duty_pct", "duty        %", 5.0),
    ("current_ma", "current    mA", 50.0),
    ("supply_mv", "supply     mV", 200.0),
];

/// Points of a curve.
const WIDTH: usize = 60;

/// Time between two updates.
const EVERY: Duration = Duration::from_millis(100);

impl Monitor {
    /// Shows the telemetry.
    ///
    /// # Errors
    /// Those of the bus and the actuator.
    pub fn run(&self) -> Result<(), Error> {
        let time = self.seconds.map(|seconds| length("--for", seconds));
        let time = time.transpose()?;
        let stop = interrupt::stop()?;
        let is_over = |now| stop.load(Ordering::Relaxed) || time.is_some_and(|time| now >= time);
        if let Some(mut node) = self.at.drone()? {
            return node.monitor(is_over, self.at.json());
        }
        let is_terminal = std::io::stdout().is_terminal();
        if let Some(mut servo) = self.at.servo()? {
            return self.show_servo(&mut servo, is_over, Screen::new(is_terminal, OF_SERVO));
        }
        let mut client = self.at.open()?;
        let mut screen = Screen::new(is_terminal, OF_ACTUATOR);
        let mut next = Duration::ZERO;
        watch(&mut client, is_over, |telemetry, now| {
            if now >= next {
                next = now + EVERY;
                if self.at.json() {
                    print_json(&record(telemetry, now))?;
                } else {
                    let value = |name: &str| telemetry.value(name);
                    print(&screen.picture(value, &state(telemetry)))?;
                }
            }
            Ok(())
        })
    }

    fn show_servo(
        &self,
        servo: &mut Servo,
        is_over: impl Fn(Duration) -> bool,
        mut screen: Screen,
    ) -> Result<(), Error> {
        let names: Vec<_> = servo.measured().collect();
        let mut next = Duration::ZERO;
        servo.watch(is_over, |servo, now, values| {
            if now < next {
                return Ok(());
            }
            next = now + EVERY;
            let state = servo.state()?;
            let named = || names.iter().copied().zip(values.iter().copied());
            if self.at.json() {
                let values = named().map(|(name, value)| (name.to_owned(), json!(value)));
                let mut object: serde_json::Map<_, _> = values.collect();
                object.insert("time_s".into(), json!(now.as_secs_f64()));
                object.insert("state".into(), json!(state));
                return print_json(&object.into());
            }
            let value = |name: &str| named().find(|(of, _)| *of == name).map(|(_, value)| value);
            print(&screen.picture(value, &state))
        })?;
        Ok(())
    }
}

fn record(telemetry: &Telemetry, now: Duration) -> serde_json::Value {
    let columns = telemetry.columns.iter().zip(telemetry.values());
    let mut object: serde_json::Map<_, _> = columns
        .map(|(column, value)| (column.name.clone(), json!(value)))
        .collect();
    object.insert("time_s".into(), json!(now.as_secs_f64()));
    object.into()
}

/// The state, with the error code if there is one.
fn state(telemetry: &Telemetry) -> String {
    let status = telemetry.value("statusword");
    let state = status.map_or("unknown", |status| state_name(status as u16));
    match telemetry.value("error_code") {
        Some(code) if code != 0.0 => format!("{state}, error code {:04X}h", code as u16),
        _ => state.to_owned(),
    }
}

/// The curves.
struct Screen {
    is_terminal: bool,
    quantities: Quantities,
    curves: Vec<VecDeque<f64>>,
    is_drawn: bool,
}

impl Screen {
    fn new(is_terminal: bool, quantities: Quantities) -> Self {
        Self {
            is_terminal,
            quantities,
            curves: vec![VecDeque::new(); quantities.len()],
            is_drawn: false,
        }
    }

    fn picture(&mut self, value: impl Fn(&str) -> Option<f64>, state: &str) -> String {
        let mut text = String::new();
        if self.is_terminal && self.is_drawn {
            // Moves the cursor to the first line of the curves.
            let _ = write!(text, "\x1b[{}A", self.quantities.len() + 1);
        }
        self.is_drawn = true;
        for ((name, label, span), curve) in self.quantities.iter().zip(&mut self.curves) {
            let value = value(name).unwrap_or(f64::NAN);
            if self.is_terminal {
                curve.push_back(value);
                curve.drain(..curve.len().saturating_sub(WIDTH));
                let _ = writeln!(text, "{label} {value:>10.2} {}\x1b[K", sparks(curve, *span));
            } else {
                let label: Vec<_> = label.split_whitespace().collect();
                let _ = write!(text, "{} {value:.2} {}  ", label[0], label[1]);
            }
        }
        let erase = if self.is_terminal { "\x1b[K" } else { "" };
        let _ = writeln!(text, "{state}{erase}");
        text
    }
}

/// A curve in eighths of the height of a line, over its range or the least span.
fn sparks(curve: &VecDeque<f64>, span: f64) -> String {
    const EIGHTHS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    let known = || curve.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (
        known().fold(f64::INFINITY, f64::min),
        known().fold(f64::NEG_INFINITY, f64::max),
    );
    let middle = (low + high) / 2.0;
    let half = ((high - low) / 2.0).max(span / 2.0);
    let spark = |value: &f64| {
        let share = (value - middle) / (2.0 * half) + 0.5;
        let eighth = (share * 7.0).round().clamp(0.0, 7.0);
        if eighth.is_finite() {
            EIGHTHS[eighth as usize]
        } else {
            ' '
        }
    };
    curve.iter().map(spark).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_uses_its_height_but_noise_stays_flat() {
        let curve = VecDeque::from([-10.0, 0.0, 10.0, f64::NAN]);
        assert_eq!(sparks(&curve, 1.0), "▁▅█ ");
        let noise = VecDeque::from([0.0, 0.01, 0.0]);
        assert_eq!(sparks(&noise, 1.0), "▄▅▄");
    }
}
