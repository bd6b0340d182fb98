//! Clocks, pins and peripherals of the communication board.
//!
//! The core runs at 160 MHz, unlike that of the actuator board: 40 MHz for CAN1 and USART3 give all
//! bit rates of slcan and 2,000,000 baud exactly; 42 MHz do not give 800 kbit/s.

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::prelude::*;

use super::{
    pins::PINS,
    timers::{self, MicrosecondCounter, MillisecondTimer},
};
use crate::{
    board::setup,
    chip::{self, pac},
};

/// The peripherals. CAN controller, USART and watchdog are not configured.
pub struct Peripherals {
    pub can: pac::CAN1,
    pub usart: pac::USART3,
    pub microseconds: MicrosecondCounter,
    pub milliseconds: MillisecondTimer,
    pub watchdog: pac::IWDG,
    pub reset_cause: ResetCause,
}

impl Peripherals {
    /// Starts clocks and timers, and sets the pins up.
    pub fn new(dp: pac::Peripherals) -> Self {
        let reset_cause = chip::take_reset_cause(&dp.RCC);
        let rcc = chip::start_clocks(dp.RCC, 160.MHz());
        rcc.ahb1enr().modify(|_, w| w.gpioden().set_bit());
        rcc.apb1enr().modify(|_, w| {
            w.tim2en().set_bit().tim3en().set_bit();
            w.can1en().set_bit().usart3en().set_bit()
        });
        // The registers respond after two cycles (ES0206, section 2.2.13): a read takes longer.
        let _ = rcc.apb1enr().read();
        setup::set_up_pins(&PINS);
        setup::lock_pins(&PINS);
        let (microseconds, milliseconds) = timers::start(dp.TIM2, dp.TIM3);
        Self {
            can: dp.CAN1,
            usart: dp.USART3,
            microseconds,
            milliseconds,
            watchdog: dp.IWDG,
            reset_cause,
        }
    }
}
