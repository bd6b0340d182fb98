//! The pins of the chip: bridge outputs, converter inputs, servo pulse.

use model_core::time::PWM_PERIOD_NS;
use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::adc::Channel as Input;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::Chip;
use crate::plant::{Bridge, PERIOD_CYCLES, Sensed};

/// Full scale of the converter.
pub(super) const FULL_SCALE: u16 = 4095;

/// TIM1, at the same address in both chips.
const TIM1: u64 = 0x4001_0000;
pub(super) const CR1: u64 = TIM1;
pub(super) const CNT: u64 = TIM1 + 0x24;
pub(super) const PSC: u64 = TIM1 + 0x28;
pub(super) const CCR4: u64 = TIM1 + 0x40;

/// Converter channels of the schematic.
mod input {
    pub const CURRENT: u8 = 3;
    pub const TEMPERATURE: u8 = 9;
    pub const LEG_A: u8 = 10;
    pub const LEG_B: u8 = 12;
    pub const SUPPLY: u8 = 13;
}

/// State of a leg of the bridge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Leg {
    /// Both switches open.
    Off,
    /// The high side conducts for this number of cycles from the start of a period, the low side
    /// for the rest.
    High(u32),
}

impl Leg {
    /// The leg at these outputs: the width of the high side's pulse, ns, or the levels of both
    /// sides.
    pub fn of(pulse_ns: Option<u64>, high: Option<Level>, low: Option<Level>) -> Self {
        if let Some(pulse_ns) = pulse_ns {
            // Rounded down to ns from cycles of 5.95 ns: rounding up again finds the cycles.
            let cycles = (pulse_ns * u64::from(PERIOD_CYCLES)).div_ceil(PWM_PERIOD_NS);
            return Self::High(cycles as u32);
        }
        match (high, low) {
            (Some(Level::High), _) => Self::High(PERIOD_CYCLES),
            (_, Some(Level::High)) => Self::High(0),
            _ => Self::Off,
        }
    }
}

/// The bridge of two legs.
pub(super) fn bridge(legs: [Leg; 2]) -> Bridge {
    match legs {
        [Leg::High(a), Leg::High(b)] if a >= b => Bridge::after_dead_time(true, a - b),
        [Leg::High(a), Leg::High(b)] => Bridge::after_dead_time(false, b - a),
        _ => Bridge::Coast,
    }
}

impl Chip {
    /// The leg at the outputs of a channel of TIM1.
    pub(super) fn leg(&mut self, number: u8) -> Leg {
        let (timer, registers) = self.part.advanced_timer(0);
        let Some(channel) = Channel::new(number) else {
            return Leg::Off;
        };
        let pulse = timer.pulse(channel, registers);
        Leg::of(
            pulse.map(|pulse| pulse.width.0),
            timer.output(channel, registers),
            timer.complementary_output(channel, registers),
        )
    }

    /// Sets the codes at the converter's inputs.
    pub(super) fn set_inputs(&mut self, sensed: &Sensed) {
        self.set_input(input::CURRENT, sensed.current.bits());
        self.set_input(input::SUPPLY, sensed.supply.bits());
        self.set_input(input::TEMPERATURE, sensed.temperature.bits());
        self.set_input(input::LEG_A, sensed.legs.a.bits());
        self.set_input(input::LEG_B, sensed.legs.b.bits());
    }

    fn set_input(&mut self, channel: u8, code: u16) {
        if let Some(channel) = Input::new(channel) {
            self.part.adc[0].set_input(channel, code.into());
        }
    }

    /// Drives channel 1 of TIM4.
    pub(super) fn drive_pulse_input(&mut self, at: VirtualNanos, level: Level) {
        const TIM4: usize = 2;
        self.part
            .drive_timer(at, TIM4, |timer, registers, context| {
                if let Some(channel) = Channel::new(1) {
                    timer.drive_input(channel, level, registers, context);
                }
            });
    }
}
