//! The outcome of an experiment.

use serde::{Deserialize, Serialize};

/// Deviation from the undisturbed board that is hazardous, deg, if it lasts.
pub const HAZARD_DEG: f64 = 5.0;

/// Time after which a deviation that is not told is hazardous, ms.
pub const HAZARD_MS: u32 = 500;

/// Deviations below this are those of two undisturbed runs: a count of the encoder is 0.35 deg.
const NO_EFFECT_DEG: f64 = 1.0;

/// What an injection led to, from the least to the greatest harm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The shaft moved as that of the undisturbed board, and nothing was told.
    NoEffect,
    /// The shaft or the reported angle deviated by less than [`HAZARD_DEG`], or for less than
    /// [`HAZARD_MS`].
    Small,
    /// The board has told a fault, has restarted, or is lost to its master.
    Told,
    /// A deviation of more than [`HAZARD_DEG`] for [`HAZARD_MS`] that nothing told.
    Hazardous,
    /// The emulator has stopped with an error: not judged.
    Unjudged,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Self; 5] = [
        Self::NoEffect,
        Self::Small,
        Self::Told,
        Self::Hazardous,
        Self::Unjudged,
    ];
}

/// Judges an experiment from its injection on, millisecond by millisecond.
#[derive(Debug, Clone, Copy, Default)]
pub struct Judge {
    /// Time for which the deviation has lasted, ms.
    lasting_ms: u32,
    greatest_deg: f64,
    is_told: bool,
    is_hazardous: bool,
}

impl Judge {
    /// Takes the deviation of a millisecond, deg, and whether a fault was told until then.
    pub fn update(&mut self, deviation_deg: f64, is_told: bool) {
        self.greatest_deg = self.greatest_deg.max(deviation_deg);
        self.is_told |= is_told;
        self.lasting_ms = if deviation_deg > HAZARD_DEG {
            self.lasting_ms + 1
        } else {
            0
        };
        self.is_hazardous |= self.lasting_ms >= HAZARD_MS && !self.is_told;
    }

    /// The outcome.
    pub fn outcome(&self) -> Outcome {
        match self {
            Self {
                is_hazardous: true, ..
            } => Outcome::Hazardous,
            Self { is_told: true, .. } => Outcome::Told,
            _ if self.greatest_deg > NO_EFFECT_DEG => Outcome::Small,
            _ => Outcome::NoEffect,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(deviation_deg: f64, lasts_ms: u32, told_ms: u32) -> Outcome {
        let mut judge = Judge::default();
        (0..1000).for_each(|ms| {
            let deviation = if ms < lasts_ms { deviation_deg } else { 0.0 };
            judge.update(deviation, ms >= told_ms);
        });
        judge.outcome()
    }

    #[test]
    fn a_lasting_deviation_is_hazardous_unless_it_was_told_in_time() {
        let never = 2000;
        assert_eq!(judged(6.0, 500, never), Outcome::Hazardous);
        assert_eq!(judged(6.0, 1000, 500), Outcome::Hazardous);
        assert_eq!(judged(6.0, 1000, 499), Outcome::Told);
        assert_eq!(judged(6.0, 499, never), Outcome::Small);
        assert_eq!(judged(4.9, 1000, never), Outcome::Small);
        assert_eq!(judged(0.9, 1000, never), Outcome::NoEffect);
    }
}
