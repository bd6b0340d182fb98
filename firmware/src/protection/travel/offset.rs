//! The offset of the back-EMF, learned while the bridge is off and the encoder rests.

use crate::timing::{CONTROL_PERIOD_MS, periods};

/// Rate by which motor and encoder may differ at rest, mdeg/s: 20 mV, eight codes of a leg, of noise
/// and of the supply's influence on the learned offset.
pub(super) const OFFSET_MDEG_S: i32 = 1_000;

/// The same before the offset is learned.
const UNKNOWN_OFFSET_MDEG_S: i32 = 5_000;

/// Time for which the encoder has to rest, with the bridge off, before the offset is learned, ms:
/// two counts in it are 2.9 deg/s.
const RESTING_MS: i32 = 60;

/// Counts within which it rests: noise.
const RESTING_COUNTS: i32 = 2;

/// Greatest offset that is learned, mV.
const GREATEST_MV: i32 = 100;

/// Control periods of which the offset is a mean, 32 ms.
const LEARNED: i32 = periods(32) as i32;

/// The offset.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::protection) struct LegOffset {
    /// In 2^-4 mV, and how often it was learned, up to [`LEARNED`].
    offset: i32,
    learned: i32,
}

impl LegOffset {
    /// One that is learned, zero.
    #[cfg(test)]
    pub const NONE: Self = Self {
        offset: 0,
        learned: LEARNED,
    };

    /// The offset, mV.
    pub fn mv(self) -> i32 {
        self.offset >> 4
    }

    /// The rate by which motor and encoder may differ at rest, mdeg/s.
    pub fn rate_mdeg_s(self) -> i32 {
        if self.learned >= LEARNED {
            OFFSET_MDEG_S
        } else {
            UNKNOWN_OFFSET_MDEG_S
        }
    }

    /// Takes a back-EMF at rest.
    fn take(&mut self, back_emf_mv: i32) {
        let offset = back_emf_mv.clamp(-GREATEST_MV, GREATEST_MV) << 4;
        // The first one, then a share of the difference each time: an eighth at 250 Hz.
        self.offset = match self.learned {
            0 => offset,
            _ => self.offset + ((offset - self.offset) >> LEARNED.ilog2()),
        };
        self.learned = LEARNED.min(self.learned + 1);
    }
}

/// Control periods for which the encoder has rested within its noise, and its way since then.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Resting {
    periods: i32,
    way: i32,
}

impl Resting {
    /// Takes a control period; an encoder that rests teaches the offset.
    pub fn learn(
        &mut self,
        offset: &mut LegOffset,
        is_driving: bool,
        travelled: Option<i32>,
        back_emf_mv: Option<i32>,
    ) {
        let way = travelled.map_or(i32::MAX, |counts| self.way + counts);
        if is_driving || way.clamp(-RESTING_COUNTS, RESTING_COUNTS) != way {
            *self = Self::default();
            return;
        }
        self.way = way;
        self.periods = self.periods.saturating_add(1);
        if let Some(mv) = back_emf_mv.filter(|_| self.periods >= RESTING_MS / CONTROL_PERIOD_MS) {
            offset.take(mv);
        }
    }
}
