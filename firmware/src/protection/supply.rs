//! Supply voltage: too low to drive, too high to bear.

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::integers::integers,
};

integers! {
    /// What the supply voltage is allowed.
    pub struct SupplyLimits {
        /// Least voltage to drive with.
        under_voltage_mv: 4000, "mV", 2500, 16000, "below the 4.8 V that the servo is rated for";
        /// Greatest voltage.
        over_voltage_mv: 6300, "mV", 3000, 16000, "6 V and 5 %: from there on a reversal at full rate is an over-current";
        /// Time for which it may be outside.
        supply_ms: 20, "ms", 4, 10000, "a dip while the motor starts";
    }
}

/// For how long the supply has been outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct SupplyGuard {
    under: Lasting,
    over: Lasting,
}

impl SupplyGuard {
    /// What is wrong with the supply.
    pub fn check(&mut self, limits: &SupplyLimits, c: &Conditions<'_>) -> FaultSet {
        let supply_mv = c.measured.supply_mv;
        let is_under = supply_mv.map(|supply_mv| supply_mv < limits.under_voltage_mv);
        let is_over = supply_mv.map(|supply_mv| supply_mv > limits.over_voltage_mv);
        let mut present = FaultSet::EMPTY;
        present.put(
            Fault::UnderVoltage,
            self.under.update(is_under, limits.supply_ms),
        );
        present.put(
            Fault::OverVoltage,
            self.over.update(is_over, limits.supply_ms),
        );
        present
    }
}
