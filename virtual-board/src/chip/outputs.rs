//! The pins of the chip: bridge outputs, converter inputs, servo pulse.

use model_core::plant::pwm_timer::CurrentInstant;
use model_core::time::PWM_PERIOD_NS;
use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::adc::Channel as Input;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::Chip;
use crate::plant::{Bridge, PERIOD_CYCLES, Sensed};

/// Full scale of the converter.
pub(super) const FULL_SCALE: u16 = 4095;

const TIM1: u64 = 0x4001_0000;
const CR1: u64 = TIM1;
const CNT: u64 = TIM1 + 0x24;
const PSC: u64 = TIM1 + 0x28;
const CCR4: u64 = TIM1 + 0x40;

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
enum Leg {
    /// Both switches open.
    Off,
    /// The high side conducts for this number of cycles from the start of a period, the low side
    /// for the rest.
    High(u32),
}

impl Chip {
    /// The state of the bridge, as TIM1 drives its pins.
    pub fn bridge(&mut self) -> Bridge {
        match (self.leg(1), self.leg(2)) {
            (Leg::High(a), Leg::High(b)) if a >= b => Bridge::after_dead_time(true, a - b),
            (Leg::High(a), Leg::High(b)) => Bridge::after_dead_time(false, b - a),
            _ => Bridge::Coast,
        }
    }

    fn leg(&mut self, number: u8) -> Leg {
        let (timer, registers) = self.part.advanced_timer(0);
        let Some(channel) = Channel::new(number) else {
            return Leg::Off;
        };
        if let Some(pulse) = timer.pulse(channel, registers) {
            // Rounded down to ns from cycles of 5.95 ns: rounding up again finds the cycles.
            let cycles = (pulse.width.0 * u64::from(PERIOD_CYCLES)).div_ceil(PWM_PERIOD_NS);
            return Leg::High(cycles as u32);
        }
        let high = timer.output(channel, registers);
        let low = timer.complementary_output(channel, registers);
        match (high, low) {
            (Some(Level::High), _) => Leg::High(PERIOD_CYCLES),
            (_, Some(Level::High)) => Leg::High(0),
            _ => Leg::Off,
        }
    }

    /// Time since the start of the PWM period, ns; `None` while TIM1 is stopped.
    pub fn since_edge_ns(&mut self, at: VirtualNanos) -> Option<u64> {
        if self.peek_register(at, CR1) & 1 == 0 {
            return None;
        }
        let count = self.peek_register(at, CNT);
        let cycles = count * (self.peek_register(at, PSC) + 1);
        Some(cycles * PWM_PERIOD_NS / u64::from(PERIOD_CYCLES))
    }

    /// The instant at which the next PWM period samples the current: channel 4 of TIM1, preloaded.
    pub fn current_instant(&mut self, at: VirtualNanos) -> CurrentInstant {
        CurrentInstant::of_count(self.peek_register(at, CCR4) as u32)
    }

    /// Sets the codes at the converter's inputs.
    pub fn set_sensor_inputs(&mut self, sensed: &Sensed) {
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

    /// Drives the servo pulse input of TIM4.
    pub fn drive_servo(&mut self, at: VirtualNanos, level: Level) {
        const TIM4: usize = 2;
        self.part
            .drive_timer(at, TIM4, |timer, registers, context| {
                if let Some(channel) = Channel::new(1) {
                    timer.drive_input(channel, level, registers, context);
                }
            });
    }
}
