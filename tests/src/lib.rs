//! Common code of the system tests: the referee's inputs and its recorded rows.

use std::f64::consts::PI;
use std::path::Path;

/// Ticks in one second.
const SECOND: u64 = 20_000;

/// The referee's inputs, by name.
pub const INPUTS: [&str; 6] = ["pulse", "varstep", "ramp", "chirp", "sine", "3211"];

/// The command of the referee's `input` at a tick, deg.
///
/// This follows `referee/reference.py` in floating point and is independent of the integer
/// arithmetic of `model_core::excitation`, so that both can be compared.
///
/// # Panics
/// If there is no such input.
pub fn command(input: &str, tick: u64) -> f64 {
    let t = tick as f64 / SECOND as f64;
    let level = |levels: &[f64], index: u64| levels[index.min(levels.len() as u64 - 1) as usize];
    match input {
        "pulse" if (SECOND..3 * SECOND).contains(&tick) => 90.0,
        "pulse" => 0.0,
        "varstep" => level(&VARIABLE_STEP, tick / (SECOND / 2)),
        "ramp" => interpolated(&RAMP, t),
        // 0.1 to 10 Hz in 20 s: 9.9/40 Hz/s is half the sweep rate.
        "chirp" if tick < 20 * SECOND => 5.0 * (2.0 * PI * (0.1 * t + 9.9 / 40.0 * t * t)).sin(),
        "chirp" => 0.0,
        "sine" => 20.0 * (2.0 * PI * t).sin(),
        "3211" if tick < SECOND => 0.0,
        "3211" => level(&THREE_TWO_ONE_ONE, (tick - SECOND) / 6000),
        _ => panic!("the referee has no input {input}"),
    }
}

/// Levels of half a second each, deg; the last one remains.
const VARIABLE_STEP: [f64; 14] = [
    0.0, 30.0, -20.0, 60.0, -60.0, 90.0, -45.0, 120.0, -120.0, 45.0, 0.0, 10.0, -10.0, 0.0,
];

/// Levels of 0.3 s each, deg; the last one remains.
const THREE_TWO_ONE_ONE: [f64; 8] = [20.0, 20.0, 20.0, -20.0, -20.0, 20.0, -20.0, 0.0];

/// Corners of the ramp, s and deg.
const RAMP: [(f64, f64); 8] = [
    (0.0, 0.0),
    (0.5, 0.0),
    (2.0, 90.0),
    (2.5, 90.0),
    (5.5, -90.0),
    (6.0, -90.0),
    (7.5, 0.0),
    (8.5, 0.0),
];

/// Linear interpolation through `corners` at `t`; after the last one its value.
fn interpolated(corners: &[(f64, f64)], t: f64) -> f64 {
    let after = corners.iter().position(|(t_corner, _)| *t_corner > t);
    match after {
        Some(0) => corners[0].1,
        Some(next) => {
            let ((t0, y0), (t1, y1)) = (corners[next - 1], corners[next]);
            (y1 - y0) / (t1 - t0) * (t - t0) + y0
        }
        None => corners[corners.len() - 1].1,
    }
}

/// A recorded row of the referee.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The tick whose instant it shows.
    pub tick: u64,
    /// Command, deg.
    pub command_deg: f64,
    /// Command after the transport delay, deg.
    pub command_delayed_deg: f64,
    /// True angle, deg.
    pub angle_deg: f64,
    /// True rate, deg/s.
    pub rate_deg_s: f64,
    /// Duty at the motor, %.
    pub duty_pct: f64,
    /// Measured angle, deg; the true one of a model without sensors.
    pub angle_meas_deg: f64,
    /// Measured rate, deg/s; the true one of a model without sensors.
    pub rate_meas_deg_s: f64,
}

/// The referee's rows of a model (`bb1`, `grey-asym`, `fw-pwm` ...) on an input.
///
/// # Panics
/// If the file is missing or does not have the referee's format.
pub fn golden(model: &str, input: &str) -> Vec<Row> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("referee/golden")
        .join(format!("{model}-{input}.csv"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let rows: Vec<Row> = text.lines().skip(1).map(row).collect();
    assert!(!rows.is_empty(), "{} has no rows", path.display());
    rows
}

fn row(line: &str) -> Row {
    let fields: Vec<f64> = line
        .split(',')
        .map(|field| field.parse().unwrap_or_else(|e| panic!("{line}: {e}")))
        .collect();
    Row {
        tick: (fields[0] * SECOND as f64).round() as u64,
        command_deg: fields[1],
        command_delayed_deg: fields[2],
        angle_deg: fields[3],
        rate_deg_s: fields[4],
        duty_pct: fields[5],
        angle_meas_deg: *fields.get(6).unwrap_or(&fields[3]),
        rate_meas_deg_s: *fields.get(7).unwrap_or(&fields[4]),
    }
}

/// Whether `value` agrees with the referee's `printed` value, which has nine digits.
///
/// Nine digits have a relative error of 5e-9; the tolerance is twice that, for the sine of another
/// platform and the order of a sum, plus 1e-9 near zero.
pub fn same_in_print(value: f64, printed: f64) -> bool {
    (value - printed).abs() <= 1e-8 * printed.abs() + 1e-9
}

#[cfg(test)]
mod tests {
    use super::{INPUTS, command, golden, same_in_print};

    #[test]
    fn each_input_agrees_with_the_referee_at_every_recorded_row() {
        for input in INPUTS {
            for row in golden("bb1", input) {
                let ours = command(input, row.tick);
                assert!(same_in_print(ours, row.command_deg), "{input}: {row:?}");
            }
        }
    }

    #[test]
    fn the_recorded_rows_cover_every_phase_of_the_pwm_and_control_periods() {
        for input in INPUTS {
            let rows = golden("fw", input);
            let phases: std::collections::BTreeSet<u64> =
                rows.iter().map(|row| row.tick % 80).collect();
            assert_eq!(phases.len(), 80, "{input}");
        }
    }
}
