//! The H-bridge: what its timer does with the commands of the application.
//!
//! A command takes effect at the next edge of the PWM. Without one in a control period the bridge
//! is off in the next one: a stale duty must not be driven. After a trip it remains off until
//! the trip is taken.

pub use firmware::application::Bridge as Command;
use model_core::control::pwm_timer::CurrentInstant;

/// An H-bridge.
pub trait Bridge {
    /// Sets the state from the next edge on.
    fn command(&mut self, command: Command);

    /// Opens all switches at once, until the next command.
    fn off(&mut self);

    /// Closes both low sides from the next edge on.
    fn brake(&mut self) {
        self.command(Command::Brake);
    }

    /// Whether the over-current comparator has opened the switches since the last call.
    fn take_trip(&mut self) -> bool;
}

/// What a timer takes at an edge, in counts: on times of the two legs' high sides, and the
/// instant at which the current is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Compare {
    /// On time of leg A.
    pub leg_a: u16,
    /// On time of leg B.
    pub leg_b: u16,
    /// Count of the current's sample.
    pub sample: u16,
}

impl Compare {
    /// The leg of the voltage's sign switches; of the other one the low side is on.
    ///
    /// ```
    /// use drivers::bridge::{Command, Compare};
    /// use model_core::control::{pwm_timer::Modulator, units::percent};
    /// let compare = Modulator::default().next(percent(-10.0));
    /// let of_brake = Compare::of(Command::Brake);
    /// let compare = Compare::of(Command::Driven(compare));
    /// assert_eq!((compare.leg_a, compare.leg_b, compare.sample), (0, 5_600, 2_800));
    /// assert_eq!((of_brake.leg_a, of_brake.leg_b), (0, 0));
    /// ```
    #[inline]
    pub const fn of(command: Command) -> Self {
        let counts = match command {
            Command::Coast | Command::Brake => 0,
            Command::Driven(compare) => compare.get(),
        };
        let on = counts.unsigned_abs() as u16;
        let (leg_a, leg_b) = if counts < 0 { (0, on) } else { (on, 0) };
        Self {
            leg_a,
            leg_b,
            sample: CurrentInstant::of_on_time(on as u32).count() as u16,
        }
    }
}

/// The timer of the bridge.
pub trait PwmTimer {
    /// Sets what takes effect at the next edge, all of it together.
    fn set_compare(&mut self, compare: Compare);

    /// Connects the outputs to the timer, or opens all switches, at once.
    fn set_outputs(&mut self, are_on: bool);

    /// Whether the outputs are connected.
    fn are_outputs_on(&self) -> bool;

    /// Whether the break input has opened the switches since `clear_trip`.
    fn has_tripped(&self) -> bool;

    /// Clears that, unless the input is still active.
    fn clear_trip(&mut self);
}

/// The bridge of a timer.
#[derive(Debug)]
pub struct HBridge<T> {
    timer: T,
    /// Whether the outputs are on from the next edge on.
    is_enabled: bool,
    /// Whether the control step of this control period has set a command.
    was_commanded: bool,
}

impl<T: PwmTimer> HBridge<T> {
    /// The bridge of this timer, whose outputs are off.
    pub const fn new(timer: T) -> Self {
        Self {
            timer,
            is_enabled: false,
            was_commanded: false,
        }
    }

    /// The timer.
    pub fn timer(&mut self) -> &mut T {
        &mut self.timer
    }

    /// Whether the motor is driven or braked.
    pub fn is_on(&self) -> bool {
        self.is_enabled
    }

    /// Starts a control period. If the previous one had no command, the motor coasts.
    #[inline]
    pub fn begin_control_period(&mut self) {
        self.is_enabled &= self.was_commanded;
        self.was_commanded = false;
    }

    /// Starts an update period: the outputs follow the command, also after the coast window.
    #[inline]
    pub fn begin_pwm_period(&mut self) {
        if !self.is_enabled || self.timer.has_tripped() {
            self.timer.set_outputs(false);
            return;
        }
        self.timer.set_outputs(true);
        // The bridge may have tripped between the two lines above.
        if self.timer.has_tripped() {
            self.timer.set_outputs(false);
        }
    }
}

impl<T: PwmTimer> Bridge for HBridge<T> {
    #[inline]
    fn command(&mut self, command: Command) {
        self.is_enabled = command != Command::Coast;
        self.was_commanded = true;
        self.timer.set_compare(Compare::of(command));
    }

    fn off(&mut self) {
        self.is_enabled = false;
        self.timer.set_outputs(false);
    }

    /// While the break input is active the trip is set again, and the hardware keeps the outputs
    /// off.
    #[inline]
    fn take_trip(&mut self) -> bool {
        let tripped = self.timer.has_tripped();
        if tripped {
            self.timer.clear_trip();
        }
        tripped
    }
}
