//! Clock frequencies, as `chip::start_clocks` sets them.

/// Core clock, Hz.
pub const CORE_HZ: u32 = 336_000_000;

/// Clock of TIM1, Hz.
pub const TIM1_HZ: u32 = 168_000_000;

/// Clock of TIM2, TIM4 and TIM5, Hz.
pub const APB1_TIMER_HZ: u32 = 84_000_000;

/// Clock of APB2, of USART1, Hz.
pub const APB2_HZ: u32 = 84_000_000;

/// Clock of FDCAN1, Hz.
pub const CAN_HZ: u32 = 42_000_000;
