//! One axis: state machine, modes of operation and monitoring.

mod homing;
mod report;

use super::homing::Homing;
use super::set_point::SetPoints;
use super::smooth::SmoothProfile;
use super::window::HoldTimer;
use super::{
    Cia402State, Conditions, Deceleration, Fault, Limits, Mode, Motion, Parameters, Ramp,
    StateMachine, controlword,
};

/// Input of an axis in each control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// Controlword 6040h.
    pub controlword: u16,
    /// Mode of operation 6060h.
    pub mode: Mode,
    /// Target position 607Ah.
    pub target_position: i32,
    /// Target velocity 60FFh.
    pub target_velocity: i32,
    /// Velocity offset 60B1h, added in cyclic synchronous velocity mode.
    pub velocity_offset: i32,
    /// 607Ah was written since the last period, by whatever value.
    pub is_new_position: bool,
    /// 60FFh or 60B1h was written since the last period, by whatever value.
    pub is_new_velocity: bool,
    /// Position by the encoder: the position actual value 6064h less [`Output::origin`].
    pub position_actual: i32,
    /// Velocity actual value 606Ch.
    pub velocity_actual: i32,
    /// Motor current, in any unit; homing on a hard stop compares it.
    pub current_actual: i32,
    /// The fault that is present now.
    pub fault: Fault,
    /// The power stage has its supply voltage.
    pub voltage: bool,
    /// Initialisation is complete.
    pub initialised: bool,
}

impl Default for Input {
    /// No command; the motor is at position zero and at rest, initialised and supplied.
    fn default() -> Self {
        Self {
            controlword: 0,
            mode: Mode::None,
            target_position: 0,
            target_velocity: 0,
            velocity_offset: 0,
            is_new_position: false,
            is_new_velocity: false,
            position_actual: 0,
            velocity_actual: 0,
            current_actual: 0,
            fault: Fault::None,
            voltage: true,
            initialised: true,
        }
    }
}

/// Demand for the control loops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// Power stage off.
    Off,
    /// Position demand with its velocity.
    Position {
        /// Position demand value 6062h.
        position: i32,
        /// Velocity of the position demand.
        velocity: i32,
    },
    /// Velocity demand value 606Bh.
    Velocity(i32),
}

/// Output of an axis in each control period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// State of the drive state machine.
    pub state: Cia402State,
    /// Statusword 6041h.
    pub statusword: u16,
    /// Modes of operation display 6061h.
    pub mode_display: Mode,
    /// Demand for the control loops.
    pub demand: Demand,
    /// The position at which the encoder is at 0, by [`Axis::starting_from`] and by homing: what
    /// position demand and position actual value have beyond it.
    pub origin: i32,
    /// Following error actual value 60F4h; 0 in velocity modes.
    pub following_error: i32,
    /// The following error exceeded its window for longer than its time-out: error code 8611h. The
    /// application decides whether this is a fault and passes it in [`Input::fault`] in the next
    /// period.
    pub following_error_exceeded: bool,
}

/// One axis.
///
/// A mode starts when operation is enabled, after a quick stop and with each change of 6060h. It
/// starts at the actual position and holds it: a target acts once it has been written in a later
/// period than that in which the mode started. What was written before, in another mode or while
/// the power was off, moves nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Axis {
    machine: StateMachine,
    ramp: Ramp,
    set_points: SetPoints,
    smooth: Option<SmoothProfile>,
    homing: Homing,
    origin: i32,
    mode: Option<Mode>,
    /// A target has been written since the mode started.
    has_target: bool,
    /// Cyclic synchronous position: the last target, and the control periods left to interpolate to
    /// it.
    command: i32,
    steps: u32,
    /// The axis decelerates to standstill.
    is_stopping: bool,
    stop_timer: HoldTimer,
    /// The sign of the velocity of a motor that a stop decelerates.
    stop_direction: i32,
    /// The stop has lasted its time.
    is_stop_over: bool,
    /// The motor has been at or below the velocity threshold for its time.
    is_slow: bool,
    error_timer: HoldTimer,
    reached_timer: HoldTimer,
    /// Bit 10 of the statusword was set for the active set-point.
    is_reached: bool,
    arrival_timer: HoldTimer,
    slow_timer: HoldTimer,
}

/// Result of a mode in one control period.
#[derive(Clone, Copy, Default)]
struct ModeResult {
    /// A limit changed the target.
    limited: bool,
    /// The profile is complete.
    ended: bool,
    /// Position, or in profile velocity mode velocity, that bit 10 "target reached" compares with.
    target: i32,
}

impl Axis {
    /// At power-on.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// At power-on, with the position at which the encoder is at 0.
    #[must_use]
    pub fn starting_from(origin: i32) -> Self {
        Self {
            origin,
            ..Self::default()
        }
    }

    /// State of the drive state machine.
    #[must_use]
    pub const fn state(&self) -> Cia402State {
        self.machine.state()
    }

    /// Sets the demand to a position of the encoder and a velocity, and restarts the mode: for when a source other
    /// than this axis moves the motor.
    pub fn reset_demand(&mut self, position: i32, velocity: i32) {
        self.ramp = Ramp::moving(position.saturating_add(self.origin), velocity);
        self.mode = None;
    }

    /// One control period.
    pub fn step(&mut self, mut input: Input, parameters: &Parameters) -> Output {
        input.position_actual = input.position_actual.saturating_add(self.origin);
        let input = &input;
        let origin = self.origin;
        if !input.mode.is_position() {
            // The first position mode after this one starts from the actual position.
            self.ramp.set_position(input.position_actual);
        }
        let slow = input.velocity_actual.unsigned_abs() <= parameters.velocity_threshold;
        let slow_ms = parameters.velocity_threshold_time_ms;
        self.is_slow = (self.slow_timer).step(slow, slow_ms, parameters.period_us);
        let conditions = Conditions {
            initialised: input.initialised,
            voltage: input.voltage,
            fault: input.fault,
            standstill: self.is_at_rest(),
        };
        let motion = self
            .machine
            .step(input.controlword, conditions, &parameters.options);
        let was_stopping = self.is_stopping;
        self.is_stopping = matches!(motion, Motion::Stop(_));
        // In every period: the time of a stop ends with the stop.
        let goes_on = was_stopping && self.is_stopping;
        let stop_ms = parameters.stop_time_ms;
        self.is_stop_over = (self.stop_timer).step(goes_on, stop_ms, parameters.period_us);
        let mut result = match motion {
            Motion::Off => {
                self.track_actual_position(input);
                ModeResult {
                    target: input.position_actual,
                    ..ModeResult::default()
                }
            }
            Motion::Stop(how) => {
                // A profile resumes after a halt; the targets of a cyclic mode have moved on.
                self.has_target &= !input.mode.is_cyclic();
                if !was_stopping {
                    self.start_stop(input, parameters);
                }
                self.decelerate(how, parameters);
                if input.mode.is_position() {
                    self.wait_for_motor(input, parameters);
                }
                ModeResult {
                    target: self.ramp.position(),
                    ..ModeResult::default()
                }
            }
            Motion::Run => self.run(input, parameters),
        };
        if !input.mode.is_position() {
            result.limited |= self.approach_limits(input, parameters);
        }
        let moved = self.origin.wrapping_sub(origin);
        let actual = input.position_actual.saturating_add(moved);
        self.report(actual, input, parameters, motion, result)
    }

    /// Whether a stop is over: the demand is stationary, and so is the motor, for the time of the
    /// velocity threshold. For one that load or fault keeps moving, the stop lasts
    /// [`Parameters::stop_time_ms`], or as long as the demand moves.
    fn is_at_rest(&self) -> bool {
        self.ramp.is_stationary() && (self.is_slow || self.is_stop_over)
    }

    /// Begins a stop. A motor that does not follow the demand, as after a step of the target of a
    /// cyclic mode, decelerates from its actual velocity: the demand may be at rest already.
    fn start_stop(&mut self, input: &Input, parameters: &Parameters) {
        let ahead = (self.ramp.position()).saturating_sub(input.position_actual);
        // The measured velocity lags behind: a motion that has just begun goes to the demand.
        self.homing.interrupt();
        self.stop_direction = if moves(input, parameters) {
            input.velocity_actual.signum()
        } else {
            ahead.signum()
        };
        let (demand, actual) = (self.ramp.velocity(), input.velocity_actual);
        // A motor that follows lags behind in position, and its velocity differs by less than half.
        let follows = actual.abs_diff(demand) <= demand.unsigned_abs() / 2;
        if follows {
            return;
        }
        let position = if input.mode.is_position() {
            input.position_actual
        } else {
            self.ramp.position()
        };
        self.ramp = Ramp::moving(position, actual);
    }

    /// A motor that decelerates more slowly than the demand does not return to it: the demand ends
    /// where the motor has come to rest.
    fn wait_for_motor(&mut self, input: &Input, parameters: &Parameters) {
        let rests = self.is_stop_over && self.is_slow;
        if rests
            || moves(input, parameters) && input.velocity_actual.signum() == -self.stop_direction
        {
            self.stop_direction = 0;
        }
        let position = i64::from(self.ramp.position());
        let beyond = i64::from(input.position_actual) - position;
        if beyond * i64::from(self.stop_direction) > 0 {
            self.ramp.set_position(input.position_actual);
        }
    }

    /// With the power stage off the position demand follows the actual position.
    fn track_actual_position(&mut self, input: &Input) {
        self.ramp = Ramp::at(input.position_actual);
        self.homing.interrupt();
        self.mode = None;
    }

    /// Starts a mode at the actual position, with the present velocity demand. Behind a stop, or a
    /// source other than this axis, the position demand continues.
    fn start_mode(&mut self, input: &Input) {
        if self.mode.is_some() {
            self.ramp.set_position(input.position_actual);
        }
        self.has_target = false;
        self.set_points
            .restart(self.ramp.position(), input.controlword);
        self.homing.restart(input.controlword);
        self.command = self.ramp.position();
        self.steps = 0;
        self.mode = Some(input.mode);
    }

    fn decelerate(&mut self, how: Deceleration, parameters: &Parameters) {
        let deceleration = match how {
            Deceleration::SlowDown => parameters.deceleration,
            Deceleration::QuickStop => parameters.quick_stop_deceleration,
            Deceleration::Limit => {
                self.ramp.stop();
                0
            }
        };
        let limits = Limits {
            velocity: u32::MAX,
            acceleration: deceleration,
            deceleration,
        };
        self.ramp.limit_velocity(parameters.max_velocity);
        self.ramp.to_velocity(0, &limits, parameters.period_us);
        self.command = self.ramp.position();
        self.steps = 0;
        // Motion resumes only after a halt, which is not a state of its own.
        if self.machine.state() != Cia402State::OperationEnabled {
            self.mode = None;
        }
    }

    fn run(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        if self.mode != Some(input.mode) {
            self.start_mode(input);
        } else if input.mode.is_position() {
            self.has_target |= input.is_new_position;
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
            Mode::None
            | Mode::InterpolatedPosition
            | Mode::CyclicPosition
            | Mode::CyclicVelocity => {
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
        self.ramp.to_velocity(target, &limits, parameters.period_us);
        ModeResult {
            limited,
            target: requested,
            ..ModeResult::default()
        }
    }

    fn cyclic_velocity(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let requested = input.target_velocity.saturating_add(input.velocity_offset);
        let (target, limited) = within_max_velocity(requested, parameters);
        self.ramp.set_velocity(target, parameters.period_us);
        ModeResult {
            limited,
            ..ModeResult::default()
        }
    }

    /// Limits the velocity demand toward a position limit, in every motion of a velocity mode;
    /// returns whether it was changed.
    fn approach_limits(&mut self, input: &Input, parameters: &Parameters) -> bool {
        let Some((low, high)) = parameters.position_limits else {
            return false;
        };
        let place = i64::from(input.position_actual);
        let velocity = self.ramp.velocity();
        let distance = if velocity < 0 {
            place - i64::from(low)
        } else {
            i64::from(high) - place
        };
        let fastest = approach_velocity(distance, parameters);
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
        let period_us = parameters.period_us;
        let mut ended = if parameters.smoothing > 1 {
            let target = (target, parameters.smoothing);
            let (smooth, ramp) = (&mut self.smooth, &mut self.ramp);
            SmoothProfile::advance(smooth, ramp, target, &limits, period_us)
        } else {
            self.smooth = None;
            self.ramp.to_position(target, &limits, period_us)
        };
        // The next set-point waits for the motor, which may come to rest outside the window.
        let waits = ended && self.set_points.has_next();
        let arrival_ms = (parameters.position_window_time_ms).saturating_add(ARRIVAL_MS);
        let is_late = (self.arrival_timer).step(waits, arrival_ms, period_us);
        if ended && (!waits || self.is_reached || is_late) {
            self.set_points.reached();
            ended = !waits;
        }
        ModeResult {
            limited,
            ended,
            target,
        }
    }

    fn cyclic_position(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let (target, limited) = parameters.within_position_limits(input.target_position);
        if target != self.command {
            self.command = target;
            self.steps = parameters
                .interpolation_us
                .div_ceil(parameters.period_us.max(1));
        }
        let too_fast = self.ramp.interpolate(
            target,
            self.steps,
            parameters.max_velocity,
            parameters.period_us,
        );
        self.steps = self.steps.saturating_sub(1);
        ModeResult {
            limited: limited || too_fast,
            ended: false,
            target,
        }
    }
}

/// Time in milliseconds, beyond that of the position window, after which a set-point that waits for
/// the motor starts in any case.
const ARRIVAL_MS: u16 = 1000;

/// Limits a velocity to 607Fh; returns it and whether it was changed.
fn within_max_velocity(requested: i32, parameters: &Parameters) -> (i32, bool) {
    let top = i32::try_from(parameters.max_velocity).unwrap_or(i32::MAX);
    let velocity = requested.max(-top).min(top);
    (velocity, velocity != requested)
}

/// Fractional bits of [`Parameters::approach_gain`].
const GAIN_BITS: u32 = 10;

/// The highest velocity from which the axis stops before a position limit at this distance, by
/// deceleration and by gain. 0 beyond the limit.
fn approach_velocity(distance: i64, parameters: &Parameters) -> i32 {
    let Ok(distance) = u32::try_from(distance) else {
        return 0;
    };
    let deceleration = (parameters.deceleration).min(parameters.reachable_deceleration);
    let by_ramp = Ramp::stopping_velocity(distance, deceleration, parameters.period_us);
    if parameters.approach_gain == 0 {
        return by_ramp;
    }
    // Below 2^32 times 2^32.
    let by_loop = (u64::from(distance) * u64::from(parameters.approach_gain)) >> GAIN_BITS;
    by_ramp.min(i32::try_from(by_loop).unwrap_or(i32::MAX))
}
/// Whether the motor moves in the direction that is measured: at four times the velocity threshold,
/// which the end of a motion before does not reach.
fn moves(input: &Input, parameters: &Parameters) -> bool {
    input.velocity_actual.unsigned_abs() > parameters.velocity_threshold.saturating_mul(4)
}
