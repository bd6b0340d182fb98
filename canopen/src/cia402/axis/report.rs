//! Statusword, following error and demand of an axis.

use super::{Axis, Demand, Input, ModeResult, Output, TORQUE_UNIT};
use crate::cia402::homing::Phase;
use crate::cia402::{Mode, Motion, Parameters, controlword, statusword};

impl<const PERIOD_US: u32> Axis<PERIOD_US> {
    pub(super) fn report(
        &mut self,
        input: &Input,
        parameters: &Parameters,
        motion: Motion,
        result: ModeResult,
    ) -> Output {
        let position_mode = input.mode.is_position();
        let powered = motion != Motion::Off;
        let position = self.ramp.position();
        let error = if powered && position_mode {
            position.saturating_sub(input.position_actual)
        } else {
            0
        };
        let too_far = error.unsigned_abs() > parameters.following_error_window;
        let time_ms = parameters.following_error_timeout_ms;
        let exceeded = (self.error_timer).step::<PERIOD_US>(too_far, time_ms);
        let mut word = self.machine.state().statusword() | statusword::REMOTE;
        let mut set = |bit: u16, on: bool| word |= if on { bit } else { 0 };
        set(statusword::VOLTAGE_ENABLED, input.voltage);
        set(statusword::INTERNAL_LIMIT, result.limited);
        // The same bit.
        let has_failed = match input.mode {
            Mode::Homing => matches!(self.homing.phase, Phase::Failed),
            _ => exceeded,
        };
        set(statusword::FOLLOWING_ERROR, has_failed);
        let (reached, mode_12) = self.mode_bits(input, parameters, motion, result);
        set(statusword::TARGET_REACHED, reached);
        set(statusword::MODE_12, mode_12);
        let velocity = self.ramp.velocity();
        let demand = match (powered, position_mode, result.velocities) {
            (false, _, _) => Demand::Off,
            (true, true, _) => Demand::Position { position, velocity },
            (true, false, Some(velocities)) => Demand::Torque {
                // At most the greatest target.
                torque: (self.torque / TORQUE_UNIT) as i16,
                velocities,
            },
            (true, false, None) => Demand::Velocity(velocity),
        };
        Output {
            state: self.machine.state(),
            statusword: word,
            mode_display: input.mode,
            demand,
            origin: self.origin,
            following_error: error,
            following_error_exceeded: exceeded,
        }
    }

    /// Bits 10 and 12 of the statusword.
    fn mode_bits(
        &mut self,
        input: &Input,
        parameters: &Parameters,
        motion: Motion,
        result: ModeResult,
    ) -> (bool, bool) {
        let runs = motion == Motion::Run;
        let stopped = matches!(motion, Motion::Stop(_)) && self.ramp.is_stationary();
        let zero = self.is_slow;
        match input.mode {
            Mode::ProfilePosition => {
                let off = input.position_actual.abs_diff(result.target);
                let near = runs && result.ended && off <= parameters.position_window;
                let time_ms = parameters.position_window_time_ms;
                self.is_reached = self.reached_timer.step::<PERIOD_US>(near, time_ms);
                let reached = self.is_reached || stopped;
                (reached, runs && self.set_points.acknowledged())
            }
            Mode::ProfileVelocity => {
                let off = input.velocity_actual.abs_diff(result.target);
                let near = runs && off <= parameters.velocity_window;
                let time_ms = parameters.velocity_window_time_ms;
                let reached = self.reached_timer.step::<PERIOD_US>(near, time_ms);
                (reached || stopped, zero)
            }
            Mode::Homing => match self.homing.phase {
                // Before its first start bit 10 is not set, as in its course: a client that reads
                // the word of before the start does not take it for an interruption.
                Phase::Idle | Phase::Searching(_) => (false, false),
                Phase::Attained => (self.ramp.is_stationary(), true),
                Phase::Interrupted | Phase::Failed => (zero, false),
            },
            Mode::InterpolatedPosition => {
                let is_enabled = input.controlword & controlword::INTERPOLATE != 0;
                (false, runs && is_enabled)
            }
            Mode::ProfileTorque => (runs && result.ended || stopped, false),
            Mode::CyclicPosition | Mode::CyclicVelocity | Mode::CyclicTorque => {
                (false, runs && self.has_target && !result.limited)
            }
            Mode::None => (false, false),
        }
    }
}
