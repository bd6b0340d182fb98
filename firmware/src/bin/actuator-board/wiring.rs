//! Clocks, and which pin goes where; `docs/hardware.md` has the same table.

use firmware::supervisor::ResetCause;
use stm32f4xx_hal::{
    can::Can as CanPins,
    dma::StreamsTuple,
    gpio::{Pull, Speed},
    pac,
    prelude::*,
    rcc::{Config, Enable},
};

use crate::{
    analog::Analog, bridge::Bridge, encoder::Encoder, flash::Flash, reset_cause,
    servo_pulse::ServoPulse, ticks::Clock,
};

/// Everything that is wired to the processor, at rest, and the watchdog.
pub struct Board {
    pub bridge: Bridge,
    pub analog: Analog,
    pub encoder: Encoder,
    pub servo_pulse: ServoPulse,
    pub clock: Clock,
    /// CAN1 with its pins, not on the bus yet: which bit rate it has is a parameter.
    pub can: CanPins<pac::CAN1>,
    pub flash: Flash,
    pub watchdog: pac::IWDG,
    pub reset_cause: ResetCause,
}

impl Board {
    /// Sets clocks, pins and peripherals up.
    pub fn new(dp: pac::Peripherals) -> Self {
        let reset_cause = reset_cause::take(&dp.RCC);
        // The Nucleo's 8 MHz come from its debugger. APB2, and with it TIM1, SPI1 and ADC1, runs at half
        // the core's clock, APB1 at a quarter; timers at twice their bus.
        let clocks = Config::hse(8.MHz())
            .bypass_hse_oscillator()
            .sysclk(168.MHz())
            .pclk1(42.MHz())
            .pclk2(84.MHz());
        let mut rcc = dp.RCC.freeze(clocks);
        // If the 8 MHz fail, the clock control breaks TIM1's outputs within cycles (RM0090, section 6.2.7).
        rcc.cr().modify(|_, w| w.csson().set_bit());
        pac::TIM1::enable(&mut rcc);
        pac::TIM2::enable(&mut rcc);
        pac::TIM4::enable(&mut rcc);
        pac::SPI1::enable(&mut rcc);
        pac::ADC1::enable(&mut rcc);
        let streams = StreamsTuple::new(dp.DMA2, &mut rcc);
        let (a, b, c) = (
            dp.GPIOA.split(&mut rcc),
            dp.GPIOB.split(&mut rcc),
            dp.GPIOC.split(&mut rcc),
        );
        let (d, e) = (dp.GPIOD.split(&mut rcc), dp.GPIOE.split(&mut rcc));

        // The timer first: it holds its outputs low before they reach the pins.
        let bridge = Bridge::new(dp.TIM1, &dp.DBGMCU);
        let _ = (e.pe8.into_alternate::<1>(), e.pe9.into_alternate::<1>());
        let _ = (e.pe10.into_alternate::<1>(), e.pe11.into_alternate::<1>());
        // Without a comparator the break input reads low: no drive.
        let _ = e.pe15.into_alternate::<1>().internal_resistor(Pull::Down);

        let _ = (a.pa3.into_analog(), b.pb1.into_analog());
        let _ = (
            c.pc0.into_analog(),
            c.pc2.into_analog(),
            c.pc3.into_analog(),
        );
        let analog = Analog::new(dp.ADC1, &dp.ADC_COMMON, streams.4);

        let select = a
            .pa4
            .into_push_pull_output_in_state(stm32f4xx_hal::gpio::PinState::High);
        let encoder = Encoder::new(dp.SPI1, select, (streams.0, streams.3));
        // A broken wire reads as zeros, which are no valid word.
        let _ = a.pa5.into_alternate::<5>();
        let _ = a.pa6.into_alternate::<5>().internal_resistor(Pull::Down);

        // A broken wire gives no pulse.
        let _ = d.pd12.into_alternate::<2>().internal_resistor(Pull::Down);
        let servo_pulse = ServoPulse::new(dp.TIM4);

        let transmit = d.pd1.into_alternate::<9>().speed(Speed::High);
        let receive = d.pd0.into_alternate::<9>().internal_resistor(Pull::Up);
        let can = CanPins::new(dp.CAN1, (transmit, receive), &mut rcc);
        Self {
            bridge,
            analog,
            encoder,
            servo_pulse,
            clock: Clock::new(dp.TIM2),
            can,
            flash: Flash::new(dp.FLASH),
            watchdog: dp.IWDG,
            reset_cause,
        }
    }
}
