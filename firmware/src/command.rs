//! Where the commanded angle comes from, without a jump where the source changes.
//!
//! | source | followed | after another source | stale |
//! |---|---|---|---|
//! | bus | at once | the command stays until the next one comes | after `command_timeout_ms` |
//! | servo pulse | at once | approached at `approach_rate_deg_s` | after `command_timeout_ms` without a valid pulse |
//! | excitation | added to the command at its start | starts where the command is | never; at its end the command is that at its start |
//!
//! When the loop is closed the command is the measured angle, whatever the source.

pub mod excitation;
pub mod servo;

use model_core::control::units::{Angle, held};

use self::{
    excitation::{Run, Running},
    servo::ServoPulse,
};
use crate::{
    interface::CommandSource,
    parameters::{BoardParameters, CommandSettings},
    timing::{angle_per_period, periods},
};

/// Makes one commanded angle of all sources.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetpointSource {
    /// The source but for an excitation.
    source: CommandSource,
    /// What was commanded last.
    command: Angle,
    /// What the bus wants.
    target: Angle,
    /// Control periods since a command of the source.
    age: u16,
    /// Whether the command has reached that of the servo pulse.
    joined: bool,
    servo: ServoPulse,
    running: Option<Running>,
}

impl SetpointSource {
    /// No command yet.
    pub fn new(settings: &CommandSettings) -> Self {
        Self {
            source: if settings.command_source == 1 {
                CommandSource::ServoPulse
            } else {
                CommandSource::Bus
            },
            command: Angle::ZERO,
            target: Angle::ZERO,
            age: 0,
            joined: false,
            servo: ServoPulse::default(),
            running: None,
        }
    }

    /// The source that is in force.
    pub fn source(&self) -> CommandSource {
        if self.running.is_some() {
            CommandSource::Excitation
        } else {
            self.source
        }
    }

    /// Whether the bus commands, or would but for an excitation.
    pub fn is_of_the_bus(&self) -> bool {
        self.source == CommandSource::Bus
    }

    /// Whether there is a command to start from: the servo pulse has to be there.
    pub fn may_start(&self) -> bool {
        self.is_of_the_bus() || self.servo.angle().is_some()
    }

    /// The last valid servo pulse, us; 0 before the first.
    pub fn servo_pulse_us(&self) -> u16 {
        self.servo.width_us()
    }

    /// Servo pulses so far whose width was none.
    pub fn servo_glitches(&self) -> u32 {
        self.servo.glitches()
    }

    /// Starts over from this angle, with whatever source.
    pub fn hold(&mut self, angle: Angle) {
        self.running = None;
        self.command = angle;
        self.target = angle;
        self.age = 0;
        self.joined = false;
    }

    /// Takes a command of the bus; `false` where commands come from elsewhere.
    pub fn take(&mut self, target: Angle) -> bool {
        let taken = self.source() == CommandSource::Bus;
        if taken {
            self.target = target;
            self.age = 0;
        }
        taken
    }

    /// Goes over to another source; `false` where that is none to go over to.
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

    /// Starts an excitation around the present command; one that runs is replaced.
    pub fn start(&mut self, run: Run) {
        self.running = Some(Running::new(run, self.command));
    }

    /// The excitation that runs.
    pub(crate) fn running(&mut self) -> Option<&mut Running> {
        self.running.as_mut()
    }

    /// Ends the excitation, if one runs.
    pub fn stop(&mut self) {
        if self.running.is_some() {
            self.hold(self.command);
        }
    }

    /// The command of this control period; `pulse_us` is the servo pulse that came, if one did.
    pub fn next(&mut self, parameters: &BoardParameters, pulse_us: Option<u16>) -> Angle {
        let pulse = self.servo.update(&parameters.servo, pulse_us);
        self.age = self.age.saturating_add(1);
        if self.servo.is_stale(&parameters.command) {
            self.servo.forget();
            self.joined = false;
        }
        if let Some(running) = &mut self.running {
            match running.next() {
                Some(command) => {
                    self.command = command;
                    return command;
                }
                None => {
                    let base = running.base();
                    self.hold(base);
                }
            }
        }
        self.command = match self.source {
            CommandSource::ServoPulse => {
                if pulse {
                    self.age = 0;
                }
                self.servo_command(&parameters.command)
            }
            CommandSource::Bus | CommandSource::Excitation => self.target,
        };
        self.command
    }

    fn servo_command(&mut self, settings: &CommandSettings) -> Angle {
        let Some(wanted) = self.servo.angle() else {
            return self.command;
        };
        if self.joined {
            return wanted;
        }
        let step = angle_per_period(settings.approach_rate_deg_s);
        let way = wanted.saturating_sub(self.command);
        let step = held(way, step);
        self.joined = step == way;
        // Not further than where it is wanted.
        self.command.saturating_add(step)
    }

    /// Whether the source has been silent for too long.
    pub fn is_stale(&self, settings: &CommandSettings) -> bool {
        self.running.is_none()
            && settings.command_timeout_ms > 0
            && self.age > periods(settings.command_timeout_ms)
    }
}
