//! ADC1: motor current and supply under load, and a scan of back-EMF and temperature.
//!
//! Current and supply are the injected group, so that a scan cannot delay them. The program starts
//! both groups, in interrupts of TIM1's channels: no interrupt of the same priority delays them in
//! that PWM period.
//!
//! | group | channels | duration |
//! |---|---|---|
//! | injected | PA3 current, PC3 supply | (56 + 12) + (84 + 12) cycles of 21 MHz: 7.8 us |
//! | regular | PC0 leg A, PC2 leg B, PB1 temperature | 3 x (84 + 12) cycles: 13.7 us |

use core::sync::atomic::{AtomicU16, Ordering::Relaxed};

use firmware::application::Scan;
use model_core::sensors::adc::AdcCode;
use stm32f4xx_hal::dma::StreamX;

use super::dma::{DmaStream, Transfer};
use crate::{
    actuator::pins::channel,
    chip::pac::{
        ADC_COMMON, ADC1, DMA2,
        dma2::st::cr::{CIRC, DIR, PL},
    },
};

/// Results of the scan: leg A, leg B, temperature.
static SCAN_RESULTS: [AtomicU16; 3] = [const { AtomicU16::new(0) }; 3];

/// Sampling times of the channels from `first` on, ten of which share a register (RM0090, sections
/// 13.13.4 and 13.13.5): 56 cycles for the current, 84 for all others.
const fn sampling_times(first: u8) -> u32 {
    const CYCLES_56: u32 = 0b011;
    const CYCLES_84: u32 = 0b100;
    const TIMES: [(u8, u32); 5] = [
        (channel::CURRENT, CYCLES_56),
        (channel::SUPPLY, CYCLES_84),
        (channel::LEG_A, CYCLES_84),
        (channel::LEG_B, CYCLES_84),
        (channel::TEMPERATURE, CYCLES_84),
    ];
    let (mut bits, mut index) = (0, 0);
    while index < TIMES.len() {
        let (channel, time) = TIMES[index];
        if channel / 10 == first / 10 {
            bits |= time << (3 * (channel % 10));
        }
        index += 1;
    }
    bits
}

/// The analog-to-digital converter.
pub struct Analog {
    adc: ADC1,
    scan: DmaStream<4>,
    /// Whether current and supply were converted for this control period.
    is_converted: bool,
    /// Whether all channels were converted in the last coast window.
    is_scanned: bool,
}

impl Analog {
    /// Sets the converter up: on, no conversion running.
    pub fn new(adc: ADC1, common: &ADC_COMMON, stream: StreamX<DMA2, 4>) -> Self {
        // 84 MHz / 4 = 21 MHz; at most 36 MHz are allowed (data sheet, table 74).
        common.ccr().modify(|_, w| w.adcpre().div4());
        adc.cr1().write(|w| w.scan().enabled());
        // SAFETY: the fields of the channels, with codes of three bits.
        unsafe {
            adc.smpr1().write(|w| w.bits(sampling_times(10)));
            adc.smpr2().write(|w| w.bits(sampling_times(0)));
        }
        adc.sqr1().write(|w| w.l().set(3 - 1));
        // SAFETY: the converter has these channels.
        adc.sqr3().write(|w| unsafe {
            w.sq1().bits(channel::LEG_A).sq2().bits(channel::LEG_B);
            w.sq3().bits(channel::TEMPERATURE)
        });
        // SAFETY: as above. A group of two consists of the last two of four.
        adc.jsqr().write(|w| unsafe {
            w.jl().bits(2 - 1);
            w.jsq3().bits(channel::CURRENT).jsq4().bits(channel::SUPPLY)
        });
        adc.cr2()
            .write(|w| w.adon().enabled().dma().enabled().dds().continuous());
        let transfer = Transfer {
            channel: 0,
            direction: DIR::PeripheralToMemory,
            register: adc.dr().as_ptr() as u32,
            circular: CIRC::Enabled,
            priority: PL::VeryHigh,
        };
        let mut scan = DmaStream::new(stream, &transfer, &SCAN_RESULTS);
        scan.start();
        Self {
            adc,
            scan,
            is_converted: false,
            is_scanned: false,
        }
    }

    /// Starts the conversion of current and supply.
    pub fn sample_current(&mut self) {
        self.adc.cr2().modify(|_, w| w.jswstart().start());
    }

    /// Starts the scan. After an overrun of an earlier scan the stream restarts.
    pub fn start_scan(&mut self) {
        if self.adc.sr().read().ovr().bit() {
            self.scan.stop();
            self.scan.start();
            self.adc.sr().write(|w| w.ovr().clear_bit());
        }
        self.adc.cr2().modify(|_, w| w.swstart().start());
    }

    /// Ends the conversions: those that have ended since the last call are valid. A scan is valid
    /// until the next coast window.
    pub fn finish(&mut self, had_window: bool) {
        self.is_converted = self.adc.sr().read().jeoc().bit();
        self.adc.sr().write(|w| w.jeoc().clear_bit());
        if had_window {
            self.is_scanned = self.scan.take_complete();
        }
    }

    /// The current, if it was converted; the scan with the supply, if all channels were converted.
    pub fn read(&self) -> (Option<AdcCode>, Option<Scan>) {
        let current = || AdcCode::new(self.adc.jdr1().read().jdata().bits());
        let current = self.is_converted.then(current);
        let code = |code: &AtomicU16| AdcCode::new(code.load(Relaxed));
        let [leg_a, leg_b, temperature] = &SCAN_RESULTS;
        let scan = (self.is_scanned && self.is_converted).then(|| Scan {
            leg_a: code(leg_a),
            leg_b: code(leg_b),
            supply: AdcCode::new(self.adc.jdr2().read().jdata().bits()),
            temperature: code(temperature),
        });
        (current, scan)
    }
}
