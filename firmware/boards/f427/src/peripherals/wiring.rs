//! Clocks, pins and peripherals of the actuator board with an STM32F427.

use core::ptr;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use firmware::supervisor::ResetCause;
use stm32f4xx_hal::{dma::StreamsTuple, prelude::*, signature::Uid};

use super::{
    ActuatorBridge, Encoder, analog::Analog, crc_unit::CrcUnit, encoder::SpiTransfer, flash::Flash,
    internal_clock, servo_line::ServoLine, timing::CORE_HZ,
};
use crate::{
    actuator::{
        encoder_select::SelectPin, pins::PINS, pwm_timer::BridgeTimer, servo_pulse::ServoPulse,
        shutdown, timebase::PeriodCounter,
    },
    board::setup,
    chip::{self, pac},
};

/// The peripherals, configured and stopped.
pub struct Peripherals {
    pub bridge: ActuatorBridge,
    pub analog: Analog,
    pub encoder: Encoder,
    pub servo_pulse: ServoPulse,
    /// Off: the bit rate is a parameter.
    pub servo_line: ServoLine,
    pub period_counter: PeriodCounter,
    /// Not configured: the bit rate is a parameter.
    pub can: pac::CAN1,
    pub flash: Flash,
    pub crc_unit: CrcUnit,
    pub watchdogs: (pac::IWDG, pac::WWDG),
    pub reset_cause: ResetCause,
    /// Whether the reset was the end of a shutdown.
    pub was_shut_down: bool,
}

impl Peripherals {
    /// Starts the clocks, and sets pins and peripherals up.
    pub fn new(dp: pac::Peripherals) -> Self {
        let reset_cause = chip::take_reset_cause(&dp.RCC);
        // A failure of the 8 MHz ends in a reset by the watchdog. The program then brakes by the
        // internal clock; after any other reset it waits for them.
        let is_internal =
            reset_cause == ResetCause::Watchdog && !internal_clock::is_external_there(&dp.RCC);
        let mut rcc = if is_internal {
            defmt::warn!("no external clock: the internal one is used");
            internal_clock::start(dp.RCC, &dp.FLASH)
        } else {
            chip::start_clocks(dp.RCC, CORE_HZ.Hz())
        };
        // If the 8 MHz fail, the clock security system breaks TIM1's outputs within cycles, and its
        // interrupt, which cannot be masked, ends in the safe state (RM0090, section 6.2.7).
        rcc.cr().modify(|_, w| w.csson().set_bit());
        rcc.ahb1enr().modify(|_, w| {
            w.gpioaen()
                .set_bit()
                .gpioben()
                .set_bit()
                .gpiocen()
                .set_bit();
            w.gpioden().set_bit().gpioeen().set_bit().crcen().set_bit()
        });
        rcc.apb1enr().modify(|_, w| {
            w.tim2en().set_bit().tim4en().set_bit().tim5en().set_bit();
            w.can1en().set_bit();
            w.wwdgen().set_bit().pwren().set_bit()
        });
        rcc.apb2enr().modify(|_, w| {
            w.tim1en().set_bit().spi1en().set_bit().adc1en().set_bit();
            w.usart1en().set_bit()
        });
        // The registers respond after two cycles (ES0206, section 2.2.13): a read takes longer.
        let _ = rcc.apb2enr().read();
        let streams = StreamsTuple::new(dp.DMA2, &mut rcc);

        // The timer first: it holds its outputs low before they are connected to the pins. CSn
        // starts high.
        stop_with_debugger(&dp.DBGMCU);
        let bridge = ActuatorBridge::new(BridgeTimer::new(dp.TIM1));
        let select = SelectPin::new(dp.GPIOA);
        setup::set_up_pins(&PINS);
        setup::lock_pins(&PINS);
        let analog = Analog::new(dp.ADC1, &dp.ADC_COMMON, streams.4);
        let transfer = SpiTransfer::new(dp.SPI1, (streams.0, streams.3));
        Self {
            bridge,
            analog,
            encoder: Encoder::new(transfer, select),
            servo_pulse: ServoPulse::new(dp.TIM4),
            servo_line: ServoLine::new(dp.USART1, (streams.5, streams.7), dp.TIM5),
            period_counter: PeriodCounter::new(dp.TIM2),
            can: dp.CAN1,
            flash: Flash::new(dp.FLASH),
            crc_unit: CrcUnit::new(dp.CRC),
            watchdogs: (dp.IWDG, dp.WWDG),
            reset_cause,
            was_shut_down: shutdown::take_mark(),
        }
    }
}

/// While a debugger halts the program, the motor is not driven and the watchdogs do not reset.
fn stop_with_debugger(debug: &pac::DBGMCU) {
    debug.apb2_fz().modify(|_, w| w.dbg_tim1_stop().set_bit());
    debug.apb1_fz().modify(|_, w| {
        w.dbg_iwdg_stop().set_bit().dbg_wwdg_stop().set_bit();
        w.dbg_tim2_stop().set_bit()
    });
}

/// Serial number: a hash of the unique ID of 96 bits (RM0090, section 39.1). Two chips share one
/// with a probability of 1 in 4e9.
pub fn serial_number() -> u32 {
    // SAFETY: the ID is twelve bytes of read-only memory that is always accessible.
    let id: &[u8; 12] = unsafe { &*ptr::from_ref(Uid::get()).cast() };
    Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC).checksum(id)
}
