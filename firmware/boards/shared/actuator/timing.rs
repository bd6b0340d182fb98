//! Rates of PWM and control in counts of the timers.
//!
//! The rates are those of [`model_core::time`]; that they divide the clocks without a remainder is
//! checked at compile time.

use model_core::time::PWM_RATE_HZ;
pub use model_core::time::{
    CONTROL_RATE_HZ, PWM_PERIODS_PER_CONTROL_PERIOD as PWM_PERIODS, PWM_RATE_HZ as PWM_HZ,
};

pub use crate::peripherals::timing::{APB1_TIMER_HZ, CORE_HZ, TIM1_HZ};

/// Core cycles of a microsecond.
pub const CYCLES_PER_US: u32 = CORE_HZ / 1_000_000;

/// PWM period, us.
pub const PWM_PERIOD_US: u32 = 1_000_000 / PWM_RATE_HZ;

const _: () = {
    assert!(1_000_000 % PWM_RATE_HZ == 0);
    // The number of a PWM period wraps at a whole number of control periods.
    assert!(PWM_PERIODS.is_power_of_two());
    // Two calls of the CANopen device are between the first and the last PWM period.
    assert!(PWM_PERIODS >= 4);
};
