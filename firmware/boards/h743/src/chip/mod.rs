//! The STM32H743; the registers are those of revision V.

pub use stm32h7::stm32h743v as pac;

use firmware::supervisor::ResetCause;

/// Address of port A's registers (RM0433, section 2.3).
pub const PORTS: u32 = 0x5802_0000;

/// Speed of a pin with edges below 100 ns (section 11.4.3).
pub const HIGH_SPEED: u32 = 0b01;

/// Readings of the clock's state in 10 ms and more, of some ten cycles of 64 MHz each.
const CLOCK_READINGS: u32 = 80_000;

/// Starts the clocks, from the 8 MHz that the Nucleo's debugger supplies, or after a reset by the
/// watchdog, which follows a failure of these, from an eighth of the internal oscillator's 64 MHz:
///
/// | clock | source | MHz |
/// |---|---|---|
/// | core | PLL1 P: 8 x 84 / 2 | 336 |
/// | buses AXI and AHB | core / 2 | 168 |
/// | APB1, APB3, APB4; timers of APB1 | AHB / 4; twice that | 42; 84 |
/// | APB2; TIM1 | AHB / 2; twice that | 84; 168 |
/// | FDCAN, SPI1 | PLL1 Q: 672 / 16 | 42 |
/// | converters | PLL2 P: 8 x 48 / 8, halved in the converter | 48; 24 |
///
/// Timers, CAN and SPI then have the clocks that they have on an STM32F427 with 168 MHz.
pub fn start_clocks(power: &pac::PWR, flash: &pac::FLASH, rcc: &pac::RCC, cause: ResetCause) {
    // The internal regulator supplies the core (chapter 6): scale 1, for at most 400 MHz.
    power
        .cr3()
        .modify(|_, w| w.scuen().set_bit().ldoen().set_bit().bypass().clear_bit());
    while power.csr1().read().actvosrdy().bit_is_clear() {}
    // SAFETY: scale 1 (section 6.8.6).
    power.d3cr().modify(|_, w| unsafe { w.vos().bits(0b11) });
    while power.d3cr().read().vosrdy().bit_is_clear() {}

    rcc.cr().modify(|_, w| w.hsebyp().set_bit());
    rcc.cr().modify(|_, w| w.hseon().set_bit());
    let mut readings = 0..CLOCK_READINGS;
    while !readings.any(|_| rcc.cr().read().hserdy().bit()) && cause != ResetCause::Watchdog {
        readings = 0..CLOCK_READINGS;
    }
    rcc.pllckselr().write(|w| {
        if rcc.cr().read().hserdy().bit() {
            w.pllsrc().hse().divm1().set(1).divm2().set(1)
        } else {
            defmt::warn!("no external clock: the internal one is used");
            w.pllsrc().hsi().divm1().set(8).divm2().set(8)
        }
    });
    // Ranges of 8 MHz at the inputs, wide ranges of the oscillators.
    rcc.pllcfgr().modify(|_, w| {
        w.pll1rge().range8().pll1vcosel().wide_vco();
        w.pll2rge().range8().pll2vcosel().wide_vco();
        w.divp1en()
            .set_bit()
            .divq1en()
            .set_bit()
            .divr1en()
            .clear_bit();
        w.divp2en()
            .set_bit()
            .divq2en()
            .clear_bit()
            .divr2en()
            .clear_bit()
    });
    // SAFETY: the fields hold one less than the divisors and multipliers of the table.
    rcc.pll1divr().write(|w| unsafe {
        w.divn1().bits(84 - 1);
        w.divp1()
            .bits(2 - 1)
            .divq1()
            .bits(16 - 1)
            .divr1()
            .bits(2 - 1)
    });
    // SAFETY: as above.
    rcc.pll2divr().write(|w| unsafe {
        w.divn2().bits(48 - 1);
        w.divp2()
            .bits(8 - 1)
            .divq2()
            .bits(2 - 1)
            .divr2()
            .bits(2 - 1)
    });
    rcc.cr()
        .modify(|_, w| w.pll1on().set_bit().pll2on().set_bit());
    while rcc.cr().read().pll1rdy().bit_is_clear() || rcc.cr().read().pll2rdy().bit_is_clear() {}

    // Two wait states at 168 MHz and scale 1 (section 4.3.8, table 17).
    // SAFETY: values of that table.
    flash
        .acr()
        .write(|w| unsafe { w.latency().bits(2).wrhighfreq().bits(0b01) });
    while flash.acr().read().latency().bits() != 2 {}
    rcc.d1cfgr()
        .write(|w| w.d1cpre().div1().hpre().div2().d1ppre().div4());
    rcc.d2cfgr().write(|w| w.d2ppre1().div4().d2ppre2().div2());
    rcc.d3cfgr().write(|w| w.d3ppre().div4());
    rcc.d2ccip1r()
        .modify(|_, w| w.fdcansel().pll1_q().spi123sel().pll1_q());
    rcc.d3ccipr().modify(|_, w| w.adcsel().pll2_p());
    rcc.cfgr().modify(|_, w| w.sw().pll1());
    while !rcc.cfgr().read().sws().is_pll1() {}
    // If the 8 MHz fail, the clock security system breaks TIM1's outputs within cycles (section
    // 8.5.3).
    rcc.cr().modify(|_, w| w.hsecsson().set_bit());
}

/// Whether the chip is of revision X, V or a later one, whose converters halve their clock and code
/// their settings differently from revisions Z and Y (RM0433, section 60.5.8).
pub fn is_revision_v(debug: &pac::DBGMCU) -> bool {
    debug.idc().read().rev_id().bits() >= 0x2001
}

/// Reads the reset cause and clears its flags, so that they show the next reset alone (section
/// 8.7.39): the most specific one if several are set.
pub fn take_reset_cause(rcc: &pac::RCC) -> ResetCause {
    let flags = rcc.rsr().read();
    rcc.rsr().modify(|_, w| w.rmvf().set_bit());
    if flags.iwdg1rstf().bit() || flags.wwdg1rstf().bit() {
        ResetCause::Watchdog
    } else if flags.sftrstf().bit() {
        ResetCause::Software
    } else if flags.lpwrrstf().bit() {
        ResetCause::LowPower
    } else if flags.porrstf().bit() || flags.borrstf().bit() {
        ResetCause::Power
    } else {
        ResetCause::Pin
    }
}
