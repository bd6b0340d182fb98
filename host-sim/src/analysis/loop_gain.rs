//! Margins and stability of a loop.

use super::frequency::{decibel, search_grid, sign_changes};
use super::linear_models::Loop;
use super::transfer_function::TransferFunction;

/// A margin and its frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// The margin, in dB or deg.
    pub value: f64,
    /// The crossover frequency, Hz.
    pub frequency_hz: f64,
}

/// The stability margins of a loop.
///
/// Of all crossings up to the Nyquist frequency, the margin of smallest magnitude is given. For a
/// stable loop, a positive gain margin is the allowed increase of the gain and a negative one the
/// allowed decrease. The margins of an unstable loop have no meaning: check `stable` first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// Whether all poles of the closed loop are stable.
    pub stable: bool,
    /// Gain margin, dB. `None` if the phase never crosses -180 degrees.
    pub gain_db: Option<Margin>,
    /// Phase margin, deg. `None` if the gain never crosses one.
    pub phase_deg: Option<Margin>,
    /// Delay margin, s: the smallest of all gain crossings.
    pub delay_s: Option<f64>,
}

impl Margins {
    /// Computes the margins of a loop.
    ///
    /// ```
    /// use host_sim::analysis::{linear_models::Loop, loop_gain::Margins};
    /// let defaults = (Default::default(), Default::default(), Default::default());
    /// let board = Loop::sampled(&defaults.0, &defaults.1, &defaults.2).unwrap();
    /// let margins = Margins::of(&board);
    /// assert!(margins.stable);
    /// assert!((margins.phase_deg.unwrap().value - 57.1).abs() < 0.1);
    /// assert!((margins.gain_db.unwrap().value - 20.6).abs() < 0.1);
    /// ```
    pub fn of(servo: &Loop) -> Self {
        let phases = gain_crossings(&servo.open);
        let delays = phases
            .iter()
            .map(|m| m.value.rem_euclid(360.0) / (360.0 * m.frequency_hz));
        Self {
            stable: servo.closed.is_stable(),
            gain_db: smallest(phase_crossings(&servo.open)),
            delay_s: delays.min_by(f64::total_cmp),
            phase_deg: smallest(phases),
        }
    }
}

/// The phase margins at all crossings of gain one.
fn gain_crossings(open: &TransferFunction) -> Vec<Margin> {
    sign_changes(&search_grid(open), |f| open.at(f).norm() - 1.0)
        .map(|frequency_hz| Margin {
            value: (-open.at(frequency_hz)).arg().to_degrees(),
            frequency_hz,
        })
        .collect()
}

/// The gain margins at all crossings of the negative real axis.
fn phase_crossings(open: &TransferFunction) -> Vec<Margin> {
    // At the Nyquist frequency the response of a sampled loop is real without a change of sign.
    let nyquist = Some(open.nyquist_hz()).filter(|f| f.is_finite());
    sign_changes(&search_grid(open), |f| open.at(f).im)
        .chain(nyquist)
        .map(|f| (f, open.at(f)))
        .filter(|(_, value)| value.re < 0.0)
        .map(|(frequency_hz, value)| Margin {
            value: -decibel(value.norm()),
            frequency_hz,
        })
        .collect()
}

fn smallest(margins: Vec<Margin>) -> Option<Margin> {
    margins
        .into_iter()
        .min_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))
}

#[cfg(test)]
#[path = "loop_gain_tests.rs"]
mod tests;
