//! One axis: the state machine, the modes and what is watched.

mod report;

use super::set_point::SetPoints;
use super::window::Held;
use super::{
    Conditions, Deceleration, Fault, Limits, Mode, Motion, Parameters, Ramp, State, StateMachine,
};

/// What an axis needs in each period.
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
    /// A fault that is there now.
    pub fault: Fault,
    /// The supply of the power stage is there.
    pub voltage: bool,
    /// Initialisation is over.
    pub initialised: bool,
}

impl Default for Input {
    /// Nothing is commanded; the motor stands at zero, ready and with its supply.
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

/// What the loops are to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Demand {
    /// No power.
    Off,
    /// Hold a position that moves with a velocity.
    Position {
        /// Position demand value 6062h.
        position: i32,
        /// Its velocity.
        velocity: i32,
    },
    /// Velocity demand value 606Bh.
    Velocity(i32),
}

/// What an axis tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// State.
    pub state: State,
    /// Statusword 6041h.
    pub statusword: u16,
    /// Modes of operation display 6061h.
    pub mode_display: Mode,
    /// What the loops are to do.
    pub demand: Demand,
    /// Following error actual value 60F4h; 0 in velocity modes.
    pub following_error: i32,
    /// The following error was above its window for longer than its time out: error code 8611h. Whether
    /// that is a fault is the application's to say, by [`Input::fault`] of the next period.
    pub following_error_exceeded: bool,
}

/// State of one axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Axis {
    machine: StateMachine,
    ramp: Ramp,
    set_points: SetPoints,
    mode: Option<Mode>,
    /// Cyclic position: the last command, and periods until it is reached.
    command: i32,
    steps: u32,
    error_held: Held,
    reached_held: Held,
    slow_held: Held,
}

/// What a mode says in one period.
#[derive(Clone, Copy, Default)]
struct Course {
    /// A limit changed what was commanded.
    limited: bool,
    /// The profile has come to its end.
    ended: bool,
    /// What bit 10 compares the position with.
    target: i32,
}

impl Axis {
    /// At power-on.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// State.
    #[must_use]
    pub const fn state(&self) -> State {
        self.machine.state()
    }

    /// Something else moves the motor: the demand is where it is, with this velocity, and the mode begins anew.
    pub fn displace(&mut self, position: i32, velocity: i32) {
        self.ramp = Ramp::moving(position, velocity);
        self.mode = None;
    }

    /// One control period.
    pub fn step(&mut self, input: &Input, parameters: &Parameters) -> Output {
        if !input.mode.is_position() {
            // A mode that demands positions begins where the motor is then.
            self.ramp.set_position(input.position_actual);
        }
        let conditions = Conditions {
            initialised: input.initialised,
            voltage: input.voltage,
            fault: input.fault,
            standstill: self.ramp.stands(),
        };
        let motion = self
            .machine
            .step(input.controlword, conditions, &parameters.options);
        let course = match motion {
            Motion::Off => {
                self.stand(input);
                Course {
                    target: input.position_actual,
                    ..Course::default()
                }
            }
            Motion::Stop(how) => {
                self.slow_down(how, parameters);
                Course {
                    target: self.ramp.position(),
                    ..Course::default()
                }
            }
            Motion::Run => self.run(input, parameters),
        };
        self.tell(input, parameters, motion, course)
    }

    /// Without power the demand is where the motor is.
    fn stand(&mut self, input: &Input) {
        self.ramp = Ramp::at(input.position_actual);
        self.mode = None;
    }

    /// Begins a mode where the axis is.
    fn begin(&mut self, input: &Input) {
        self.set_points
            .restart(self.ramp.position(), input.controlword);
        self.command = self.ramp.position();
        self.steps = 0;
        self.mode = Some(input.mode);
    }

    fn slow_down(&mut self, how: Deceleration, parameters: &Parameters) {
        let deceleration = match how {
            Deceleration::SlowDown => parameters.deceleration,
            Deceleration::QuickStop => parameters.quick_stop_deceleration,
            Deceleration::Limit => {
                self.ramp.freeze();
                0
            }
        };
        let limits = Limits {
            velocity: u32::MAX,
            acceleration: deceleration,
            deceleration,
        };
        self.ramp.bound(parameters.max_velocity);
        self.ramp.to_velocity(0, &limits, parameters.period_us);
        self.command = self.ramp.position();
        self.steps = 0;
        // Only a halt, which is no state of its own, lets go on with what was under way.
        if self.machine.state() != State::OperationEnabled {
            self.mode = None;
        }
    }

    #[cfg_attr(target_os = "none", inline(never))]
    fn run(&mut self, input: &Input, parameters: &Parameters) -> Course {
        if self.mode != Some(input.mode) {
            self.begin(input);
        }
        match input.mode {
            Mode::None => {
                self.slow_down(Deceleration::SlowDown, parameters);
                Course {
                    target: self.ramp.position(),
                    ..Course::default()
                }
            }
            Mode::ProfilePosition => self.profile_position(input, parameters),
            Mode::CyclicPosition => self.cyclic_position(input, parameters),
            Mode::ProfileVelocity => {
                let (target, limited) = velocity_within(input.target_velocity, input, parameters);
                let limits = parameters.profile(u32::MAX);
                self.ramp.to_velocity(target, &limits, parameters.period_us);
                Course {
                    limited,
                    ..Course::default()
                }
            }
            Mode::CyclicVelocity => {
                let wanted = input.target_velocity.saturating_add(input.velocity_offset);
                let (target, limited) = velocity_within(wanted, input, parameters);
                self.ramp.take_velocity(target, parameters.period_us);
                Course {
                    limited,
                    ..Course::default()
                }
            }
        }
    }

    fn profile_position(&mut self, input: &Input, parameters: &Parameters) -> Course {
        let wanted = self
            .set_points
            .step(input.controlword, input.target_position);
        let (target, limited) = parameters.limited(wanted);
        let limits = parameters.profile(parameters.profile_velocity);
        let ended = self.ramp.to_position(target, &limits, parameters.period_us);
        if ended {
            self.set_points.reached();
        }
        Course {
            limited,
            ended: ended && self.set_points.idle(),
            target,
        }
    }

    fn cyclic_position(&mut self, input: &Input, parameters: &Parameters) -> Course {
        let (target, limited) = parameters.limited(input.target_position);
        if target != self.command {
            self.command = target;
            self.steps = parameters
                .interpolation_us
                .div_ceil(parameters.period_us.max(1));
        }
        self.ramp
            .interpolate(target, self.steps, parameters.period_us);
        self.steps = self.steps.saturating_sub(1);
        Course {
            limited,
            ended: false,
            target,
        }
    }
}

/// A velocity within 607Fh that still can stop before the position limits, and whether that changed it.
fn velocity_within(wanted: i32, input: &Input, parameters: &Parameters) -> (i32, bool) {
    let top = i32::try_from(parameters.max_velocity).unwrap_or(i32::MAX);
    let mut velocity = wanted.max(-top).min(top);
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
            Ramp::fastest_toward(input.position_actual, limit, rate, parameters.period_us)
        };
        velocity = velocity.max(-fastest).min(fastest);
    }
    (velocity, velocity != wanted)
}
