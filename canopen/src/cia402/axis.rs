//! One axis: state machine, modes of operation and monitoring.

mod report;

use super::set_point::SetPoints;
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
    /// Velocity offset 60B1h, added in cyclic synchronous velocity mode.
    pub velocity_offset: i32,
    /// Position actual value 6064h.
    pub position_actual: i32,
    /// Velocity actual value 606Ch.
    pub velocity_actual: i32,
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
            position_actual: 0,
            velocity_actual: 0,
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
    /// Following error actual value 60F4h; 0 in velocity modes.
    pub following_error: i32,
    /// The following error exceeded its window for longer than its time-out: error code 8611h. The
    /// application decides whether this is a fault and passes it in [`Input::fault`] in the next
    /// period.
    pub following_error_exceeded: bool,
}

/// One axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Axis {
    machine: StateMachine,
    ramp: Ramp,
    set_points: SetPoints,
    mode: Option<Mode>,
    /// Cyclic synchronous position: the last target, and the control periods left to interpolate to
    /// it.
    command: i32,
    steps: u32,
    error_timer: HoldTimer,
    reached_timer: HoldTimer,
    slow_timer: HoldTimer,
}

/// Result of a mode in one control period.
#[derive(Clone, Copy, Default)]
struct ModeResult {
    /// A limit changed the target.
    limited: bool,
    /// The profile is complete.
    ended: bool,
    /// Position that bit 10 "target reached" compares with.
    target: i32,
}

impl Axis {
    /// At power-on.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// State of the drive state machine.
    #[must_use]
    pub const fn state(&self) -> Cia402State {
        self.machine.state()
    }

    /// Sets the demand to a position and velocity, and restarts the mode: for when a source other
    /// than this axis moves the motor.
    pub fn reset_demand(&mut self, position: i32, velocity: i32) {
        self.ramp = Ramp::moving(position, velocity);
        self.mode = None;
    }

    /// One control period.
    pub fn step(&mut self, input: &Input, parameters: &Parameters) -> Output {
        if !input.mode.is_position() {
            // The first position mode after this one starts from the actual position.
            self.ramp.set_position(input.position_actual);
        }
        let conditions = Conditions {
            initialised: input.initialised,
            voltage: input.voltage,
            fault: input.fault,
            standstill: self.ramp.is_stationary(),
        };
        let motion = self
            .machine
            .step(input.controlword, conditions, &parameters.options);
        let result = match motion {
            Motion::Off => {
                self.track_actual_position(input);
                ModeResult {
                    target: input.position_actual,
                    ..ModeResult::default()
                }
            }
            Motion::Stop(how) => {
                self.decelerate(how, parameters);
                ModeResult {
                    target: self.ramp.position(),
                    ..ModeResult::default()
                }
            }
            Motion::Run => self.run(input, parameters),
        };
        self.report(input, parameters, motion, result)
    }

    /// With the power stage off the position demand follows the actual position.
    fn track_actual_position(&mut self, input: &Input) {
        self.ramp = Ramp::at(input.position_actual);
        self.mode = None;
    }

    /// Starts a mode at the present position demand.
    fn start_mode(&mut self, input: &Input) {
        self.set_points
            .restart(self.ramp.position(), input.controlword);
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
        }
        match input.mode {
            Mode::None => {
                self.decelerate(Deceleration::SlowDown, parameters);
                ModeResult {
                    target: self.ramp.position(),
                    ..ModeResult::default()
                }
            }
            Mode::ProfilePosition => self.profile_position(input, parameters),
            Mode::CyclicPosition => self.cyclic_position(input, parameters),
            Mode::ProfileVelocity => {
                let (target, limited) =
                    within_velocity_limits(input.target_velocity, input, parameters);
                let limits = parameters.profile(u32::MAX);
                self.ramp.to_velocity(target, &limits, parameters.period_us);
                ModeResult {
                    limited,
                    ..ModeResult::default()
                }
            }
            Mode::CyclicVelocity => {
                let requested = input.target_velocity.saturating_add(input.velocity_offset);
                let (target, limited) = within_velocity_limits(requested, input, parameters);
                self.ramp.set_velocity(target, parameters.period_us);
                ModeResult {
                    limited,
                    ..ModeResult::default()
                }
            }
        }
    }

    fn profile_position(&mut self, input: &Input, parameters: &Parameters) -> ModeResult {
        let requested = self
            .set_points
            .step(input.controlword, input.target_position);
        let (target, limited) = parameters.within_position_limits(requested);
        let limits = parameters.profile(parameters.profile_velocity);
        let ended = self.ramp.to_position(target, &limits, parameters.period_us);
        if ended {
            self.set_points.reached();
        }
        ModeResult {
            limited,
            ended: ended && self.set_points.idle(),
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
        self.ramp
            .interpolate(target, self.steps, parameters.period_us);
        self.steps = self.steps.saturating_sub(1);
        ModeResult {
            limited,
            ended: false,
            target,
        }
    }
}

/// Limits a velocity to 607Fh and to one from which the axis can stop before the position limits;
/// returns it and whether it was changed.
fn within_velocity_limits(requested: i32, input: &Input, parameters: &Parameters) -> (i32, bool) {
    let top = i32::try_from(parameters.max_velocity).unwrap_or(i32::MAX);
    let mut velocity = requested.max(-top).min(top);
    if let Some((low, high)) = parameters.position_limits {
        let limit = if velocity < 0 { low } else { high };
        let beyond = if velocity < 0 {
            input.position_actual <= low
        } else {
            input.position_actual >= high
        };
        let fastest = if beyond {
            0
        } else {
            let rate = parameters.deceleration;
            Ramp::max_velocity_toward(input.position_actual, limit, rate, parameters.period_us)
        };
        velocity = velocity.max(-fastest).min(fastest);
    }
    (velocity, velocity != requested)
}
