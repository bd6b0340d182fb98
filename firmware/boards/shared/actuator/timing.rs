//! Rates of PWM and control in counts of the timers.
//!
//! The rates are those of [`model_core::time`]; that they divide the clocks without a remainder is
//! checked at compile time.

use model_core::time::CONTROL_PERIODS_PER_WINDOW;
pub use model_core::time::{
    CONTROL_RATE_HZ, UPDATE_PERIODS_PER_CONTROL_PERIOD as UPDATE_PERIODS,
    UPDATE_RATE_HZ as UPDATE_HZ,
};

pub use crate::peripherals::timing::{APB1_TIMER_HZ, CORE_HZ, TIM1_HZ};

/// Core cycles of a microsecond.
pub const CYCLES_PER_US: u32 = CORE_HZ / 1_000_000;

/// Update period of the PWM, us.
pub const UPDATE_PERIOD_US: u32 = 1_000_000 / UPDATE_HZ;

/// Whether the control period of this number has a coast window: the last one of every so many.
pub const fn has_window(control_period: u32) -> bool {
    control_period
        .wrapping_add(1)
        .is_multiple_of(CONTROL_PERIODS_PER_WINDOW)
}

const _: () = {
    assert!(1_000_000 % UPDATE_HZ == 0);
    // The number of an update period, and of a control period, wraps at a whole number of windows.
    assert!(UPDATE_PERIODS.is_power_of_two() && CONTROL_PERIODS_PER_WINDOW.is_power_of_two());
    // Two calls of the CANopen device are between the first and the last update period.
    assert!(UPDATE_PERIODS >= 4);
};
