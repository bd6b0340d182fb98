//! Sources of the setpoint, and bumpless changes between them.
//!
//! | source | followed | after a change to the source | stale |
//! |---|---|---|---|
//! | bus | at once | the last command stays until the next one | after `command_timeout_ms` |
//! | servo pulse | at once | approached at `approach_rate_deg_s` | after `command_timeout_ms` without a valid pulse |
//! | excitation | added to the command at its start | starts at the command | never; at its end the command is that at its start |
//!
//! When the loop is closed, the command starts at the measured angle, for every source. Only the
//! bus commands rates; meanwhile a change of the source starts from the measured angle.

pub mod excitation;
pub mod servo;

use model_core::control::{
    cascade::Setpoint,
    units::{Angle, Rate},
};

use self::{
    excitation::{Run, Running},
    servo::ServoPulse,
};
use crate::{
    interface::{CommandSource, TorqueSetpoint},
    parameters::{CommandSettings, ServoSettings},
    timing::{angle_per_period, periods},
};

/// Selects the setpoint from all sources and tracks the active source.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetpointSource {
    /// The selected source; a running excitation overrides it.
    source: CommandSource,
    /// The last commanded angle; the measured one while a rate is commanded.
    command: Angle,
    /// The last command of the bus.
    target: Setpoint,
    /// The torque that the bus commands instead.
    torque: Option<TorqueSetpoint>,
    /// Control periods since the last command of the source.
    age: u16,
    /// Whether the command has reached the angle of the servo pulse.
    has_reached_pulse: bool,
    servo: ServoPulse,
    running: Option<Running>,
}

impl SetpointSource {
    /// The state before the first command.
    pub fn new(settings: &CommandSettings) -> Self {
        Self {
            source: CommandSource::of(settings),
            command: Angle::ZERO,
            target: Angle::ZERO.into(),
            torque: None,
            age: 0,
            has_reached_pulse: false,
            servo: ServoPulse::default(),
            running: None,
        }
    }

    /// The active source: a running excitation, otherwise the selected source.
    pub fn source(&self) -> CommandSource {
        if self.running.is_some() {
            CommandSource::Excitation
        } else {
            self.source
        }
    }

    /// The selected source, which is active while no excitation runs.
    pub fn selected(&self) -> CommandSource {
        self.source
    }

    /// Whether the loop may be closed: the servo pulse must be present.
    pub fn may_start(&self) -> bool {
        self.source == CommandSource::Bus || self.servo.angle().is_some()
    }

    /// The last valid servo pulse, us; 0 before the first.
    pub fn servo_pulse_us(&self) -> u16 {
        self.servo.width_us()
    }

    /// Number of servo pulses with an invalid width.
    pub fn servo_glitches(&self) -> u32 {
        self.servo.glitches()
    }

    /// Restarts from this angle, for every source.
    pub fn hold(&mut self, angle: Angle) {
        self.running = None;
        self.command = angle;
        self.target = angle.into();
        self.torque = None;
        self.age = 0;
        self.has_reached_pulse = false;
    }

    /// Accepts a command of the bus; `false` if another source is active.
    pub fn take(&mut self, target: Setpoint) -> bool {
        self.accept(target, None)
    }

    /// The same with a torque, which acts as no loop does.
    pub fn take_torque(&mut self, torque: TorqueSetpoint) -> bool {
        self.accept(Rate::ZERO.into(), Some(torque))
    }

    fn accept(&mut self, target: Setpoint, torque: Option<TorqueSetpoint>) -> bool {
        let taken = self.source() == CommandSource::Bus;
        if taken {
            (self.target, self.torque) = (target, torque);
            self.age = 0;
        }
        taken
    }

    /// The torque that is commanded instead of the setpoint.
    pub fn torque(&self) -> Option<TorqueSetpoint> {
        self.torque.filter(|_| self.source() == CommandSource::Bus)
    }

    /// Selects another source; `false` for an excitation, which is started instead.
    pub fn switch(&mut self, source: CommandSource) -> bool {
        if source == CommandSource::Excitation {
            return false;
        }
        if source != self.source() {
            self.hold(self.command);
            self.source = source;
        }
        true
    }

    /// Starts an excitation around the present command; it replaces a running one.
    pub fn start(&mut self, run: Run) {
        self.running = Some(Running::new(run, self.command));
    }

    /// The running excitation.
    pub(crate) fn running(&mut self) -> Option<&mut Running> {
        self.running.as_mut()
    }

    /// Ends the excitation, if one runs.
    pub fn stop(&mut self) {
        if self.running.is_some() {
            self.hold(self.command);
        }
    }

    /// The setpoint of this control period, at a measured angle; `pulse_us` is a new servo pulse.
    pub fn next(
        &mut self,
        (settings, servo): (&CommandSettings, &ServoSettings),
        pulse_us: Option<u16>,
        measured: Angle,
    ) -> Setpoint {
        let is_valid = self.servo.update(servo, pulse_us);
        self.age = self.age.saturating_add(1);
        if self.servo.is_stale(settings) {
            self.servo.discard_angle();
            self.has_reached_pulse = false;
        }
        if let Some(running) = &mut self.running {
            match running.next() {
                Some(command) => {
                    self.command = command;
                    return command.into();
                }
                None => {
                    let base = running.base();
                    self.hold(base);
                }
            }
        }
        let setpoint = match self.source {
            CommandSource::ServoPulse => {
                if is_valid {
                    self.age = 0;
                }
                self.servo_command(settings).into()
            }
            CommandSource::Bus | CommandSource::Excitation => self.target,
        };
        self.command = setpoint.angle().unwrap_or(measured);
        setpoint
    }

    fn servo_command(&mut self, settings: &CommandSettings) -> Angle {
        let Some(target) = self.servo.angle() else {
            return self.command;
        };
        if self.has_reached_pulse {
            return target;
        }
        let distance = target.saturating_sub(self.command);
        let step = distance.limited(angle_per_period(settings.approach_rate_deg_s));
        self.has_reached_pulse = step == distance;
        // `step` is limited to `distance`, so the command does not pass the target.
        self.command.saturating_add(step)
    }

    /// The last commanded angle; the measured one while a rate is commanded.
    pub fn command(&self) -> Angle {
        self.command
    }

    /// Whether the last command of the selected source is older than the timeout.
    pub fn is_stale(&self, settings: &CommandSettings) -> bool {
        self.running.is_none()
            && settings.command_timeout_ms > 0
            && self.age > periods(settings.command_timeout_ms)
    }
}
