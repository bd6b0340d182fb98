//! What is fed forward: the rate of the command, and the duty of the voltage which its motion
//! needs.
//!
//! The present supply counts, so that the motion does not depend on it.

use model_core::control::units::Percent;

use super::back_emf_brake::{duty_of, duty_of_units, units_of};

/// The rate and the voltage that are demanded, and the duty that the regulator contains for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct FeedForward {
    rate_mdeg_s: i32,
    voltage_mv: i32,
    /// In units of [`duty_of`]. `None` while the loops are open: their output includes no demand
    /// then, but what the motor needs at its present rate.
    duty: Option<i32>,
}

impl FeedForward {
    /// Takes the rate of the command, mdeg/s, and the mean voltage of the motor, mV, for this
    /// control period.
    pub fn demand(&mut self, rate_mdeg_s: i32, voltage_mv: i32) {
        (self.rate_mdeg_s, self.voltage_mv) = (rate_mdeg_s, voltage_mv);
    }

    /// The rate of the command, mdeg/s. Without another demand the next one is 0.
    pub fn rate_mdeg_s(&mut self) -> i32 {
        core::mem::take(&mut self.rate_mdeg_s)
    }

    /// Whether a voltage is demanded, or was.
    pub fn is_active(&self) -> bool {
        self.voltage_mv != 0 || self.duty != Some(0)
    }

    /// The change of the duty at this supply voltage. Without another demand the next duty is 0.
    #[inline(never)]
    pub fn change(&mut self, supply_mv: i32) -> Percent {
        let voltage_mv = core::mem::take(&mut self.voltage_mv);
        let duty = match voltage_mv {
            0 => 0,
            voltage_mv => units_of(duty_of(voltage_mv, supply_mv)),
        };
        let before = self.duty.replace(duty).unwrap_or(duty);
        duty_of_units(duty - before)
    }

    /// The loops are open.
    pub fn end(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use model_core::control::units::percent;

    use super::*;

    #[test]
    fn each_change_of_demand_or_supply_is_fed_forward_once() {
        let mut forward = FeedForward::default();
        let mut at = |voltage_mv, supply_mv| {
            forward.demand(0, voltage_mv);
            forward.change(supply_mv)
        };
        assert_eq!(at(0, 6000), Percent::ZERO);
        assert_eq!(at(3000, 6000), percent(50.0));
        assert_eq!(at(3000, 6000), Percent::ZERO);
        assert_eq!(at(3000, 5000), percent(10.0));
        assert_eq!(at(-3000, 5000), percent(-120.0));
        assert!(forward.is_active());
        assert_eq!(forward.change(5000), percent(60.0), "no demand");
        assert!(!forward.is_active());
    }

    #[test]
    fn loops_that_are_closed_in_motion_contain_its_duty_already() {
        let mut forward = FeedForward::default();
        forward.demand(0, 3000);
        assert_eq!(forward.change(6000), Percent::ZERO);
        forward.end();
        forward.demand(0, -3000);
        assert_eq!(forward.change(6000), Percent::ZERO);
    }
}
