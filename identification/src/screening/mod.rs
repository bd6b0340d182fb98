//! Finds samples of a recording that are no measurements of the angle, before anything is fitted.
//!
//! Three faults of sensors and links are found from the recorded angle and command alone, without a
//! model: isolated readings ([`Fault::Spike`]), readings that repeat while the shaft moves
//! ([`Fault::Frozen`]), and the motion after a gap in time in which the command changed at an
//! unknown instant ([`Fault::AfterGap`]). Least squares weighs such a sample by its square: three
//! of 1250 decide a fit.
//!
//! Each test compares with the fastest motion of the recording itself and finds nothing where the
//! samples are too far apart to resolve the motion.

mod frozen;
mod gaps;
mod motion;
mod spikes;
mod units;

use std::ops::Range;

use super::recording::Recording;
pub use gaps::GAP_STEPS;
pub(crate) use motion::resolution_deg;
pub use units::suspicion;

/// What is wrong with samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Up to three readings that are off both neighbours by more than any motion of the recording.
    Spike {
        /// Their distance from the neighbours, deg.
        off_deg: f64,
    },
    /// The same reading repeats, and the next one is farther away than the shaft can move between
    /// two samples.
    Frozen {
        /// The distance of the next reading, deg.
        jump_deg: f64,
    },
    /// The response to a change of the command within a gap of the recording.
    AfterGap {
        /// The length of the gap, s.
        gap_s: f64,
    },
}

/// Samples that are no measurements of the angle.
#[derive(Debug, Clone, PartialEq)]
pub struct BadSamples {
    /// Their places in the recording.
    pub samples: Range<usize>,
    /// What is wrong with them.
    pub fault: Fault,
}

impl BadSamples {
    /// What is wrong with them in `recording`, and whether they are compared nevertheless.
    pub fn described(&self, recording: &Recording, is_kept: bool) -> String {
        let count = self.samples.len();
        let first = self.samples.start;
        let angle_deg = recording.angle_deg[first];
        let from_s = recording.time_s[first];
        let to_s = recording.time_s[self.samples.end - 1];
        let what = match self.fault {
            Fault::Spike { off_deg } if count == 1 => format!(
                "the angle of {angle_deg:.3} deg at {from_s:.4} s is {off_deg:.3} deg off both \
                 neighbours, more than the shaft can move: a bad reading"
            ),
            Fault::Spike { off_deg } => format!(
                "{count} angles from {angle_deg:.3} deg at {from_s:.4} s are {off_deg:.3} deg off \
                 both neighbours, more than the shaft can move: bad readings"
            ),
            Fault::Frozen { jump_deg } => format!(
                "{count} angles from {from_s:.4} s to {to_s:.4} s repeat {angle_deg:.3} deg while \
                 the shaft moves, and the next one is {jump_deg:.3} deg away: frozen readings"
            ),
            Fault::AfterGap { gap_s } => format!(
                "the command changes within the gap of {gap_s:.4} s before this line, at an \
                 unknown instant: the {count} samples of the response, until {to_s:.4} s"
            ),
        };
        let consequence = if is_kept {
            "compared nevertheless"
        } else {
            "not compared; --keep-bad compares them"
        };
        format!("{what}; {consequence}")
    }
}

/// All bad samples of a recording, in its order.
///
/// ```
/// use identification::{Recording, screening};
///
/// let mut run = Recording {
///     time_s: (0..100).map(|i| f64::from(i) * 0.01).collect(),
///     command_deg: vec![90.0; 100],
///     angle_deg: (0..100).map(f64::from).collect(),
///     ..Recording::default()
/// };
/// assert!(screening::bad_samples(&run).is_empty());
/// run.angle_deg[60] = 0.0;
/// assert_eq!(screening::bad_samples(&run)[0].samples, 60..61);
/// ```
pub fn bad_samples(recording: &Recording) -> Vec<BadSamples> {
    let mut present: Vec<usize> = (0..recording.len())
        .filter(|&i| recording.angle_deg[i].is_finite())
        .collect();
    let (mut bad, motion) = spikes::find(recording, &mut present);
    bad.extend(frozen::find(recording, &present, &motion));
    bad.extend(gaps::find(recording, &motion));
    bad.sort_by_key(|b| b.samples.start);
    bad
}

/// Marks these samples as missing: the model bridges them by its command.
pub fn leave_out(recording: &mut Recording, bad: &[BadSamples]) {
    for BadSamples { samples, .. } in bad {
        recording.angle_deg[samples.clone()].fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests;
