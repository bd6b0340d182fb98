//! Clocks of the communication board, and what hangs on its processor.
//!
//! The core runs at 160 MHz and not at the 168 MHz of the actuator board: 40 MHz for CAN1 and USART3 give all of
//! slcan's bit rates and 2,000,000 baud exactly, 42 MHz do not give 800 kbit/s.

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::{pac, prelude::*};

use super::stopwatch::{self, Millisecond, Stopwatch};
use crate::board::{
    clocks,
    pins::{self, Mode, Pin, Pull},
    reset_cause,
};

/// Which pin goes where; `docs/hardware.md` has the same table, and a test on the emulated board looks.
const PINS: [Pin; 4] = [
    // CAN: receive, send.
    (b'D', 0, Mode::Alternate(9), Pull::Up),
    (b'D', 1, Mode::FastAlternate(9), Pull::None),
    // Serial line: send, receive. A line that nobody drives rests.
    (b'D', 8, Mode::Alternate(7), Pull::None),
    (b'D', 9, Mode::Alternate(7), Pull::Up),
];

/// Everything that is wired to the processor, at rest, and the watchdog.
pub struct Board {
    pub can: pac::CAN1,
    pub usart: pac::USART3,
    pub stopwatch: Stopwatch,
    pub millisecond: Millisecond,
    pub watchdog: pac::IWDG,
    pub reset_cause: ResetCause,
}

impl Board {
    /// Sets clocks and pins up.
    pub fn new(dp: pac::Peripherals) -> Self {
        let reset_cause = reset_cause::take(&dp.RCC);
        let rcc = clocks::start(dp.RCC, 160.MHz());
        rcc.ahb1enr().modify(|_, w| w.gpioden().set_bit());
        rcc.apb1enr().modify(|_, w| {
            w.tim2en().set_bit().tim3en().set_bit();
            w.can1en().set_bit().usart3en().set_bit()
        });
        // Two cycles until their registers answer (ES0206, section 2.2.13): a read takes longer.
        let _ = rcc.apb1enr().read();
        pins::set_up(&PINS);
        let (stopwatch, millisecond) = stopwatch::start(dp.TIM2, dp.TIM3);
        Self {
            can: dp.CAN1,
            usart: dp.USART3,
            stopwatch,
            millisecond,
            watchdog: dp.IWDG,
            reset_cause,
        }
    }
}
