//! The encoder's travel against the motor's, by the back-EMF.
//!
//! The motor is rigidly geared to the encoder's magnet. A magnet that slips, an encoder that
//! drifts, repeats its word or counts too little differ from the motor:
//!
//! ```text
//! expected = sum of (rate of this back-EMF + rate of the one before)/2 T
//! residual = travelled - expected
//! above    = max(0, above + residual - allowance)         below likewise with -residual
//! ```
//!
//! The allowance of each sum follows from the direction of the motor alone: a residual of single
//! counts changes its sign at low rates, and its mean does not.
//!
//! What an intact drive contributes to the residual, at the shaft:
//!
//! | cause | deg | allowed for by |
//! |---|---|---|
//! | the constant of the back-EMF | a share of the travel | `constant.rs` |
//! | offset of the legs: resistors of 1 % are 80 mV at 6 V | 4 deg/s | `OFFSET_MDEG_S` |
//! | encoder: two counts, and 384 us of delay at 400 deg/s | 0.33 | `LIMIT_MDEG` |
//! | play of the gears | 1 | `LIMIT_MDEG` |
//! | a stop within a period from 400 deg/s: half of its travel | 0.8 | `LIMIT_MDEG` |
//!
//! In a gap of the back-EMF (`motor.rs`) a count is accepted within what the motor can do, and the
//! counts of a short gap are compared behind it.
//!
//! A motor whose constant is 30 % too low turns at 400 deg/s. The offset is learned at rest
//! (`offset.rs`); before, `UNKNOWN_OFFSET_MDEG_S` counts. The last three are within 2.13 deg
//! together. A single count that is further off than `WINDOW_MDEG` is rejected, and does not move
//! the shaft: of an intact drive only one that a load stops as it crosses the play, and it is
//! accepted when the motor has followed. A drift of `d` above the allowance `a` is detected after
//! `LIMIT/(d - a)`.
//!
//! In motion the allowance for the constant hides a drift. But the error of a constant comes and
//! goes with the travel, and a drift does not: with the same leak, sums of both have the ratio of
//! the error,
//!
//! ```text
//! drift  = drift  (1 - 1/LEAK) + residual
//! motion = motion (1 - 1/LEAK) + expected       |drift| <= tolerance |motion| + LIMIT + offset
//! ```
//!
//! where the offset has added up to `OFFSET_MDEG_S` times the 2 s of the leak.

mod constant;
mod motor;
mod offset;

use model_core::time::CONTROL_RATE_HZ;

use crate::{
    faults::{Fault, FaultSet},
    measure::MotorConstants,
    timing::periods,
};
use constant::ConstantError;
use motor::MotorTravel;
pub(super) use offset::LegOffset;
use offset::{OFFSET_MDEG_S, Resting};

/// Distances are in parts of a mdeg: a rate of 1 mdeg/s adds one in 4 ms.
const MDEG: i32 = 250;

/// The distance of a rate, mdeg/s, in a control period.
const fn per_period(rate_mdeg_s: i32) -> i32 {
    const PARTS: i32 = CONTROL_RATE_HZ as i32 / MDEG;
    rate_mdeg_s / PARTS
}

const _: () = assert!(CONTROL_RATE_HZ.is_multiple_of(MDEG as u32));

/// A count.
const COUNT: i32 = (360_000.0 / 4096.0 * MDEG as f64 + 0.5) as i32;

/// Sum of the residual at which the encoder is implausible.
const LIMIT_MDEG: i32 = 2_200;

/// Residual of a single count that is accepted.
const WINDOW_MDEG: i32 = 1_900;

/// Sum of the residual that play, encoder and half of a stop do not explain: less than the limit,
/// so that a wrong polarity is reported before an implausible encoder.
const BEYOND_PLAY_MDEG: i32 = 2_000;

/// Control periods after which a drift of 20 deg/s is detected.
pub const AT_20_DEG_S_PERIODS: i32 = LIMIT_MDEG * MDEG / per_period(20_000 - OFFSET_MDEG_S) + 1;

/// Comparisons without a count of travel after which an implausible encoder is stuck.
const STILL: u8 = 3;

/// Control periods of the leak, 2.05 s, as a power of two: 9 at 250 Hz.
const LEAK: u32 = periods(2_050).ilog2();

/// The state of the comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TravelGuard {
    motor: MotorTravel,
    offset: LegOffset,
    resting: Resting,
    /// Counts since the last comparison that were accepted in a gap.
    held: i32,
    above: i32,
    below: i32,
    /// Leaky sums of the residual and of the motor's travel.
    drift: i32,
    motion: i32,
    /// Comparisons since the encoder has turned.
    still: u8,
    constant: ConstantError,
}

impl TravelGuard {
    /// A control period, after so many that did not run, in the direction of the shaft. Returns by
    /// how much the motor's rate has changed since the last one, mdeg/s at the shaft, if that is
    /// known.
    pub fn advance(
        &mut self,
        motor: &MotorConstants,
        back_emf_mv: Option<i32>,
        missed: u8,
    ) -> Option<i32> {
        let rate = back_emf_mv.map(|mv| motor.rate_mdeg_s(mv - self.offset.mv()));
        self.motor.advance(rate, missed)
    }

    /// The same in a control period that has the back-EMF of the last one.
    pub fn hold(&mut self, missed: u8) -> Option<i32> {
        self.motor.hold(missed)
    }

    /// Takes a count this far from the last valid one, unless the motor has not turned the encoder
    /// there; returns whether it is valid. Where the motor's travel is not known, it is at most
    /// that of `greatest_rate_deg_s`.
    pub fn accept(&mut self, travelled: i32, greatest_rate_deg_s: i32) -> bool {
        // Half of a turn, and for each count of a short gap: 2^29.
        let way = travelled + self.held;
        let residual = way * COUNT - self.motor.expected_now();
        let (above, below) = self.allowances();
        let allowance = if residual > 0 { above } else { below };
        let window = WINDOW_MDEG * MDEG + allowance;
        if residual.abs() > window && self.rejects(residual, window, greatest_rate_deg_s) {
            return false;
        }
        if self.motor.is_in_short_gap() {
            // It is compared with the next scan.
            self.held = way;
            return true;
        }
        // There is no comparison without the motor's travel.
        if self.motor.is_known() {
            self.above = next(self.above, residual - above);
            self.below = next(self.below, -residual - below);
            // The motor's is at most 2^21 mdeg/s for the leak, 2^30; that of accepted residuals
            // less.
            self.drift += residual - (self.drift >> LEAK) * self.motor.periods;
            self.motion += self.motor.expected - (self.motion >> LEAK) * self.motor.periods;
            self.constant.learn(self.drift, self.motion);
            self.still = match way {
                0 => self.still.saturating_add(1),
                _ => 0,
            };
        }
        self.motor.begin();
        self.held = 0;
        true
    }

    /// Whether a count with this residual is rejected. Counts of a gap have been accepted: it is one
    /// that is itself beyond the window.
    #[inline(never)]
    fn rejects(&self, residual: i32, window: i32, greatest_rate_deg_s: i32) -> bool {
        // At most 40,000 deg/s: 2^31 for 212 ms.
        let blind = per_period(greatest_rate_deg_s * 1000) * self.motor.blind_periods();
        let own = residual - self.held * COUNT;
        residual.abs().min(own.abs()) > window + blind
    }

    /// The position is not known: the next count is the first one.
    pub fn restart(&mut self) {
        *self = Self {
            motor: self.motor.restarted(),
            offset: self.offset,
            constant: self.constant,
            ..Self::default()
        };
    }

    /// What was learned of the offset of the back-EMF.
    pub fn learned_offset(&self) -> LegOffset {
        self.offset
    }

    /// Continues with an offset that was learned.
    pub fn continue_with(&mut self, offset: LegOffset) {
        self.offset = offset;
    }

    /// Learns the offset of the back-EMF while the bridge is off and the encoder rests.
    pub fn learn(&mut self, is_driving: bool, travelled: Option<i32>, back_emf_mv: Option<i32>) {
        (self.resting).learn(&mut self.offset, is_driving, travelled, back_emf_mv);
    }

    /// The constants of the motor are others.
    pub fn forget_constant(&mut self) {
        self.constant = ConstantError::default();
    }

    /// The fault of an encoder that differs from the motor.
    pub fn check(&self) -> FaultSet {
        let mut present = FaultSet::EMPTY;
        let limit = LIMIT_MDEG * MDEG;
        let is_implausible = self.above >= limit || self.below >= limit || self.drifts();
        let is_still = self.still >= STILL;
        present.put(Fault::EncoderStuck, is_implausible && is_still);
        present.put(Fault::EncoderImplausible, is_implausible && !is_still);
        present
    }

    /// Whether the encoder has drifted by more than an error of the constant explains.
    #[inline(always)]
    fn drifts(&self) -> bool {
        self.drift.abs() > least_drift(OFFSET_MDEG_S) && self.drifts_beyond_tolerance()
    }

    #[inline(never)]
    fn drifts_beyond_tolerance(&self) -> bool {
        let least = least_drift(self.offset.rate_mdeg_s());
        let (above, below) = self.constant.tolerances(self.motion);
        self.drift > least + above || -self.drift > least + below
    }

    /// Whether encoder and motor are further apart than the play of the gears permits.
    pub fn is_beyond_play(&self) -> bool {
        self.above.max(self.below) >= BEYOND_PLAY_MDEG * MDEG
    }

    /// What an intact drive may contribute to a positive and to a negative residual.
    fn allowances(&self) -> (i32, i32) {
        let offset = per_period(self.offset.rate_mdeg_s()) * self.motor.periods;
        let (above, below) = self.constant.tolerances(self.motor.expected);
        (above + offset, below + offset)
    }
}

/// The sum of the residual with this offset alone, and the limit.
const fn least_drift(offset_mdeg_s: i32) -> i32 {
    LIMIT_MDEG * MDEG + per_period(offset_mdeg_s) * (1 << LEAK)
}

/// The next value of a sum. It ends at twice its limit, so that it falls again in time.
fn next(sum: i32, excess: i32) -> i32 {
    (sum + excess).clamp(0, 2 * LIMIT_MDEG * MDEG)
}

#[cfg(test)]
mod tests;
