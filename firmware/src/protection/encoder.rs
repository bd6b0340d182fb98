//! The encoder: invalid words, implausible jumps, a weak magnet, an angle that does not change.
//!
//! | condition | consequence |
//! |---|---|
//! | no word, odd parity, OCF clear | a lost sample; `lost_samples` more of them than valid ones: [`Fault::EncoderInvalid`] |
//! | COF or LIN set | the same: [`Fault::MagnetLost`] |
//! | a count to which the motor has not turned the encoder ([`super::travel`]) | the same: [`Fault::EncoderJump`] |
//! | MagINC and MagDEC both set for `magnet_weak_ms` | [`Fault::MagnetWeak`] |
//! | MagINC or MagDEC alone | the magnet moves: reported in the telemetry |
//! | no count travelled for `stuck_ms` while the motor is driven hard and takes no current | [`Fault::EncoderStuck`] |
//!
//! This guard decodes the word and decides whether its count is valid. The tracker of the control
//! step knows the distance of a count from the last valid one.
//!
//! A motor that is driven hard and takes less current than it would in a stall turns, or is not
//! connected.

use model_core::control::{
    encoder_word::{EncoderCount, EncoderError, EncoderReading, EncoderWord, Magnet},
    shaft_tracker::ShaftTracker,
    units::Percent,
};

use super::{Conditions, lasting::Lasting, travel::TravelGuard};
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
    /// Lost samples; a valid one makes up for one of them.
    lost: u16,
    /// The cause of the last lost sample.
    cause: Option<Fault>,
    weak: Lasting,
    stuck: Lasting,
    travelled: Option<i32>,
}

impl EncoderGuard {
    /// Decides whether a word has a valid count: one to which the motor has turned the encoder.
    pub fn validate(
        &mut self,
        (limits, is_reversed): (&EncoderLimits, bool),
        word: Option<EncoderWord>,
        shaft: &ShaftTracker,
        travel: &mut TravelGuard,
    ) -> Validated {
        let of_shaft = |counts: i32| if is_reversed { -counts } else { counts };
        let reading = decode(word).and_then(|reading| {
            let travelled = shaft.travel_to(reading.count);
            let is_valid = match travelled.map(of_shaft) {
                Some(way) => travel.accept(way, limits.greatest_rate_deg_s),
                None => {
                    travel.restart();
                    true
                }
            };
            let valid = is_valid.then_some((reading, travelled));
            valid.ok_or(Fault::EncoderJump)
        });
        match reading {
            Ok((EncoderReading { count, magnet }, travelled)) => {
                self.lost = self.lost.saturating_sub(1);
                self.travelled = travelled;
                Validated {
                    count: Some(count),
                    travelled,
                    magnet: Some(magnet),
                }
            }
            Err(cause) => {
                // One more than is tolerated: the first valid ones end the fault.
                if i32::from(self.lost) <= limits.lost_samples {
                    self.lost += 1;
                }
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
        let is_still = self.is_still_and_takes_no_current(limits, c);
        present.put(
            Fault::EncoderStuck,
            self.stuck.update(is_still, limits.stuck_ms),
        );
        present
    }

    fn is_still_and_takes_no_current(
        &self,
        limits: &EncoderLimits,
        c: &Conditions<'_>,
    ) -> Option<bool> {
        if self.travelled? != 0 {
            return Some(false);
        }
        // 5 % to 100 %.
        let hard = Percent::from_bits(i64::from(limits.stuck_duty_pct) << 32);
        let is_driven = c.is_driving && (c.duty >= hard || c.duty <= -hard);
        let pulls = c.measured.current?.mean_ma.abs() >= limits.stuck_current_ma;
        Some(is_driven && !pulls)
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

    /// A shaft whose last valid count was zero.
    fn shaft() -> ShaftTracker {
        let mut shaft = ShaftTracker::default();
        let mounting = Mounting {
            zero: EncoderCount::new(0),
            reversed: false,
        };
        shaft.update(mounting, EncoderCount::new(0));
        shaft
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
            let limits = (&EncoderLimits::DEFAULT, false);
            let mut travel = TravelGuard::default();
            let validated = guard.validate(limits, word, &shaft(), &mut travel);
            assert_eq!((validated.count, validated.magnet), (None, magnet));
        }
    }

    /// Whether an encoder that shows no motion is stuck, of a motor with this duty and current.
    fn is_stuck(is_driving: bool, duty_pct: f64, mean_ma: i32) -> bool {
        let measured = Measured {
            current: smooth(mean_ma),
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
            ..EncoderLimits::DEFAULT
        };
        guard.is_still_and_takes_no_current(&limits, &conditions) == Some(true)
    }

    #[test]
    fn a_motor_that_is_driven_hard_without_its_current_turns() {
        for sign in [1, -1] {
            let duty_pct = 50.0 * f64::from(sign);
            assert!(is_stuck(true, duty_pct, 99 * sign));
            assert!(!is_stuck(true, duty_pct, 100 * sign), "it pulls");
            assert!(!is_stuck(true, 0.99 * duty_pct, 0), "not driven hard");
            assert!(!is_stuck(false, duty_pct, 0), "not driven");
        }
    }
}
