//! Clocks, and what hangs on the processor.

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::{dma::StreamsTuple, pac, prelude::*};

use crate::{
    actuator::{
        actuator_pins, analog::Analog, bridge::Bridge, encoder::Encoder, flash::Flash,
        servo_pulse::ServoPulse, ticks::Clock,
    },
    board::{clocks, pins, reset_cause},
};

/// Everything that is wired to the processor, at rest, and the watchdog.
pub struct Board {
    pub bridge: Bridge,
    pub analog: Analog,
    pub encoder: Encoder,
    pub servo_pulse: ServoPulse,
    pub clock: Clock,
    /// CAN1, not on the bus yet: which bit rate it has is a parameter.
    pub can: pac::CAN1,
    pub flash: Flash,
    pub watchdog: pac::IWDG,
    pub reset_cause: ResetCause,
}

impl Board {
    /// Sets clocks, pins and peripherals up.
    pub fn new(dp: pac::Peripherals) -> Self {
        let reset_cause = reset_cause::take(&dp.RCC);
        // APB2, and with it TIM1, SPI1 and ADC1, runs at half the core's clock, APB1 at a quarter.
        let mut rcc = clocks::start(dp.RCC, 168.MHz());
        // If the 8 MHz fail, the clock control breaks TIM1's outputs within cycles (RM0090, section 6.2.7).
        rcc.cr().modify(|_, w| w.csson().set_bit());
        rcc.ahb1enr().modify(|_, w| {
            w.gpioaen()
                .set_bit()
                .gpioben()
                .set_bit()
                .gpiocen()
                .set_bit();
            w.gpioden().set_bit().gpioeen().set_bit()
        });
        rcc.apb1enr()
            .modify(|_, w| w.tim2en().set_bit().tim4en().set_bit().can1en().set_bit());
        rcc.apb2enr()
            .modify(|_, w| w.tim1en().set_bit().spi1en().set_bit().adc1en().set_bit());
        // Two cycles until their registers answer (ES0206, section 2.2.13): a read takes longer.
        let _ = rcc.apb2enr().read();
        let streams = StreamsTuple::new(dp.DMA2, &mut rcc);

        // The timer first: it holds its outputs low before they reach the pins. CSn starts high.
        let bridge = Bridge::new(dp.TIM1, &dp.DBGMCU);
        dp.GPIOA.bsrr().write(|w| w.bs4().set_());
        pins::set_up(&actuator_pins::PINS);
        let analog = Analog::new(dp.ADC1, &dp.ADC_COMMON, streams.4);
        let encoder = Encoder::new(dp.SPI1, dp.GPIOA, (streams.0, streams.3));
        Self {
            bridge,
            analog,
            encoder,
            servo_pulse: ServoPulse::new(dp.TIM4),
            clock: Clock::new(dp.TIM2),
            can: dp.CAN1,
            flash: Flash::new(dp.FLASH),
            watchdog: dp.IWDG,
            reset_cause,
        }
    }
}
