//! ADC1 and ADC2: motor current and supply under load, and a scan of back-EMF and temperature.
//!
//! Two converters, so that a scan cannot delay current and supply. The program starts both, in
//! interrupts of TIM1's channels: no interrupt of the same priority delays them in that PWM period.
//! Each converter keeps the results of its sequence in its FIFO (RM0433, section 25.4.27).
//!
//! | converter | channels | duration |
//! |---|---|---|
//! | ADC1 | PA3 current, PC3 supply | 2 x (64.5 + 6.5) cycles of 24 MHz: 5.9 us |
//! | ADC2 | PC0 leg A, PC2 leg B, PB1 temperature | 3 x (64.5 + 6.5) cycles: 8.9 us |
//!
//! The current is sampled 2.7 us after the conversion starts, as on the STM32F427 within 0.1 us.

use firmware::application::Scan;
use model_core::sensors::adc::AdcCode;

use crate::{
    actuator::pins::channel,
    chip::pac::{ADC1, ADC2, ADC12_COMMON, adc3::RegisterBlock},
};

/// The channel of ADC1 and ADC2 at the pin of a channel of the STM32F427: the boards share their
/// pins (data sheet of the STM32H743, pin description: PA3 is INP15, PB1 INP5, PC0 to PC3 INP10 to
/// INP13).
const fn at_pin_of(channel: u8) -> u8 {
    match channel {
        3 => 15,
        9 => 5,
        other => other,
    }
}

/// Code of a sampling time of 64.5 cycles (section 25.6.6).
const SAMPLING: u32 = 0b101;

/// Core cycles of the start-up time of a converter's regulator, 10 us.
const REGULATOR_CYCLES: u32 = 10 * (super::timing::CORE_HZ / 1_000_000);

/// The converters.
pub struct Analog {
    current: ADC1,
    scan: ADC2,
    /// Current and supply, if they were converted for this control period.
    converted: Option<[AdcCode; 2]>,
    /// The scan, if it was converted in the last coast window.
    scanned: Option<[AdcCode; 3]>,
}

impl Analog {
    /// Sets the converters up: on, calibrated, no conversion running. Takes some 7 ms.
    pub fn new((current, scan): (ADC1, ADC2), common: &ADC12_COMMON, is_revision_v: bool) -> Self {
        // The clock of PLL2, halved by the converters (figure 136), or by the divider before those
        // of revision Y, which take it as it is.
        common.ccr().write(|w| {
            let w = w.ckmode().asynchronous();
            match is_revision_v {
                true => w.presc().div1(),
                false => w.presc().div2(),
            }
        });
        for converter in [&*current, &*scan] {
            switch_on(converter, is_revision_v);
        }
        set_sequence(
            &current,
            &[channel::CURRENT, channel::SUPPLY].map(at_pin_of),
        );
        let scanned = [channel::LEG_A, channel::LEG_B, channel::TEMPERATURE];
        set_sequence(&scan, &scanned.map(at_pin_of));
        Self {
            current,
            scan,
            converted: None,
            scanned: None,
        }
    }

    /// Starts the conversion of current and supply.
    pub fn sample_current(&mut self) {
        start(&self.current);
    }

    /// Starts the scan.
    pub fn start_scan(&mut self) {
        start(&self.scan);
    }

    /// Ends the conversions: those that have ended since the last call are valid. A scan is valid
    /// until the next coast window.
    pub fn finish(&mut self, had_window: bool) {
        self.converted = take_sequence(&self.current);
        if had_window {
            self.scanned = take_sequence(&self.scan);
        }
    }

    /// The current, if it was converted; the scan with the supply, if all channels were converted.
    pub fn read(&self) -> (Option<AdcCode>, Option<Scan>) {
        let current = self.converted.map(|[current, _]| current);
        let scan = self.converted.zip(self.scanned);
        let scan = scan.map(|([_, supply], [leg_a, leg_b, temperature])| Scan {
            leg_a,
            leg_b,
            supply,
            temperature,
        });
        (current, scan)
    }
}

/// Switches a converter on (section 25.4.6 to 25.4.9): its regulator, its calibration of offset and
/// linearity, the converter.
fn switch_on(converter: &RegisterBlock, is_revision_v: bool) {
    let control = converter.cr();
    control.modify(|_, w| w.deeppwd().clear_bit());
    // Bit 8 alone is the boost of revision Y, for more than 20 MHz.
    control.modify(|_, w| match is_revision_v {
        true => w.advregen().set_bit().boost().lt25(),
        false => w.advregen().set_bit().boost().lt12_5(),
    });
    cortex_m::asm::delay(REGULATOR_CYCLES);
    control.modify(|_, w| w.adcallin().set_bit().adcaldif().clear_bit());
    control.modify(|_, w| w.adcal().set_bit());
    while control.read().adcal().bit() {}
    converter.isr().write(|w| w.adrdy().clear());
    control.modify(|_, w| w.aden().set_bit());
    while converter.isr().read().adrdy().bit_is_clear() {}
    // 12 bits; an overrun keeps the results that are there.
    converter.cfgr().modify(|_, w| {
        match is_revision_v {
            true => w.res().twelve_bit_v(),
            false => w.res().twelve_bit(),
        };
        w.ovrmod().clear_bit()
    });
}

/// Sets the sequence, of at most four channels, and their sampling times.
fn set_sequence(converter: &RegisterBlock, channels: &[u8]) {
    let last = channels.len().saturating_sub(1) as u32;
    let mut sequence = last;
    for (place, channel) in channels.iter().enumerate() {
        sequence |= u32::from(*channel) << (6 * (place as u32 + 1));
        let sampling = SAMPLING << (3 * (channel % 10));
        // SAFETY: a bit of an existing channel, and a code of its sampling time.
        unsafe {
            converter
                .pcsel()
                .modify(|r, w| w.bits(r.bits() | 1 << channel));
            if *channel < 10 {
                converter.smpr1().modify(|r, w| w.bits(r.bits() | sampling));
            } else {
                converter.smpr2().modify(|r, w| w.bits(r.bits() | sampling));
            }
        }
    }
    // SAFETY: the converter has these channels.
    converter.sqr1().write(|w| unsafe { w.bits(sequence) });
}

/// Starts a sequence; an earlier one that was not taken is discarded.
#[inline]
fn start(converter: &RegisterBlock) {
    while converter.isr().read().eoc().bit() {
        let _ = converter.dr().read();
    }
    converter.isr().write(|w| w.eos().clear().ovr().clear());
    converter.cr().modify(|_, w| w.adstart().set_bit());
}

/// The results of a sequence that has ended since the last call.
#[inline]
fn take_sequence<const N: usize>(converter: &RegisterBlock) -> Option<[AdcCode; N]> {
    if converter.isr().read().eos().bit_is_clear() {
        return None;
    }
    let codes = [(); N].map(|()| AdcCode::new(converter.dr().read().rdata().bits()));
    converter.isr().write(|w| w.eos().clear());
    Some(codes)
}
