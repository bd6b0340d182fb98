//! The encoder: invalid words, implausible jumps, a weak magnet, an angle that does not change.
//!
//! | condition | consequence |
//! |---|---|
//! | no word, odd parity, OCF clear | a lost sample; more than `lost_samples` in a row: [`Fault::EncoderInvalid`] |
//! | COF or LIN set | the same: [`Fault::MagnetLost`] |
//! | a count further from the last valid one than `greatest_rate_deg_s` allows | the same: [`Fault::EncoderJump`] |
//! | MagINC and MagDEC both set for `magnet_weak_ms` | [`Fault::MagnetWeak`] |
//! | MagINC or MagDEC alone | the magnet moves: reported in the telemetry |
//! | no count travelled for `stuck_ms` although the motor turns | [`Fault::EncoderStuck`] |
//!
//! This guard decodes the word and decides whether its count is valid. The tracker of the control
//! step knows the distance of a count from the last valid one and the periods since then.
//!
//! The motor turns if its back-EMF shows it, or if it is driven hard and takes less current than it
//! would in a stall. A motor that is not connected looks the same.

use model_core::{
    control::{
        encoder_word::{EncoderCount, EncoderError, EncoderReading, EncoderWord, Magnet},
        shaft_tracker::ShaftTracker,
        units::Percent,
    },
    time::CONTROL_RATE_HZ,
};

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::EncoderLimits,
};

/// The result of validating a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Validated {
    pub count: Option<EncoderCount>,
    pub travelled: Option<i32>,
    pub magnet: Option<Magnet>,
}

/// The state of the encoder's protection.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct EncoderGuard {
    /// Counts rejected as jumps since the last valid one.
    jumps: u16,
    /// Samples lost in a row.
    lost: u16,
    /// The cause of the last lost sample.
    cause: Option<Fault>,
    weak: Lasting,
    stuck: Lasting,
    travelled: Option<i32>,
}

impl EncoderGuard {
    /// Decides whether a word has a valid count.
    pub fn validate(
        &mut self,
        limits: &EncoderLimits,
        word: Option<EncoderWord>,
        shaft: &ShaftTracker,
    ) -> Validated {
        let reading = decode(word).and_then(|reading| {
            let travelled = shaft.travel_to(reading.count);
            match travelled {
                Some(way) if way.abs() > self.reach(limits, shaft) => Err(Fault::EncoderJump),
                _ => Ok((reading, travelled)),
            }
        });
        match reading {
            Ok((EncoderReading { count, magnet }, travelled)) => {
                (self.jumps, self.lost, self.cause) = (0, 0, None);
                self.travelled = travelled;
                Validated {
                    count: Some(count),
                    travelled,
                    magnet: Some(magnet),
                }
            }
            Err(cause) => {
                self.jumps = self
                    .jumps
                    .saturating_add(u16::from(cause == Fault::EncoderJump));
                self.lost = self.lost.saturating_add(1);
                self.cause = Some(cause);
                self.travelled = None;
                Validated {
                    count: None,
                    travelled: None,
                    magnet: (cause == Fault::MagnetLost).then_some(Magnet::Lost),
                }
            }
        }
    }

    /// Counts that the shaft can have travelled since the last valid count.
    fn reach(&self, limits: &EncoderLimits, shaft: &ShaftTracker) -> i32 {
        // Counts a period of 1 deg/s, in 2^-16. At most 40,000 deg/s are 1821 counts at 250 Hz:
        // within 1821 * 2^16 < 2^27.
        const COUNTS_PER_DEG_S: i32 =
            ((4096 << 16) as f64 / 360.0 / CONTROL_RATE_HZ as f64 + 0.5) as i32;
        let per_period = (limits.greatest_rate_deg_s * COUNTS_PER_DEG_S) >> 16;
        // Rejected jumps do not extend the reach: a jump that persists would soon be within it.
        let periods = i32::from(shaft.missed().saturating_sub(self.jumps)) + 1;
        // At most 65,536 periods: below 2^27.
        (per_period + 1) * periods
    }

    /// The present faults of the encoder.
    pub fn check(&mut self, limits: &EncoderLimits, c: &Conditions<'_>) -> FaultSet {
        let mut present = FaultSet::EMPTY;
        if i32::from(self.lost) > limits.lost_samples {
            present.put(self.cause.unwrap_or(Fault::EncoderInvalid), true);
        }
        let is_marginal = c.measured.magnet.map(|magnet| magnet == Magnet::Marginal);
        present.put(
            Fault::MagnetWeak,
            self.weak.update(is_marginal, limits.magnet_weak_ms),
        );
        let is_still = self.is_still_while_the_motor_turns(limits, c);
        present.put(
            Fault::EncoderStuck,
            self.stuck.update(is_still, limits.stuck_ms),
        );
        present
    }

    fn is_still_while_the_motor_turns(
        &self,
        limits: &EncoderLimits,
        c: &Conditions<'_>,
    ) -> Option<bool> {
        if self.travelled? != 0 {
            return Some(false);
        }
        // Unknown while the diodes carry a large current: then the motor does pull.
        let turns = c.measured.back_emf_mv?.abs() >= limits.stuck_back_emf_mv;
        // 5 % to 100 %.
        let hard = Percent::from_bits(i64::from(limits.stuck_duty_pct) << 32);
        let is_driven = c.is_driving && (c.duty >= hard || c.duty <= -hard);
        let pulls = c.measured.current?.mean_ma.abs() >= limits.stuck_current_ma;
        Some(turns || (is_driven && !pulls))
    }

    /// The loop is closed.
    pub fn restart(&mut self) {
        self.stuck = Lasting::default();
    }
}

/// The reading of a word, or the fault that an invalid one indicates.
fn decode(word: Option<EncoderWord>) -> Result<EncoderReading, Fault> {
    match word.map(EncoderWord::read) {
        Some(Ok(reading)) => Ok(reading),
        Some(Err(EncoderError::CordicOverflow | EncoderError::Linearity)) => Err(Fault::MagnetLost),
        Some(Err(EncoderError::Parity | EncoderError::NotReady)) | None => {
            Err(Fault::EncoderInvalid)
        }
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::{shaft_tracker::Mounting, units::percent};

    use super::*;
    use crate::protection::{
        Measured,
        tests::{UNMEASURED, driven, smooth},
    };

    /// A shaft whose last valid count was zero, some periods before the last one.
    fn shaft(missed: u16) -> ShaftTracker {
        let mut shaft = ShaftTracker::default();
        let mounting = Mounting {
            zero: EncoderCount::new(0),
            reversed: false,
        };
        shaft.update(mounting, EncoderCount::new(0));
        shaft.miss(missed);
        shaft
    }

    #[test]
    fn a_count_is_a_jump_beyond_the_greatest_rate_and_one_count_of_resolution() {
        // 5625 deg/s are 256 counts in 4 ms.
        let limits = EncoderLimits {
            greatest_rate_deg_s: 5625,
            ..EncoderLimits::DEFAULT
        };
        for (missed, reach) in [(0, 257), (1, 2 * 257), (2, 3 * 257)] {
            for sign in [1, -1] {
                let is_valid = |counts: i32| {
                    let count = EncoderCount::new((sign * counts).rem_euclid(4096) as u16);
                    let word = EncoderWord::of(count, Magnet::Steady);
                    let mut guard = EncoderGuard::default();
                    let validated = guard.validate(&limits, Some(word), &shaft(missed));
                    validated.count == Some(count)
                };
                assert!(is_valid(reach), "{reach}");
                assert!(!is_valid(reach + 1), "{reach}");
            }
        }
    }

    #[test]
    fn the_magnet_is_lost_in_a_word_that_says_so_and_unknown_in_any_other_invalid_one() {
        let count = EncoderCount::new(0);
        let lost = EncoderWord::of(count, Magnet::Lost);
        let odd = EncoderWord::new(EncoderWord::of(count, Magnet::Steady).bits() ^ 1);
        let jump = EncoderWord::of(EncoderCount::new(2000), Magnet::Steady);
        for (word, magnet) in [
            (Some(lost), Some(Magnet::Lost)),
            (Some(odd), None),
            (Some(jump), None),
            (None, None),
        ] {
            let mut guard = EncoderGuard::default();
            let validated = guard.validate(&EncoderLimits::DEFAULT, word, &shaft(0));
            assert_eq!((validated.count, validated.magnet), (None, magnet));
        }
    }

    /// Whether an encoder that shows no motion is stuck, of a motor with this duty, current and
    /// back-EMF.
    fn is_stuck(is_driving: bool, duty_pct: f64, mean_ma: i32, back_emf_mv: i32) -> bool {
        let measured = Measured {
            current: smooth(mean_ma),
            back_emf_mv: Some(back_emf_mv),
            ..UNMEASURED
        };
        let conditions = Conditions {
            is_driving,
            duty: percent(duty_pct),
            ..driven(&measured)
        };
        let guard = EncoderGuard {
            travelled: Some(0),
            ..EncoderGuard::default()
        };
        let limits = EncoderLimits {
            stuck_duty_pct: 50,
            stuck_current_ma: 100,
            stuck_back_emf_mv: 800,
            ..EncoderLimits::DEFAULT
        };
        guard.is_still_while_the_motor_turns(&limits, &conditions) == Some(true)
    }

    #[test]
    fn a_motor_that_is_driven_hard_without_its_current_turns() {
        for sign in [1, -1] {
            let duty_pct = 50.0 * f64::from(sign);
            assert!(is_stuck(true, duty_pct, 99 * sign, 0));
            assert!(!is_stuck(true, duty_pct, 100 * sign, 0), "it pulls");
            assert!(!is_stuck(true, 0.99 * duty_pct, 0, 0), "not driven hard");
            assert!(!is_stuck(false, duty_pct, 0, 0), "not driven");
        }
    }

    #[test]
    fn a_motor_with_a_back_emf_turns_whether_it_is_driven_or_not() {
        for sign in [1, -1] {
            assert!(is_stuck(false, 0.0, 0, 800 * sign));
            assert!(is_stuck(true, 50.0, 100, 800 * sign));
            assert!(!is_stuck(false, 0.0, 0, 799 * sign));
        }
    }
}
