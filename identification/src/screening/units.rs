//! Units and signs that look wrong: an angle that is the command times a well-known factor.

use crate::recording::Recording;

/// Ratio of angle and command with the explanation that it suggests.
const SUSPICIOUS: [(f64, &str); 7] = [
    (
        std::f64::consts::PI / 180.0,
        "the angle looks like rad where the command is in deg",
    ),
    (
        180.0 / std::f64::consts::PI,
        "the command looks like rad where the angle is in deg",
    ),
    (
        1e-3,
        "the command looks like thousandths of the angle's unit",
    ),
    (
        1e3,
        "the angle looks like thousandths of the command's unit",
    ),
    (
        4096.0 / 360.0,
        "the angle looks like counts of 4096 a turn (unit count12) where the command is in deg",
    ),
    (
        360.0 / 4096.0,
        "the command looks like counts of 4096 a turn (unit count12), or like the microseconds of \
         a pulse, 0.09 deg each, where the angle is in deg",
    ),
    (
        0.18,
        "the command looks like the microseconds of a pulse, 0.18 deg each, where the angle is in \
         deg",
    ),
];

/// Relative distance from a factor within which a gain is suspicious; servos are within a few
/// percent of a gain of one.
const NEAR: f64 = 0.1;

/// What the gain from command to angle suggests; `None` for a plausible one. Without a fitted gain,
/// the ratio of the ranges is used.
///
/// ```
/// use identification::{Recording, screening::suspicion};
/// assert!(suspicion(&Recording::default(), Some(1.02)).is_none());
/// assert!(suspicion(&Recording::default(), Some(-0.98)).unwrap().contains("sign"));
/// assert!(suspicion(&Recording::default(), Some(0.0174)).unwrap().contains("rad"));
/// assert!(suspicion(&Recording::default(), Some(11.4)).unwrap().contains("counts"));
/// assert!(suspicion(&Recording::default(), Some(0.182)).unwrap().contains("microseconds"));
/// ```
pub fn suspicion(recording: &Recording, gain: Option<f64>) -> Option<String> {
    let ranges = || range(&recording.angle_deg) / range(&recording.command_deg);
    // Only the fit determines the sign.
    if let Some(gain) = gain.filter(|gain| (gain.abs() - 1.0).abs() < NEAR && *gain < 0.0) {
        return Some(format!(
            "the gain is {gain:.3}: angle and command have opposite signs"
        ));
    }
    let sizes = [gain.unwrap_or(f64::NAN).abs(), ranges()];
    SUSPICIOUS.into_iter().find_map(|(factor, explanation)| {
        let size = sizes
            .into_iter()
            .find(|s| (s / factor - 1.0).abs() < NEAR)?;
        Some(format!(
            "angle and command have a ratio of {size:.4}: {explanation}"
        ))
    })
}

/// The range without the outermost hundredth on either side.
fn range(values: &[f64]) -> f64 {
    let mut numbers: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    if numbers.is_empty() {
        return f64::NAN;
    }
    let margin = numbers.len() / 100;
    let last = numbers.len() - 1 - margin;
    let high = *numbers.select_nth_unstable_by(last, f64::total_cmp).1;
    let low = *numbers.select_nth_unstable_by(margin, f64::total_cmp).1;
    high - low
}
