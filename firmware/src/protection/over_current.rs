//! Too much motor current: the sample in the on time, which is nearest to the peak.

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::CurrentLimits,
    timing::CONTROL_PERIOD_MS,
};

/// For how long it has been too large.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct OverCurrentGuard(Lasting);

impl OverCurrentGuard {
    /// For how many control periods it has been too large.
    pub fn periods(&self) -> u16 {
        self.0.periods()
    }

    /// Whether it is too large.
    pub fn check(&mut self, limits: &CurrentLimits, c: &Conditions<'_>) -> FaultSet {
        let sampled_ma = c.measured.sampled_ma.map(i32::abs);
        let is_over = sampled_ma.map(|sampled_ma| sampled_ma > limits.over_current_ma);
        // 1 to 25.
        let time_ms = limits.over_current_samples * CONTROL_PERIOD_MS;
        let mut present = FaultSet::EMPTY;
        present.put(Fault::OverCurrent, self.0.update(is_over, time_ms));
        present
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::protection::{
        Measured,
        tests::{UNMEASURED, driven, smooth},
    };

    #[test]
    fn an_over_current_is_above_its_limit_in_either_direction_for_its_samples() {
        let limits = CurrentLimits {
            over_current_ma: 1600,
            over_current_samples: 2,
            ..CurrentLimits::DEFAULT
        };
        for (sampled_ma, is_over) in [(1600, false), (1601, true), (-1600, false), (-1601, true)] {
            let measured = Measured {
                sampled_ma: Some(sampled_ma),
                current: smooth(0),
                ..UNMEASURED
            };
            let mut guard = OverCurrentGuard::default();
            let mut check = || guard.check(&limits, &driven(&measured));
            assert!(!check().contains(Fault::OverCurrent));
            assert_eq!(
                check().contains(Fault::OverCurrent),
                is_over,
                "{sampled_ma}"
            );
        }
    }
}
