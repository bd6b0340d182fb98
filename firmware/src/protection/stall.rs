//! The shaft does not turn while the motor pulls.

use model_core::control::units::Rate;

use super::{Conditions, lasting::Lasting};
use crate::{parameters::integers::integers, timing::periods};

integers! {
    /// What counts as a stall.
    pub struct StallLimits {
        /// Motor current from which on the motor pulls.
        stall_current_ma: 500, "mA", 20, 1640, "two thirds of the stall current of 780 mA";
        /// Rate up to which the shaft stands.
        stall_rate_deg_s: 5, "deg/s", 1, 1000, "a quarter of a count a period";
        /// Time for which it may.
        stall_ms: 500, "ms", 20, 60000, "breaking loose takes less";
    }
}

/// For how long the shaft has stood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct StallGuard(Lasting);

impl StallGuard {
    /// Whether the motor has stalled.
    pub fn check(&mut self, limits: &StallLimits, c: &Conditions<'_>) -> bool {
        // 1 to 1000 deg/s.
        let standing = Rate::from_bits(i64::from(limits.stall_rate_deg_s) << 32);
        let stands = c.rate <= standing && c.rate >= -standing;
        // An angle that is not known says nothing of the rate.
        let is_known = c.measured.travelled.is_some();
        let pulls = c
            .measured
            .current_ma
            .filter(|_| is_known)
            .map(|current_ma| current_ma.abs() >= limits.stall_current_ma);
        let stalls = pulls.map(|pulls| pulls && stands && c.is_driving);
        self.0.update(stalls, periods(limits.stall_ms))
    }
}
