//! Clock frequencies.

/// Core clock, Hz. TIM1 runs at the same frequency.
pub const CORE_HZ: u32 = 168_000_000;

/// Clock of TIM1, Hz.
pub const TIM1_HZ: u32 = CORE_HZ;

/// Clock of TIM2, TIM4 and TIM5, Hz: twice that of their bus, APB1.
pub const APB1_TIMER_HZ: u32 = CORE_HZ / 2;

/// Clock of APB2, of USART1, Hz.
pub const APB2_HZ: u32 = CORE_HZ / 2;

/// Clock of CAN1, Hz: that of APB1.
pub const CAN_HZ: u32 = CORE_HZ / 4;
