//! Margins and stability of a loop.

use super::frequency::{decibel, search_grid, sign_changes};
use super::linear_models::Loop;
use super::transfer_function::TransferFunction;

/// A margin and the frequency at which it is the least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margin {
    /// Its size, in dB or deg.
    pub value: f64,
    /// Where, Hz.
    pub frequency_hz: f64,
}

/// How far a loop is from its limit of stability.
///
/// Every crossing up to the Nyquist frequency is looked at and the margin of least magnitude is
/// given. Of a stable loop a positive gain margin says how far the gain can rise, a negative one how
/// far it can fall; of an unstable loop the signs have no such meaning: ask `stable` first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// Whether the closed loop is stable, by its poles.
    pub stable: bool,
    /// Gain margin, dB, where the phase crosses -180 degrees; `None` where it never does.
    pub gain_db: Option<Margin>,
    /// Phase margin, deg, where the gain crosses one; `None` where it never does.
    pub phase_deg: Option<Margin>,
    /// Delay that a stable loop bears in addition, s: the least of all gain crossings.
    pub delay_s: Option<f64>,
}

impl Margins {
    /// The margins of a loop.
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
            gain_db: least(phase_crossings(&servo.open)),
            delay_s: delays.min_by(f64::total_cmp),
            phase_deg: least(phases),
        }
    }
}

/// Phase margins at every crossing of gain one.
fn gain_crossings(open: &TransferFunction) -> Vec<Margin> {
    sign_changes(&search_grid(open), |f| open.at(f).norm() - 1.0)
        .map(|frequency_hz| Margin {
            value: (-open.at(frequency_hz)).arg().to_degrees(),
            frequency_hz,
        })
        .collect()
}

/// Gain margins at every crossing of the negative real axis.
fn phase_crossings(open: &TransferFunction) -> Vec<Margin> {
    // At the Nyquist frequency a sampled loop is real without a change of sign on the way there.
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

fn least(margins: Vec<Margin>) -> Option<Margin> {
    margins
        .into_iter()
        .min_by(|a, b| a.value.abs().total_cmp(&b.value.abs()))
}

#[cfg(test)]
#[path = "loop_gain_tests.rs"]
mod tests;
