//! Clocks, pins and peripherals of the actuator board with an STM32H743.

use core::ptr;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use firmware::supervisor::ResetCause;

use super::{
    ActuatorBridge, Encoder, analog::Analog, crc_unit::CrcUnit, encoder::SpiTransfer, flash::Flash,
    servo_line::ServoLine,
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
    pub can: pac::FDCAN1,
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
        let rcc = dp.RCC;
        let reset_cause = chip::take_reset_cause(&rcc);
        chip::start_clocks(&dp.PWR, &dp.FLASH, &rcc, reset_cause);
        rcc.ahb4enr().modify(|_, w| {
            w.gpioaen().set_bit().gpioben().set_bit();
            w.gpiocen()
                .set_bit()
                .gpioden()
                .set_bit()
                .gpioeen()
                .set_bit()
        });
        rcc.ahb1enr().modify(|_, w| w.adc12en().set_bit());
        rcc.apb1lenr()
            .modify(|_, w| w.tim2en().set_bit().tim4en().set_bit().tim5en().set_bit());
        rcc.apb1henr().modify(|_, w| w.fdcanen().set_bit());
        rcc.apb2enr()
            .modify(|_, w| w.tim1en().set_bit().spi1en().set_bit().usart1en().set_bit());
        // The window watchdog resets the whole chip (RM0433, RCC_GCR).
        rcc.gcr().modify(|_, w| w.ww1rsc().set_bit());
        rcc.apb3enr().modify(|_, w| w.wwdg1en().set_bit());
        // The registers respond after two cycles: a read takes longer.
        let _ = rcc.apb3enr().read();

        // The timer first: it holds its outputs low before they are connected to the pins. CSn
        // starts high.
        stop_with_debugger(&dp.DBGMCU);
        let is_revision_v = chip::is_revision_v(&dp.DBGMCU);
        if !is_revision_v {
            defmt::info!("STM32H743 of revision Y or Z");
        }
        prepare_core();
        let bridge = ActuatorBridge::new(BridgeTimer::new(dp.TIM1));
        let select = SelectPin::new(dp.GPIOA);
        setup::set_up_pins(&PINS);
        setup::lock_pins(&PINS);
        Self {
            bridge,
            analog: Analog::new((dp.ADC1, dp.ADC2), &dp.ADC12_COMMON, is_revision_v),
            encoder: Encoder::new(SpiTransfer::new(dp.SPI1), select),
            servo_pulse: ServoPulse::new(dp.TIM4),
            servo_line: ServoLine::new(dp.USART1, dp.TIM5),
            period_counter: PeriodCounter::new(dp.TIM2),
            can: dp.FDCAN1,
            flash: Flash::new(dp.FLASH),
            crc_unit: CrcUnit::default(),
            watchdogs: (dp.IWDG, dp.WWDG),
            reset_cause,
            was_shut_down: shutdown::take_mark(),
        }
    }
}

/// Turns the instruction cache on, as the flash is slower than the core, and unlocks the cycle
/// counter. The data cache stays off: the stack is in
/// the TCM, and all other data is short.
fn prepare_core() {
    // SAFETY: the registers of the caches are accessed here alone, before any interrupt.
    let mut core = unsafe { cortex_m::Peripherals::steal() };
    core.SCB.enable_icache();
    cortex_m::peripheral::DWT::unlock();
}

/// While a debugger halts the program, the motor is not driven and the watchdogs do not reset.
fn stop_with_debugger(debug: &pac::DBGMCU) {
    debug.apb2fz1().modify(|_, w| w.dbg_tim1().set_bit());
    debug.apb1lfz1().modify(|_, w| w.dbg_tim2().set_bit());
    debug.apb3fz1().modify(|_, w| w.wwdg1().set_bit());
    debug.apb4fz1().modify(|_, w| w.dbg_iwdg1().set_bit());
}

/// Serial number: a hash of the unique ID of 96 bits (RM0433, section 61.1). Two chips share one
/// with a probability of 1 in 4e9.
pub fn serial_number() -> u32 {
    const UNIQUE_ID: usize = 0x1ff1_e800;
    let id: *const [u8; 12] = ptr::with_exposed_provenance(UNIQUE_ID);
    // SAFETY: the ID is twelve bytes of read-only memory that is always accessible.
    Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC).checksum(unsafe { &*id })
}
