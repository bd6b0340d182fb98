//! Supply voltage: too low to drive, too high to bear.

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::SupplyLimits,
};

/// For how long the supply has been outside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct SupplyGuard {
    under: Lasting,
    over: Lasting,
}

impl SupplyGuard {
    /// For how many control periods it has been too low.
    pub fn under_periods(&self) -> u16 {
        self.under.periods()
    }

    /// For how many control periods it has been too high.
    pub fn over_periods(&self) -> u16 {
        self.over.periods()
    }

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
