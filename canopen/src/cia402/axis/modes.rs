//! The demands of the modes, but for homing.

use super::{Axis, Input, ModeResult, Offsets, TORQUE_UNIT};
use crate::cia402::smooth::SmoothProfile;
use crate::cia402::{Cia402State, Deceleration, Mode, Parameters, Ramp, controlword};

impl<const PERIOD_US: u32> Axis<PERIOD_US> {
    pub(super) fn run(&mut self, input: &mut Input, parameters: &Parameters) -> ModeResult {
        if self.mode != Some(input.mode) {
            self.start_mode(input);
        } else if input.mode.is_position() {
            self.has_target |= input.is_new_position;
        } else if input.mode.is_torque() {
            self.has_target |= input.is_new_torque;
        } else {
            self.has_target |= input.is_new_velocity;
        }
        match input.mode {
            Mode::ProfilePosition => self.profile_position(input, parameters),
            Mode::ProfileVelocity => self.profile_velocity(input, parameters),
            Mode::Homing => self.home(input, parameters),
            Mode::InterpolatedPosition if self.interpolates(input) => {
                self.cyclic_position(input, parameters)
            }
            Mode::CyclicPosition if self.has_target => self.cyclic_position(input, parameters),
            Mode::CyclicVelocity if self.has_target => self.cyclic_velocity(input, parameters),
            Mode::ProfileTorque | Mode::CyclicTorque if self.has_target => {
                self.follow_torque(input, parameters)
            }
            Mode::None
            | Mode::InterpolatedPosition
            | Mode::CyclicPosition
            | Mode::CyclicVelocity
            | Mode::ProfileTorque
            | Mode::CyclicTorque => {
                self.torque = 0;
                if !self.ramp.is_stationary() {
                    self.decelerate(Deceleration::SlowDown, parameters);
                }
                ModeResult {
                    target: self.ramp.position(),
                    ..ModeResult::default()
                }
            }
        }
    }

    /// Whether bit 4 enables the interpolation, and there is a point.
    fn interpolates(&mut self, input: &Input) -> bool {
        self.has_target &= input.controlword & controlword::INTERPOLATE != 0;
        self.has_target
    }

    fn profile_velocity(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let requested = if self.has_target {
            input.target_velocity
        } else {
            0
        };
        let (target, limited) = within_max_velocity(requested, parameters);
        let limits = parameters.profile(u32::MAX);
        self.ramp.to_velocity(target, &limits);
        ModeResult {
            limited,
            target: requested,
            ..ModeResult::default()
        }
    }

    fn cyclic_velocity(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let requested = input.target_velocity.saturating_add(input.velocity_offset);
        let (target, limited) = within_max_velocity(requested, parameters);
        self.ramp.set_velocity(target);
        ModeResult {
            limited,
            ..ModeResult::default()
        }
    }

    /// The torque demand approaches its target with the torque slope in profile torque mode, from
    /// zero. The velocity demand is the actual one: a stop starts from it. At a position limit the
    /// motor is held while the torque points outward, so that no load turns it beyond the limit.
    fn follow_torque(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let permitted = within_max_torque(input.target_torque, parameters);
        let target = i32::from(permitted) * TORQUE_UNIT;
        let step = match input.mode {
            Mode::ProfileTorque => {
                // Millionths: thousandths per second times microseconds, over 1000.
                let step = u64::from(parameters.torque_slope) * u64::from(PERIOD_US);
                i32::try_from(step / 1000).unwrap_or(i32::MAX)
            }
            _ => i32::MAX,
        };
        let missing = target.saturating_sub(self.torque);
        self.torque = (self.torque).saturating_add(missing.max(-step).min(step));
        self.ramp = Ramp::moving(input.position_actual, input.velocity_actual);
        let fastest = i32::try_from(parameters.max_velocity).unwrap_or(i32::MAX);
        // Where the motor goes, or the torque of one that rests.
        let direction = if input.velocity_actual.unsigned_abs() > parameters.velocity_threshold {
            input.velocity_actual
        } else {
            self.torque
        };
        let ahead = match distance_to_limit(input.position_actual, parameters, direction) {
            Some(distance) => approach_velocity::<PERIOD_US>(distance, parameters).min(fastest),
            None => fastest,
        };
        // A motor that turns back approaches the other limit from then on.
        let behind = match distance_to_limit(input.position_actual, parameters, !direction) {
            Some(..=0) => 0,
            _ => fastest,
        };
        let velocities = if direction < 0 {
            (-ahead, behind)
        } else {
            (-behind, ahead)
        };
        let (slowest, fastest) = velocities;
        let is_held = fastest == 0 && self.torque >= 0 || slowest == 0 && self.torque <= 0;
        if is_held {
            self.ramp.stop();
        }
        ModeResult {
            limited: is_held || permitted != input.target_torque,
            ended: self.torque == target,
            velocities: (!is_held).then_some(velocities),
            ..ModeResult::default()
        }
    }

    /// Limits the velocity demand toward a position limit, in every motion of a velocity mode;
    /// returns whether it was changed.
    pub(super) fn approach_limits(&mut self, input: &Input, parameters: &Parameters) -> bool {
        let velocity = self.ramp.velocity();
        let Some(distance) = distance_to_limit(input.position_actual, parameters, velocity) else {
            return false;
        };
        let fastest = approach_velocity::<PERIOD_US>(distance, parameters);
        let limited = velocity.saturating_abs() > fastest;
        if limited {
            self.ramp.limit_velocity(fastest.unsigned_abs());
        }
        limited
    }

    fn profile_position(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let present = (self.ramp.position(), input.position_actual);
        let requested = (self.set_points).step(
            input.controlword,
            input.target_position,
            present,
            parameters,
        );
        // Without a set-point the axis stays where the mode started, be it beyond the limits.
        let (target, limited) = if self.set_points.is_empty() {
            (requested, false)
        } else {
            parameters.within_position_limits(requested)
        };
        let limits = parameters.profile(parameters.profile_velocity);
        let mut ended = if parameters.smoothing > 1 {
            let target = (target, parameters.smoothing);
            let (smooth, ramp) = (&mut self.smooth, &mut self.ramp);
            SmoothProfile::advance(smooth, ramp, target, &limits)
        } else {
            self.smooth = None;
            self.ramp.to_position(target, &limits)
        };
        // A set-point is active until the motor has arrived, which may come to rest outside the
        // window.
        let waits = ended && self.set_points.is_active();
        let arrival_ms = (parameters.position_window_time_ms).saturating_add(ARRIVAL_MS);
        let is_late = (self.arrival_timer).step::<PERIOD_US>(waits, arrival_ms);
        if waits && (self.is_reached || is_late) {
            ended = !self.set_points.has_next();
            self.set_points.reached();
        }
        ModeResult {
            limited,
            ended,
            target,
            ..ModeResult::default()
        }
    }

    /// The offsets 60B1h and 60B2h in effect in the control period of the last [`Axis::step`]. That
    /// of the velocity belongs to a motion, from the first target until a stop; that of the torque
    /// to a load, which a stop does not end. A constant velocity offset makes a constant position
    /// error: it does not hold the shaft beyond a position limit.
    #[must_use]
    pub fn offsets(&self, wanted: Offsets, parameters: &Parameters) -> Offsets {
        let is_enabled = self.state() == Cia402State::OperationEnabled;
        let torque = within_max_torque(wanted.torque, parameters);
        let only_torque = Offsets {
            velocity: 0,
            torque,
        };
        match self.mode.filter(|_| is_enabled) {
            Some(Mode::CyclicVelocity) => only_torque,
            Some(Mode::CyclicPosition) if self.is_stopping || !self.has_target => only_torque,
            Some(Mode::CyclicPosition) => {
                let (offset, _) = within_max_velocity(wanted.velocity, parameters);
                let distance = distance_to_limit(self.ramp.position(), parameters, offset);
                let most =
                    distance.map(|distance| approach_velocity::<PERIOD_US>(distance, parameters));
                Offsets {
                    velocity: most.map_or(offset, |most| offset.max(-most).min(most)),
                    torque,
                }
            }
            _ => Offsets::default(),
        }
    }

    fn cyclic_position(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let (target, limited) = parameters.within_position_limits(input.target_position);
        if target != self.command {
            self.command = target;
            self.steps = parameters.interpolation_us.div_ceil(PERIOD_US);
        }
        let too_fast = (self.ramp).interpolate(target, self.steps, parameters.max_velocity);
        self.steps = self.steps.saturating_sub(1);
        ModeResult {
            limited: limited || too_fast,
            target,
            ..ModeResult::default()
        }
    }
}

/// Time in milliseconds, beyond that of the position window, after which the motor counts as
/// arrived in any case.
const ARRIVAL_MS: u16 = 1000;

/// Limits a velocity to 607Fh; returns it and whether it was changed.
fn within_max_velocity(requested: i32, parameters: &Parameters) -> (i32, bool) {
    let top = i32::try_from(parameters.max_velocity).unwrap_or(i32::MAX);
    let velocity = requested.max(-top).min(top);
    (velocity, velocity != requested)
}

/// Limits a torque to 6072h.
fn within_max_torque(requested: i16, parameters: &Parameters) -> i16 {
    let most = i16::try_from(parameters.max_torque).unwrap_or(i16::MAX);
    requested.max(-most).min(most)
}

/// Distance from a position to the position limit in the direction of a velocity; `None` without
/// one.
fn distance_to_limit(position: i32, parameters: &Parameters, velocity: i32) -> Option<i64> {
    let (low, high) = parameters.position_limits?;
    let place = i64::from(position);
    Some(if velocity < 0 {
        place - i64::from(low)
    } else {
        i64::from(high) - place
    })
}

/// Fractional bits of [`Parameters::approach_gain`].
const GAIN_BITS: u32 = 10;

/// The highest velocity from which the axis stops before a position limit at this distance, by
/// deceleration and by gain. 0 beyond the limit.
fn approach_velocity<const PERIOD_US: u32>(distance: i64, parameters: &Parameters) -> i32 {
    let Ok(distance) = u32::try_from(distance) else {
        return 0;
    };
    let deceleration = (parameters.deceleration).min(parameters.reachable_deceleration);
    let by_ramp = Ramp::<PERIOD_US>::stopping_velocity(distance, deceleration);
    if parameters.approach_gain == 0 {
        return by_ramp;
    }
    // Below 2^32 times 2^32.
    let by_loop = (u64::from(distance) * u64::from(parameters.approach_gain)) >> GAIN_BITS;
    by_ramp.min(i32::try_from(by_loop).unwrap_or(i32::MAX))
}
