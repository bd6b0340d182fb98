//! The mode homing.

use super::{Axis, Input, ModeResult};
use crate::cia402::homing::{Goal, Phase, Resistance, Search, next_index};
use crate::cia402::{Deceleration, Direction, HomingMethod, Limits, Parameters, Ramp};

impl<const PERIOD_US: u32> Axis<PERIOD_US> {
    pub(super) fn home(&mut self, input: &mut Input, parameters: &Parameters) -> ModeResult {
        if self.homing.starts(input.controlword) {
            self.start_homing(input, parameters);
        }
        match self.homing.phase {
            Phase::Searching(search) => self.search(search, input, parameters),
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

    fn start_homing(&mut self, input: &mut Input, parameters: &Parameters) {
        match parameters.homing.method {
            HomingMethod::None => self.homing.attain(),
            HomingMethod::Here => self.found(input.position_actual, input, parameters),
            HomingMethod::Index(direction) => self.search_index(direction, input, parameters),
            HomingMethod::Stop(direction) | HomingMethod::IndexBehindStop(direction) => {
                (self.homing).search(Goal::Stop(direction), input.position_actual);
            }
        }
    }

    /// Begins the way to the next index from where the motor is.
    fn search_index(&mut self, direction: Direction, input: &Input, parameters: &Parameters) {
        let of_encoder = input.position_actual.saturating_sub(self.origin);
        let index = next_index(of_encoder, direction, parameters.homing.index_distance);
        let goal = Goal::Index(index.saturating_add(self.origin));
        self.homing.search(goal, input.position_actual);
    }

    fn search(&mut self, mut search: Search, input: &mut Input, parameters: &Parameters) {
        let lag = self.ramp.position().abs_diff(input.position_actual);
        let current = input.current_actual.unsigned_abs();
        let met = search.resistance::<PERIOD_US>(input.position_actual, lag, current, parameters);
        self.homing.phase = Phase::Searching(search);
        match (search.goal, met) {
            (Goal::Stop(direction), Resistance::None) => self.approach_stop(direction, parameters),
            (Goal::Stop(direction), Resistance::Stop) => {
                self.ramp = Ramp::at(input.position_actual);
                if matches!(parameters.homing.method, HomingMethod::Stop(_)) {
                    self.found(input.position_actual, input, parameters);
                } else {
                    self.search_index(direction.reversed(), input, parameters);
                }
            }
            (Goal::Index(index), Resistance::None) => self.approach_index(index, input, parameters),
            (_, Resistance::Unknown) | (Goal::Index(_), Resistance::Stop) => {
                self.ramp = Ramp::at(input.position_actual);
                self.homing.phase = Phase::Failed;
            }
        }
    }

    fn approach_stop(&mut self, direction: Direction, parameters: &Parameters) {
        let limits = limits(parameters, parameters.homing.stop_velocity);
        let fastest = i32::try_from(limits.velocity).unwrap_or(i32::MAX);
        let velocity = fastest.saturating_mul(direction as i32);
        (self.ramp).to_velocity(velocity, &limits);
    }

    fn approach_index(&mut self, index: i32, input: &mut Input, parameters: &Parameters) {
        let limits = limits(parameters, parameters.homing.index_velocity);
        let ended = (self.ramp).to_position(index, &limits);
        if ended && input.position_actual.abs_diff(index) <= parameters.position_window {
            self.found(index, input, parameters);
        }
    }

    /// This position becomes the home offset.
    fn found(&mut self, home: i32, input: &mut Input, parameters: &Parameters) {
        let shift = parameters.homing.offset.saturating_sub(home);
        self.origin = self.origin.saturating_add(shift);
        input.position_actual = input.position_actual.saturating_add(shift);
        self.ramp.shift(shift);
        self.homing.attain();
    }
}

fn limits(parameters: &Parameters, velocity: u32) -> Limits {
    Limits {
        velocity: velocity.min(parameters.max_velocity),
        acceleration: parameters.homing.acceleration,
        deceleration: parameters.homing.acceleration,
    }
}
