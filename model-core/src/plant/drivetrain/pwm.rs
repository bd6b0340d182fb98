//! The PWM bridge of a drivetrain.

use super::electrical::Terminal;
use super::{Drivetrain, DrivetrainParameters};
use crate::plant::{PERIOD, Pwm, bridge_duty_pct};
use crate::time::TICK_S;

/// The bridge within a PWM period.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PwmBridge {
    pwm: Pwm,
    off: Terminal,
}

impl PwmBridge {
    pub fn new(parameters: &DrivetrainParameters, pwm: Pwm) -> Self {
        let off = if parameters.electrical.coast_when_off >= 0.5 {
            Terminal::Coast
        } else {
            Terminal::Brake
        };
        Self { pwm, off }
    }

    /// Voltage and on time, in ticks, for a duty.
    #[inline(always)]
    pub fn drive(&self, duty_pct: f64, supply_v: f64) -> (f64, f64) {
        let share = bridge_duty_pct(duty_pct) / 100.0;
        match self.pwm {
            Pwm::Average => (supply_v * share, PERIOD as f64),
            Pwm::Switched => (libm::copysign(supply_v, share), share.abs() * PERIOD as f64),
        }
    }

    /// Simulates one tick; the switching edge is `on` ticks after its start.
    #[inline(always)]
    pub fn run_tick(&self, drivetrain: &mut Drivetrain, level_v: f64, on: f64) {
        let parts = if on >= 1.0 {
            [(Terminal::Driven(level_v), TICK_S), (self.off, 0.0)]
        } else if on > 0.0 {
            let (on_s, off_s) = (on * TICK_S, (1.0 - on) * TICK_S);
            [(Terminal::Driven(level_v), on_s), (self.off, off_s)]
        } else {
            [(self.off, TICK_S), (self.off, 0.0)]
        };
        for (terminal, time_s) in parts {
            if time_s > 0.0 {
                drivetrain.advance(terminal, time_s);
            }
        }
    }
}
