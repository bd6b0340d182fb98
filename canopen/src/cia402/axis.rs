//! One axis: state machine, modes of operation and monitoring.

mod homing;
mod modes;
mod report;

use super::homing::Homing;
use super::set_point::SetPoints;
use super::smooth::SmoothProfile;
use super::window::HoldTimer;
use super::{
    Cia402State, Conditions, Deceleration, Fault, Limits, Mode, Motion, Parameters, Ramp,
    StateMachine,
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
    /// Velocity offset 60B1h, added in cyclic synchronous velocity mode; [`Axis::offsets`] has that
    /// of cyclic synchronous position mode.
    pub velocity_offset: i32,
    /// Target torque 6071h and, in cyclic synchronous torque mode, torque offset 60B2h; thousandths
    /// of the rated torque.
    pub target_torque: i16,
    /// 607Ah was written since the last period, by whatever value.
    pub is_new_position: bool,
    /// 60FFh or 60B1h was written since the last period, by whatever value.
    pub is_new_velocity: bool,
    /// 6071h or 60B2h was written since the last period, by whatever value.
    pub is_new_torque: bool,
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
            target_torque: 0,
            is_new_position: false,
            is_new_velocity: false,
            is_new_torque: false,
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
    /// Torque.
    Torque {
        /// Torque demand value 6074h.
        torque: i16,
        /// Least and greatest velocity at which it acts: beyond them the motor brakes.
        velocities: (i32, i32),
    },
}

/// What cyclic synchronous modes add to the outputs of outer control loops (IEC 61800-7-201).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Offsets {
    /// Added to the output of the position loop: velocity offset 60B1h of cyclic synchronous
    /// position mode.
    pub velocity: i32,
    /// Added to the output of the velocity loop: torque offset 60B2h of the cyclic synchronous
    /// modes of position and velocity; thousandths of the rated torque.
    pub torque: i16,
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

/// One axis, with a control period of `PERIOD_US` microseconds, 2 to 65,535.
///
/// A mode starts when operation is enabled, after a quick stop and with each change of 6060h. It
/// starts at the actual position and holds it: a target acts once it has been written in a later
/// period than that in which the mode started. A target that was written before, in another mode or
/// while the power was off, moves nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Axis<const PERIOD_US: u32> {
    machine: StateMachine,
    ramp: Ramp<PERIOD_US>,
    set_points: SetPoints,
    smooth: Option<SmoothProfile<PERIOD_US>>,
    homing: Homing,
    origin: i32,
    mode: Option<Mode>,
    /// A target has been written since the mode started.
    has_target: bool,
    /// Cyclic synchronous position: the last target, and the control periods left to interpolate to
    /// it.
    command: i32,
    steps: u32,
    /// The torque demand, millionths of the rated torque.
    torque: i32,
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
    /// Least and greatest velocity at which a torque acts; `None` in modes without one, and until
    /// a target torque is written.
    velocities: Option<(i32, i32)>,
}

/// A thousandth of the rated torque in units of [`Axis::torque`].
const TORQUE_UNIT: i32 = 1_000;

impl<const PERIOD_US: u32> Axis<PERIOD_US> {
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

    /// Sets the demand to a position of the encoder and a velocity, and restarts the mode: for when
    /// a source other than this axis moves the motor.
    pub fn reset_demand(&mut self, position: i32, velocity: i32) {
        self.ramp = Ramp::moving(position.saturating_add(self.origin), velocity);
        self.mode = None;
    }

    /// One control period.
    pub fn step(&mut self, mut input: Input, parameters: &Parameters) -> Output {
        input.position_actual = input.position_actual.saturating_add(self.origin);
        let input = &mut input;
        if !input.mode.is_position() {
            // The first position mode after this one starts from the actual position.
            self.ramp.set_position(input.position_actual);
        }
        let slow = input.velocity_actual.unsigned_abs() <= parameters.velocity_threshold;
        let slow_ms = parameters.velocity_threshold_time_ms;
        self.is_slow = (self.slow_timer).step::<PERIOD_US>(slow, slow_ms);
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
        self.is_stop_over = (self.stop_timer).step::<PERIOD_US>(goes_on, stop_ms);
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
                self.torque = 0;
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
        if !input.mode.is_position() && result.velocities.is_none() {
            result.limited |= self.approach_limits(input, parameters);
        }
        self.homing.track(input.controlword);
        self.report(input, parameters, motion, result)
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
        self.homing.restart(input.controlword, self.mode.is_none());
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
        self.ramp.to_velocity(0, &limits);
        self.command = self.ramp.position();
        self.steps = 0;
        // Motion resumes only after a halt, which is not a state of its own.
        if self.machine.state() != Cia402State::OperationEnabled {
            self.mode = None;
        }
    }
}

/// Whether the motor moves in the direction that is measured: at four times the velocity threshold,
/// which the end of a motion before does not reach.
fn moves(input: &Input, parameters: &Parameters) -> bool {
    input.velocity_actual.unsigned_abs() > parameters.velocity_threshold.saturating_mul(4)
}
