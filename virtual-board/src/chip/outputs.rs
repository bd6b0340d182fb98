//! The pins of the chip: bridge outputs, converter inputs, servo pulse.

use model_core::control::pwm_timer::{CurrentInstant, TIMER_CLOCK_HZ};
use rigless::device::Level;
use rigless::soc::stm32f427::peripherals::adc::Channel as Input;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

use super::Chip;
use crate::plant::{Bridge, PERIOD_CYCLES, Sensed};

/// Full scale of the converter.
pub(super) const FULL_SCALE: u16 = 4095;

/// What a run needs of the registers of TIM1.
#[derive(Debug, Clone, Copy)]
pub struct PwmTimer {
    pub(super) control: u64,
    pub(super) count: u64,
    pub(super) prescaler: u64,
    pub(super) compare_4: u64,
}

impl PwmTimer {
    /// Time since the start of the PWM period, ns; `None` while the timer is stopped.
    pub fn since_edge_ns(&self) -> Option<u64> {
        if self.control & 1 == 0 {
            return None;
        }
        let cycles = self.count * (self.prescaler + 1);
        Some(cycles * 1_000_000_000 / u64::from(TIMER_CLOCK_HZ))
    }

    /// The instant at which the next update period samples the current: channel 4, preloaded.
    pub fn current_instant(&self) -> CurrentInstant {
        CurrentInstant::of_count(self.compare_4 as u32)
    }
}

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
    /// The leg with a pulse of this width at the high side, ns.
    pub fn of_pulse(pulse_ns: u64) -> Self {
        // Rounded down to ns from cycles of 5.95 ns: rounding up again finds the cycles.
        let cycles = (pulse_ns * u64::from(TIMER_CLOCK_HZ)).div_ceil(1_000_000_000);
        Self::High(cycles as u32)
    }

    /// The leg at these levels of both sides.
    pub fn of_levels(high: Option<Level>, low: Option<Level>) -> Self {
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
        if let Some(pulse) = timer.pulse(channel, registers) {
            return Leg::of_pulse(pulse.width.0);
        }
        Leg::of_levels(
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
