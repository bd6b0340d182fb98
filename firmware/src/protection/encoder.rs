//! The encoder: words that are none, jumps, a weak magnet, an angle that stands still.
//!
//! | condition | becomes |
//! |---|---|
//! | no word, odd parity, OCF clear | a lost sample; more than `lost_samples` in a row: [`Fault::EncoderInvalid`] |
//! | COF or LIN set | the same: [`Fault::MagnetLost`] |
//! | an angle further away than `greatest_rate_deg_s` allows since the last one | the same: [`Fault::EncoderJump`] |
//! | MagINC and MagDEC both set for `magnet_weak_ms` | [`Fault::MagnetWeak`] |
//! | MagINC or MagDEC alone | the magnet moves: told in the telemetry |
//! | no count travelled for `stuck_ms` although the motor turns | [`Fault::EncoderStuck`] |
//!
//! The motor turns where its back-EMF shows it, or where it is driven hard and takes less current
//! than it would at a stall. A motor that is not connected looks the same.

use model_core::control::{
    encoder_word::{COUNTS_PER_TURN, EncoderCount, EncoderError, EncoderWord, Magnet},
    units::Percent,
};

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::EncoderLimits,
};

/// A word without an angle: OCF is clear.
const NO_ANGLE: EncoderWord = EncoderWord::new(0);

/// What is thought of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Judged {
    pub word: EncoderWord,
    pub travelled: Option<i32>,
    pub magnet: Option<Magnet>,
}

/// What is remembered of the encoder.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct EncoderGuard {
    last: Option<EncoderCount>,
    /// Control periods since the last valid word in which there was none, missed ones included.
    away: u16,
    /// Samples lost in a row.
    lost: u16,
    /// Why the last one was.
    cause: Option<Fault>,
    weak: Lasting,
    stuck: Lasting,
    travelled: Option<i32>,
}

impl EncoderGuard {
    /// Decides whether a word serves.
    pub fn judge(
        &mut self,
        limits: &EncoderLimits,
        word: Option<EncoderWord>,
        missed_periods: u8,
    ) -> Judged {
        self.away = self.away.saturating_add(u16::from(missed_periods));
        let reading = match word.map(EncoderWord::read) {
            Some(Ok(reading)) => Ok(reading),
            Some(Err(EncoderError::CordicOverflow | EncoderError::Linearity)) => {
                Err(Fault::MagnetLost)
            }
            Some(Err(EncoderError::Parity | EncoderError::NotReady)) | None => {
                Err(Fault::EncoderInvalid)
            }
        };
        let travelled = reading.map(|reading| self.travelled(reading.count));
        let reading = match (reading, travelled) {
            (Ok(_), Ok(Some(way))) if way.abs() > self.reach(limits) => Err(Fault::EncoderJump),
            (reading, _) => reading,
        };
        match reading {
            Ok(reading) => {
                self.last = Some(reading.count);
                (self.away, self.lost, self.cause) = (0, 0, None);
                self.travelled = travelled.ok().flatten();
                Judged {
                    word: word.unwrap_or(NO_ANGLE),
                    travelled: self.travelled,
                    magnet: Some(reading.magnet),
                }
            }
            Err(cause) => {
                // A word that says too much lets the shaft turn no further than one before it: otherwise
                // a jump that stays would soon be within reach.
                let grows = u16::from(cause != Fault::EncoderJump);
                self.away = self.away.saturating_add(grows);
                self.lost = self.lost.saturating_add(1);
                self.cause = Some(cause);
                self.travelled = None;
                Judged {
                    // One that is no angle by itself says better why.
                    word: match (cause, word) {
                        (Fault::EncoderJump, _) | (_, None) => NO_ANGLE,
                        (_, Some(word)) => word,
                    },
                    travelled: None,
                    magnet: (cause == Fault::MagnetLost).then_some(Magnet::Lost),
                }
            }
        }
    }

    /// Counts from the last valid word to this one, the short way; none without a last one.
    fn travelled(&self, count: EncoderCount) -> Option<i32> {
        let apart = i32::from(count.get()) - i32::from(self.last?.get());
        let half = COUNTS_PER_TURN / 2;
        Some((apart + half).rem_euclid(COUNTS_PER_TURN) - half)
    }

    /// Counts that the shaft can have travelled since the last valid word.
    fn reach(&self, limits: &EncoderLimits) -> i32 {
        // A count a period are 11,250/512 deg/s: 2983/2^16 counts a period per deg/s. At most
        // 40,000 deg/s: 1821 counts, hence within 1821 * 2^16 < 2^27.
        let per_period = (limits.greatest_rate_deg_s * 2983) >> 16;
        // 65,536 periods at the most: below 2^27.
        (per_period + 1) * (i32::from(self.away) + 1)
    }

    /// What is wrong with the encoder.
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
        let stands = self.stands_while_the_motor_turns(limits, c);
        present.put(
            Fault::EncoderStuck,
            self.stuck.update(stands, limits.stuck_ms),
        );
        present
    }

    fn stands_while_the_motor_turns(
        &self,
        limits: &EncoderLimits,
        c: &Conditions<'_>,
    ) -> Option<bool> {
        let stands = self.travelled? == 0;
        if !stands {
            return Some(false);
        }
        let turns = c.measured.back_emf_mv?.abs() >= limits.stuck_back_emf_mv;
        // 5 % to 100 %.
        let hard = Percent::from_bits(i64::from(limits.stuck_duty_pct) << 32);
        let is_driven = c.is_driving && (c.duty >= hard || c.duty <= -hard);
        let pulls = c.measured.current_ma?.abs() >= limits.stuck_current_ma;
        Some(turns || (is_driven && !pulls))
    }

    /// The loop is closed anew.
    pub fn restart(&mut self) {
        self.stuck = Lasting::default();
    }

    /// The next valid word is the first one; words that are lost count on.
    pub fn reset_position(&mut self) {
        (self.last, self.away) = (None, 0);
    }
}
