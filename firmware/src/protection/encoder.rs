//! The encoder: invalid words, implausible jumps, a weak magnet.
//!
//! | condition | consequence |
//! |---|---|
//! | no word, odd parity, OCF clear | a lost sample; `lost_samples` more of them than valid ones: [`Fault::EncoderInvalid`] |
//! | COF or LIN set | the same: [`Fault::MagnetLost`] |
//! | a count to which the motor has not turned the encoder ([`super::travel`]) | the same: [`Fault::EncoderJump`] |
//! | MagINC and MagDEC both set for `magnet_weak_ms` | [`Fault::MagnetWeak`] |
//! | MagINC or MagDEC alone | the magnet moves: reported in the telemetry |
//!
//! This guard decodes the word and decides whether its count is valid. The tracker of the control
//! step knows the distance of a count from the last valid one. An angle that does not change
//! although the motor turns is found by the comparison of the travels.

use model_core::control::{
    encoder_word::{EncoderCount, EncoderError, EncoderReading, EncoderWord, Magnet},
    shaft_tracker::ShaftTracker,
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
                Validated {
                    count: None,
                    travelled: None,
                    magnet: (cause == Fault::MagnetLost).then_some(Magnet::Lost),
                }
            }
        }
    }

    /// Lost samples, less the valid ones after them.
    pub fn lost_samples(&self) -> u16 {
        self.lost
    }

    /// For how many control periods the magnet has been weak.
    pub fn weak_periods(&self) -> u16 {
        self.weak.periods()
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
        present
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
    use model_core::control::shaft_tracker::Mounting;

    use super::*;
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
}
