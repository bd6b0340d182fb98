//! The measured loop against the predicted one.

use std::f64::consts::TAU;

use model_core::control::encoder_word::COUNT_DEG;
use model_core::parameter::ParameterError;

use super::super::comparison::Comparison;
use super::Margins;
use super::design::Identified;
use super::response::{LINES, Multisine, Response};
use super::twin::{DELAY_S, Record, Twin};
use crate::analysis::frequency::decibel;
use crate::analysis::linear_models::Timing;

/// Largest difference of the margins: the promise of the prediction.
pub const PHASE_DEG: f64 = 2.0;
pub const GAIN_DB: f64 = 1.0;

/// A gain that differs by [`GAIN_DB`], as a factor.
const FACTOR: f64 = 1.122;

/// Greatest standard error of a line that verifies: three of them are less than a third.
const NOISE: f64 = 0.1;

/// A line of the sweep.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub struct Line {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Gain from command to angle, dB: measured, and predicted.
    pub gain_db: [f64; 2],
    /// Its phase, deg, likewise.
    pub phase_deg: [f64; 2],
    /// The motor's measured response by the predicted one: gain, dB, and phase, deg.
    pub motor: [f64; 2],
    /// Relative standard error of the motor's measured response.
    pub motor_error: f64,
}

/// Compares the lines.
pub fn lines(sine: &Multisine, measured: &Response, predicted: &Response) -> [Line; LINES] {
    std::array::from_fn(|line| {
        let of = [measured.closed[line], predicted.closed[line]];
        let ratio = measured.motor[line] / predicted.motor[line];
        Line {
            frequency_hz: sine.line_hz(line),
            gain_db: of.map(|value| decibel(value.norm())),
            phase_deg: of.map(|value| value.arg().to_degrees()),
            motor: [decibel(ratio.norm()), ratio.arg().to_degrees()],
            motor_error: measured.motor_errors[line],
        }
    })
}

/// The margins with the motor as it was measured: its gain and its delay differ from those of the
/// prediction as they do at the lines from half of the crossing on.
///
/// The error of a line, from three periods, is off by a half itself: half of the variance of each
/// weight is the mean one, so that no line decides alone by a small scatter.
pub fn margins(
    identified: &Identified,
    twin: &Twin,
    lines: &[Line],
    crossing_hz: f64,
) -> Option<Margins> {
    let near: Vec<_> = lines
        .iter()
        .filter(|line| line.frequency_hz >= crossing_hz / 2.0)
        .collect();
    let squares = near.iter().map(|line| line.motor_error.powi(2));
    let mean_variance = squares.sum::<f64>() / near.len() as f64;
    // Gain in dB, and delay: means weighted by the errors of the lines.
    let mut sums = [(0.0, 0.0); 2];
    for line in near {
        let weight = 1.0 / (line.motor_error.powi(2) + mean_variance);
        let rad_s = TAU * line.frequency_hz;
        sums[0].0 += weight * line.motor[0];
        sums[0].1 += weight;
        sums[1].0 -= weight * rad_s * line.motor[1].to_radians();
        sums[1].1 += weight * rad_s * rad_s;
    }
    let [gain_db, delay_s] = sums.map(|(products, squares)| products / squares);
    let mut motor = identified.motor([0.0; 5]);
    motor.motor_gain *= 10.0_f64.powf(gain_db / 20.0);
    let timing = Timing {
        duty_delay_s: (DELAY_S + delay_s).max(0.0),
        ..Timing::default()
    };
    Margins::of(&motor, &twin.control, &timing)
}

/// What disagrees in a sweep.
pub fn of_sweep(lines: &[Line], predicted: &Margins, measured: Option<&Margins>) -> Vec<String> {
    let mut found = Vec::new();
    for line in lines {
        let (gain_db, phase_deg) = (
            line.gain_db[0] - line.gain_db[1],
            (line.phase_deg[0] - line.phase_deg[1] + 180.0).rem_euclid(360.0) - 180.0,
        );
        let ratio = 10.0_f64.powf(gain_db / 20.0);
        let angle = phase_deg.to_radians();
        let distance = (ratio * angle.cos() - 1.0).hypot(ratio * angle.sin());
        // Not true for NaN either. A line that is mostly noise verifies nothing.
        let agrees = distance <= FACTOR - 1.0 + 3.0 * line.motor_error;
        if !agrees || line.motor_error > NOISE {
            found.push(format!(
                "response at {:.2} Hz: {:.2} dB and {:.1} deg, predicted {:.2} dB and {:.1} deg, \
                 expected a difference of 12 % at most",
                line.frequency_hz,
                line.gain_db[0],
                line.phase_deg[0],
                line.gain_db[1],
                line.phase_deg[1]
            ));
        }
    }
    let Some(measured) = measured else {
        found.push("the loop with the measured motor has no margins".into());
        return found;
    };
    let differences = [
        (
            "phase margin",
            "deg",
            measured.phase_deg,
            predicted.phase_deg,
            PHASE_DEG,
        ),
        (
            "gain margin",
            "dB",
            measured.gain_db,
            predicted.gain_db,
            GAIN_DB,
        ),
    ];
    for (name, unit, measured, predicted, most) in differences {
        // Not true for NaN either.
        let agrees = (measured - predicted).abs() <= most;
        if !agrees {
            found.push(format!(
                "{name}: {measured:.1} {unit} by the sweep, predicted {predicted:.1} {unit}, \
                 expected a difference of {most:.0} {unit} at most"
            ));
        }
    }
    found
}

/// A motion: rms difference between measured and predicted angle, and the largest one expected.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Motion {
    /// Rms difference of the angles, deg.
    pub difference_deg: f64,
    /// The largest one expected, deg: that of an inertia which is greater by 1 dB, a count of the
    /// encoder, and half of the play, within which the shaft may rest.
    pub limit_deg: f64,
    /// Rms difference of angle and command, deg.
    pub error_deg: f64,
    /// The angles.
    #[serde(skip)]
    pub comparison: Comparison,
}

impl Motion {
    /// Of a recorded motion, from the first change of its command on.
    pub fn of(records: &[Record], twin: &Twin) -> Result<Self, ParameterError> {
        let predicted = twin.follow(records)?;
        let play_deg = twin.plant.drivetrain.gear_train.backlash_deg;
        let mut heavier = twin.clone();
        heavier.plant.drivetrain.gear_train.motor_inertia_kg_m2 *= FACTOR;
        let other = heavier.follow(records)?;
        let command = |record: &Record| f64::from(record.command_mdeg) * 1e-3;
        let start = start(records);
        let (records, predicted, other) = (&records[start..], &predicted[start..], &other[start..]);
        let error = records
            .iter()
            .map(|record| record.angle_deg - command(record));
        Ok(Self {
            difference_deg: rms(differences(records, predicted)),
            limit_deg: rms(differences(other, predicted)) + COUNT_DEG + play_deg / 2.0,
            error_deg: rms(error),
            comparison: Comparison {
                command_deg: records.iter().map(command).collect(),
                measured_deg: angles(records),
                predicted_deg: angles(predicted),
            },
        })
    }

    /// Why it disagrees, if it does.
    pub fn disagreement(&self, name: &str) -> Option<String> {
        // Not true for NaN either.
        let agrees = self.difference_deg <= self.limit_deg;
        (!agrees).then(|| {
            format!(
                "{name}: {:.3} deg rms between measured and predicted angle, expected {:.3} deg at \
                 most",
                self.difference_deg, self.limit_deg
            )
        })
    }
}

fn angles(records: &[Record]) -> Vec<f64> {
    records.iter().map(|record| record.angle_deg).collect()
}

/// The place of the first change of the command.
pub fn start(records: &[Record]) -> usize {
    let changes = |pair: &[Record]| pair[0].command_mdeg != pair[1].command_mdeg;
    records
        .windows(2)
        .position(changes)
        .map_or(0, |place| place + 1)
}

fn differences(one: &[Record], other: &[Record]) -> impl Iterator<Item = f64> {
    one.iter()
        .zip(other)
        .map(|(a, b)| a.angle_deg - b.angle_deg)
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| {
        (count + 1.0, sum + value * value)
    });
    (sum / count).sqrt()
}
