//! The outcome of an experiment.

use serde::{Deserialize, Serialize};

/// Deviation from the undisturbed board that is hazardous, deg, if it lasts.
pub const HAZARD_DEG: f64 = 5.0;

/// Time after which a deviation that is not detected is hazardous, ms, and a shaft that still moves
/// away after a fault was detected.
pub const HAZARD_MS: u32 = 500;

/// Deviations below this are those of two undisturbed runs: a count of the encoder is 0.35 deg.
const NO_EFFECT_DEG: f64 = 1.0;

/// A shaft at this rate or a lower one is at rest, deg/s: it needs more than [`HAZARD_MS`] for
/// half of [`HAZARD_DEG`].
const REST_DEG_S: f64 = 5.0;

/// What an injection led to, from the least to the greatest harm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The shaft moved as that of the undisturbed board, and nothing was detected.
    NoEffect,
    /// The shaft or the reported angle deviated by less than [`HAZARD_DEG`], or for less than
    /// [`HAZARD_MS`].
    Small,
    /// The board has detected a fault or is lost to its master, and the shaft is safe.
    Detected,
    /// The board has restarted, and the shaft is safe.
    Restarted,
    /// A fault was detected, and the shaft coasted for more than [`HAZARD_MS`] afterwards: a program
    /// that does not run cannot brake.
    Coasting,
    /// A fault was detected, and the motor moved the shaft away for more than [`HAZARD_MS`] afterwards.
    Driven,
    /// A deviation of more than [`HAZARD_DEG`] for [`HAZARD_MS`] that nothing detected.
    Hazardous,
    /// The emulator has stopped with an error: not judged.
    Unjudged,
}

impl Outcome {
    /// All outcomes.
    pub const ALL: [Self; 8] = [
        Self::NoEffect,
        Self::Small,
        Self::Detected,
        Self::Restarted,
        Self::Coasting,
        Self::Driven,
        Self::Hazardous,
        Self::Unjudged,
    ];
}

/// An outcome and its times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Verdict {
    /// The outcome.
    pub outcome: Outcome,
    /// Time from the injection until a fault was detected, ms.
    pub detected_ms: Option<u32>,
    /// Time from the injection until the shaft remained safe, ms; 0 if it always was.
    pub safe_ms: u32,
    /// The program counter at an injection into the core, 0 at one into memory.
    pub pc: u32,
}

impl Verdict {
    /// The verdict on an experiment that has ended without a report.
    pub const UNJUDGED: Self = Self {
        outcome: Outcome::Unjudged,
        detected_ms: None,
        safe_ms: 0,
        pc: 0,
    };

    /// The verdict as bytes.
    pub fn to_bytes(self) -> Vec<u8> {
        let detected_ms = self.detected_ms.unwrap_or(u32::MAX);
        let words = [self.outcome as u32, detected_ms, self.safe_ms, self.pc];
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    /// The verdict of these bytes; [`Verdict::UNJUDGED`] if they are none.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        let (words, _) = bytes.as_chunks();
        let words: Vec<u32> = words.iter().copied().map(u32::from_le_bytes).collect();
        let &[outcome, detected_ms, safe_ms, pc] = &words[..] else {
            return Self::UNJUDGED;
        };
        let outcome = Outcome::ALL.get(outcome as usize);
        outcome.map_or(Self::UNJUDGED, |outcome| Self {
            outcome: *outcome,
            detected_ms: (detected_ms != u32::MAX).then_some(detected_ms),
            safe_ms,
            pc,
        })
    }
}

/// The board in a millisecond of an experiment.
#[derive(Debug, Clone, Copy, Default)]
pub struct Observation {
    /// How far the shaft or the reported angle is from where it should be, deg.
    pub deviation_deg: f64,
    /// Rate of the shaft, deg/s.
    pub rate_deg_s: f64,
    /// Whether the bridge drives the motor.
    pub is_driven: bool,
    /// Whether a fault was detected until now.
    pub is_detected: bool,
    /// Whether the board has restarted.
    pub has_restarted: bool,
}

/// Judges an experiment from its injection on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Judge {
    /// Time since the injection, ms.
    ms: u32,
    /// Time for which the deviation has lasted, ms.
    lasting_ms: u32,
    greatest_deg: f64,
    detected_ms: Option<u32>,
    /// Time until the shaft was safe last, ms, and until the motor drove one that was not.
    safe_ms: u32,
    driven_ms: u32,
    is_hazardous: bool,
    has_restarted: bool,
}

impl Judge {
    /// Takes the observation of the time up to `ms` after the injection.
    pub fn update(&mut self, ms: u32, observed: Observation) {
        let step_ms = ms.saturating_sub(self.ms);
        self.ms = ms;
        self.greatest_deg = self.greatest_deg.max(observed.deviation_deg);
        self.has_restarted |= observed.has_restarted;
        if observed.is_detected {
            self.detected_ms.get_or_insert(ms);
        }
        let is_off = observed.deviation_deg > HAZARD_DEG;
        self.lasting_ms = if is_off { self.lasting_ms + step_ms } else { 0 };
        self.is_hazardous |= self.lasting_ms >= HAZARD_MS && self.detected_ms.is_none();
        // Where a fault was detected, a shaft at rest is safe at any angle.
        let is_at_rest = self.detected_ms.is_some() && observed.rate_deg_s.abs() <= REST_DEG_S;
        if is_off && !is_at_rest {
            self.safe_ms = ms;
            if observed.is_driven {
                self.driven_ms = ms;
            }
        }
    }

    /// Time for which a fault has been detected and the shaft is safe, ms; 0 before.
    pub fn detected_and_safe_ms(&self) -> u32 {
        let since_ms = self
            .detected_ms
            .map(|detected_ms| detected_ms.max(self.safe_ms));
        since_ms.map_or(0, |since_ms| self.ms - since_ms)
    }

    /// The verdict on an injection at this program counter.
    pub fn verdict(&self, pc: u32) -> Verdict {
        let outcome = match self.detected_ms {
            _ if self.is_hazardous => Outcome::Hazardous,
            Some(detected_ms) if self.driven_ms > detected_ms + HAZARD_MS => Outcome::Driven,
            Some(detected_ms) if self.safe_ms > detected_ms + HAZARD_MS => Outcome::Coasting,
            Some(_) if self.has_restarted => Outcome::Restarted,
            Some(_) => Outcome::Detected,
            None if self.greatest_deg > NO_EFFECT_DEG => Outcome::Small,
            None => Outcome::NoEffect,
        };
        Verdict {
            outcome,
            detected_ms: self.detected_ms,
            safe_ms: self.safe_ms,
            pc,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEVER: u32 = 2000;

    /// A driven shaft that deviates for a time, at this rate, and a fault that is detected.
    fn judged(deviation_deg: f64, lasts_ms: u32, rate_deg_s: f64, detected_ms: u32) -> Outcome {
        outcome((deviation_deg, lasts_ms), rate_deg_s, detected_ms, true)
    }

    fn outcome(
        (deviation_deg, lasts_ms): (f64, u32),
        rate_deg_s: f64,
        detected_ms: u32,
        is_driven: bool,
    ) -> Outcome {
        let mut judge = Judge::default();
        for ms in 1..=1200 {
            let is_off = ms <= lasts_ms;
            judge.update(
                ms,
                Observation {
                    deviation_deg: if is_off { deviation_deg } else { 0.0 },
                    rate_deg_s,
                    is_driven,
                    is_detected: ms > detected_ms,
                    has_restarted: false,
                },
            );
        }
        judge.verdict(0).outcome
    }

    #[test]
    fn a_lasting_deviation_is_hazardous_unless_it_was_detected_in_time() {
        assert_eq!(judged(6.0, 500, 0.0, NEVER), Outcome::Hazardous);
        assert_eq!(judged(6.0, 1000, 0.0, 500), Outcome::Hazardous);
        assert_eq!(judged(6.0, 1000, 0.0, 499), Outcome::Detected);
        assert_eq!(judged(6.0, 499, 0.0, NEVER), Outcome::Small);
        assert_eq!(judged(4.9, 1000, 0.0, NEVER), Outcome::Small);
        assert_eq!(judged(0.9, 1000, 0.0, NEVER), Outcome::NoEffect);
    }

    #[test]
    fn a_shaft_that_moves_on_long_after_the_fault_was_detected_is_driven_or_coasts() {
        assert_eq!(judged(6.0, 601, 6.0, 100), Outcome::Detected);
        assert_eq!(judged(6.0, 602, 6.0, 100), Outcome::Driven);
        assert_eq!(judged(6.0, 1200, 4.0, 100), Outcome::Detected);
        assert_eq!(outcome((6.0, 602), 6.0, 100, false), Outcome::Coasting);
    }

    #[test]
    fn a_verdict_is_the_same_after_its_way_as_bytes() {
        for outcome in Outcome::ALL {
            for detected_ms in [None, Some(7)] {
                let verdict = Verdict {
                    outcome,
                    detected_ms,
                    safe_ms: 300,
                    pc: 0x0800_8200,
                };
                assert_eq!(Verdict::from_bytes(&verdict.to_bytes()), verdict);
            }
        }
        assert_eq!(Verdict::from_bytes(&[]), Verdict::UNJUDGED);
    }
}
