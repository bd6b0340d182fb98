//! Control periods that were missed, and measurements that do not come.

use model_core::time::CONTROL_RATE_HZ;

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::TimingLimits,
};

/// Good control periods that make up for a missed one: a second of them.
const GOOD_PERIODS: u16 = CONTROL_RATE_HZ as u16;

/// Time without a back-EMF of a driven motor, where no diode explains that: during a reversal, or
/// while a load turns the motor faster than its supply.
const BLIND_MS: i32 = 100;

/// What was missed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TimingGuard {
    missed: u16,
    good: u16,
    unmeasured: Lasting,
    blind: Lasting,
}

impl TimingGuard {
    /// Missed control periods, less those that good ones have made up for.
    pub fn missed_periods(&self) -> u16 {
        self.missed
    }

    /// For how many control periods a measurement has been missing.
    pub fn unmeasured_periods(&self) -> u16 {
        self.unmeasured.periods()
    }

    /// For how many control periods the back-EMF has been missing.
    pub fn blind_periods(&self) -> u16 {
        self.blind.periods()
    }

    /// What is missing.
    pub fn check(&mut self, limits: &TimingLimits, c: &Conditions<'_>) -> FaultSet {
        let mut present = FaultSet::EMPTY;
        let overruns = i32::from(self.overruns(c.missed_periods));
        present.put(Fault::LoopOverrun, overruns > limits.overruns);
        // The temperature is missing with the scan, or with the NTC.
        let is_missing = c.measured.current.is_none() || c.measured.temperature_mdeg_c.is_none();
        let is_lost = self
            .unmeasured
            .update(Some(is_missing), limits.measurement_ms);
        let is_blind = c.is_driving && c.measured.is_blind;
        let is_blind = self.blind.update(Some(is_blind), BLIND_MS);
        present.put(Fault::MeasurementLost, is_lost || is_blind);
        present
    }

    fn overruns(&mut self, missed_periods: u8) -> u16 {
        if missed_periods > 0 {
            self.missed = self.missed.saturating_add(u16::from(missed_periods));
            self.good = 0;
        } else {
            self.good += 1;
        }
        if self.good >= GOOD_PERIODS {
            self.good = 0;
            self.missed = self.missed.saturating_sub(1);
        }
        self.missed
    }
}
