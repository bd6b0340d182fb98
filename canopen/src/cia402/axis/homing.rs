//! The mode homing.

use super::{Axis, Input, ModeResult};
use crate::cia402::homing::{Phase, Resistance, next_index};
use crate::cia402::{Deceleration, Direction, HomingMethod, Limits, Parameters, Ramp};

impl Axis {
    pub(super) fn home(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        if self.homing.starts(input.controlword) {
            self.start_homing(input, parameters);
        }
        match self.homing.phase {
            Phase::ToStop(direction) => self.search_stop(direction, input, parameters),
            Phase::ToIndex(index) => self.approach_index(index, input, parameters),
            _ if !self.ramp.is_stationary() => {
                self.decelerate(Deceleration::SlowDown, parameters);
            }
            _ => {}
        }
        ModeResult {
            target: self.ramp.position(),
            ..ModeResult::default()
        }
    }

    fn start_homing(&mut self, input: &Input, parameters: &Parameters) {
        let phase = match parameters.homing.method {
            HomingMethod::None => return self.homing.attain(),
            HomingMethod::Here => return self.found(input.position_actual, parameters),
            HomingMethod::Index(direction) => self.to_index(direction, input, parameters),
            HomingMethod::Stop(direction) | HomingMethod::IndexBehindStop(direction) => {
                Phase::ToStop(direction)
            }
        };
        self.homing.begin(phase, input.position_actual);
    }

    /// The way to the next index from where the motor is.
    fn to_index(&self, direction: Direction, input: &Input, parameters: &Parameters) -> Phase {
        let of_encoder = input.position_actual.saturating_sub(self.origin);
        let index = next_index(of_encoder, direction, parameters.homing.index_distance);
        Phase::ToIndex(index.saturating_add(self.origin))
    }

    fn search_stop(&mut self, direction: Direction, input: &Input, parameters: &Parameters) {
        let limits = limits(parameters, parameters.homing.stop_velocity);
        let fastest = i32::try_from(limits.velocity).unwrap_or(i32::MAX);
        let velocity = fastest.saturating_mul(direction as i32);
        (self.ramp).to_velocity(velocity, &limits, parameters.period_us);
        match self.resistance(input, parameters) {
            Resistance::None => {}
            Resistance::Unknown => self.fail(input),
            Resistance::Stop => {
                self.ramp = Ramp::at(input.position_actual);
                if matches!(parameters.homing.method, HomingMethod::Stop(_)) {
                    self.found(input.position_actual, parameters);
                } else {
                    let phase = self.to_index(direction.reversed(), input, parameters);
                    self.homing.begin(phase, input.position_actual);
                }
            }
        }
    }

    fn approach_index(&mut self, index: i32, input: &Input, parameters: &Parameters) {
        let limits = limits(parameters, parameters.homing.index_velocity);
        let ended = (self.ramp).to_position(index, &limits, parameters.period_us);
        let off = input.position_actual.abs_diff(index);
        if ended && off <= parameters.position_window {
            self.found(index, parameters);
        } else if self.resistance(input, parameters) != Resistance::None {
            self.fail(input);
        }
    }

    fn resistance(&mut self, input: &Input, parameters: &Parameters) -> Resistance {
        let lag = self.ramp.position().abs_diff(input.position_actual);
        let current = input.current_actual.unsigned_abs();
        (self.homing).resistance(input.position_actual, lag, current, parameters)
    }

    /// This position becomes the home offset.
    fn found(&mut self, home: i32, parameters: &Parameters) {
        let shift = parameters.homing.offset.saturating_sub(home);
        self.origin = self.origin.saturating_add(shift);
        self.ramp.shift(shift);
        self.homing.attain();
    }

    fn fail(&mut self, input: &Input) {
        self.ramp = Ramp::at(input.position_actual);
        self.homing.phase = Phase::Failed;
    }
}

fn limits(parameters: &Parameters, velocity: u32) -> Limits {
    Limits {
        velocity: velocity.min(parameters.max_velocity),
        acceleration: parameters.homing.acceleration,
        deceleration: parameters.homing.acceleration,
    }
}
