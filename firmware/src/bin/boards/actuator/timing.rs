//! Clock frequencies, and the periods of PWM and control in counts of the timers.
//!
//! The periods derive from [`model_core::time`] alone; that they divide the clocks without a remainder
//! is checked at compile time.

use model_core::time::{CONTROL_PERIOD_TICKS, PWM_PERIOD_TICKS, TICKS_PER_SECOND};

/// Core clock, Hz. TIM1 runs at the same frequency.
pub const CORE_HZ: u32 = 168_000_000;

/// Clock of TIM2 and TIM4, Hz: twice that of their bus, APB1.
pub const APB1_TIMER_HZ: u32 = CORE_HZ / 2;

/// Clock of CAN1, Hz: that of APB1.
pub const CAN_HZ: u32 = CORE_HZ / 4;

/// Core cycles of a microsecond.
pub const CYCLES_PER_US: u32 = CORE_HZ / 1_000_000;

/// PWM frequency, Hz.
pub const PWM_HZ: u32 = (TICKS_PER_SECOND / PWM_PERIOD_TICKS) as u32;

/// PWM period, us.
pub const PWM_PERIOD_US: u32 = 1_000_000 / PWM_HZ;

/// Control frequency, Hz.
pub const CONTROL_HZ: u32 = (TICKS_PER_SECOND / CONTROL_PERIOD_TICKS) as u32;

/// PWM periods of a control period.
pub const PWM_PERIODS: u32 = (CONTROL_PERIOD_TICKS / PWM_PERIOD_TICKS) as u32;

const _: () = {
    assert!(TICKS_PER_SECOND.is_multiple_of(PWM_PERIOD_TICKS) && 1_000_000 % PWM_HZ == 0);
    assert!(CONTROL_PERIOD_TICKS.is_multiple_of(PWM_PERIOD_TICKS));
    // The number of a PWM period wraps at a whole number of control periods.
    assert!(PWM_PERIODS.is_power_of_two());
    assert!(
        PWM_PERIODS >= 4,
        "two turns of the CANopen device between first and last period"
    );
};
