//! The whole control step, coefficients and state apart.

use super::{
    arithmetic::Coefficient,
    compare::{Compare, Modulator},
    encoder_word::{COUNT_DEG, EncoderCount, EncoderError, EncoderReading, EncoderWord},
    parameters::ControlParameters,
    position_loop::{PositionLoop, WIDEST_RATE},
    rate_estimate::{FilterShare, RateEstimate},
    rate_loop::{RateLoop, RateLoopState},
    shaft_angle::{Mounting, ShaftAngle},
    units::{Angle, Percent, Rate, angle, hold_between, percent, round},
};
use crate::{
    limits::within,
    parameter::{Parameter, ParameterError},
    time::CONTROL_PERIOD_S,
};

mod single_precision;

/// From one end of the duty to the other: no limit to its change.
const WIDEST_STEP: Percent = Percent::const_from_int(200);

/// Everything that does not change from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficients {
    mounting: Mounting,
    filter: FilterShare,
    position: PositionLoop,
    rate: RateLoop,
}

impl Coefficients {
    /// The coefficients for these parameters, also in constant expressions: a board needs no
    /// floating point for its defaults.
    ///
    /// # Errors
    /// A [`ParameterError`] that names the parameter which is NaN, out of its range or at odds
    /// with another.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    ///
    /// let narrow = ControlParameters { position_min_deg: 10.0, ..Default::default() };
    /// assert!(Coefficients::try_new(&narrow).is_ok());
    /// let crossed = ControlParameters { position_max_deg: 9.0, ..narrow };
    /// assert_eq!(
    ///     Coefficients::try_new(&crossed).unwrap_err().to_string(),
    ///     "position_min_deg is above position_max_deg",
    /// );
    /// ```
    pub const fn try_new(parameters: &ControlParameters) -> Result<Self, ParameterError> {
        if let Err(error) = parameters.check() {
            return Err(error);
        }
        let p = parameters;
        if p.position_min_deg > p.position_max_deg {
            let (low, high) = ("position_min_deg", "position_max_deg");
            return Err(ParameterError::Disordered { low, high });
        }
        if p.encoder_direction != 1.0 && p.encoder_direction != -1.0 {
            return Err(ParameterError::NotAllowed {
                name: "encoder_direction",
                value: p.encoder_direction,
                allowed: "1 or -1",
            });
        }
        Ok(Self {
            mounting: mounting(p),
            filter: FilterShare::new(p.rate_filter),
            position: position_loop(p),
            rate: rate_loop(p),
        })
    }

    /// Whether an angle means the same under others: the encoder's zero and sense are equal.
    pub fn has_mounting_of(&self, other: &Self) -> bool {
        self.mounting == other.mounting
    }

    /// The command that the position limits leave of this one.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters, units::angle};
    ///
    /// let p = ControlParameters { position_max_deg: 60.0, ..ControlParameters::DEFAULT };
    /// assert_eq!(Coefficients::try_new(&p).unwrap().reachable(angle(90.0)), 60);
    /// ```
    pub fn reachable(&self, command: Angle) -> Angle {
        within(command, self.position.min, self.position.max)
    }
}

const fn mounting(p: &ControlParameters) -> Mounting {
    // -180 deg to 180 deg are -2048 to 2048 counts, of which `new` keeps the 12 bits.
    let zero = round(p.encoder_zero_deg / COUNT_DEG) as i32;
    Mounting {
        zero: EncoderCount::new(zero as u16),
        reversed: p.encoder_direction < 0.0,
    }
}

const fn position_loop(p: &ControlParameters) -> PositionLoop {
    PositionLoop {
        gain: Coefficient::new(p.position_gain),
        min: angle(p.position_min_deg),
        max: angle(p.position_max_deg),
        rate_up: least(percent(p.rate_command_limit_up_deg_s), WIDEST_RATE),
        rate_down: least(percent(p.rate_command_limit_down_deg_s), WIDEST_RATE),
    }
}

const fn rate_loop(p: &ControlParameters) -> RateLoop {
    RateLoop {
        proportional: Coefficient::new(p.proportional_gain),
        integral: Coefficient::new(p.integral_gain * CONTROL_PERIOD_S),
        anti_windup: Coefficient::new(p.anti_windup_gain * CONTROL_PERIOD_S),
        feed_forward: Coefficient::new(p.feed_forward_gain),
        duty_limit: percent(p.duty_limit_pct),
        duty_step: least(percent(p.duty_slew_pct_s * CONTROL_PERIOD_S), WIDEST_STEP),
    }
}

const fn least(a: Percent, b: Percent) -> Percent {
    if a.to_bits() < b.to_bits() { a } else { b }
}

/// What the controller remembers from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CascadeState {
    shaft: ShaftAngle,
    rate: RateEstimate,
    regulator: RateLoopState,
    modulator: Modulator,
    /// The last command, which a change of gains needs; none while the bridge is off.
    command: Option<Angle>,
}

/// What one control step decided; nothing, by default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CascadeStep {
    /// The commanded rate after its limit, deg/s.
    pub rate_command: Rate,
    /// The duty, %.
    pub duty: Percent,
    /// The duty as the timer takes it; in force from the next PWM edge.
    pub compare: Compare,
    /// Which limits acted.
    pub limits: ActiveLimits,
}

/// The limits that acted in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ActiveLimits {
    /// The position limit held the command.
    pub position: bool,
    /// The rate limit held the commanded rate.
    pub rate: bool,
    /// The duty limit held the duty.
    pub duty: bool,
    /// The slew limit held the duty.
    pub slew: bool,
}

/// What the loops are closed around.
#[derive(Clone, Copy)]
enum Setpoint {
    Angle(Angle),
    Rate(Rate),
}

impl CascadeState {
    /// Takes the encoder's word: once in each control period, before [`CascadeState::regulate`].
    ///
    /// A word that is not valid leaves angle and rate as they were.
    ///
    /// # Errors
    /// Why the word is not valid.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn observe(
        &mut self,
        coefficients: &Coefficients,
        word: EncoderWord,
    ) -> Result<EncoderReading, EncoderError> {
        let reading = word.read().inspect_err(|_| self.shaft.lost())?;
        let motion = self.shaft.reading(coefficients.mounting, reading.count);
        self.rate.update(coefficients.filter, motion);
        Ok(reading)
    }

    /// Closes both loops once around what was observed.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, EncoderWord::of(EncoderCount::new(0), Magnet::Steady)).unwrap();
    /// let step = state.regulate(&gains, model_core::control::units::angle(1.0));
    /// assert_eq!(step.rate_command, 8.0);
    /// assert_eq!(step.compare.get(), 5906); // 8 deg/s * 1.3182 %/(deg/s) * 560 counts/%
    /// ```
    #[inline(always)]
    pub fn regulate(&mut self, coefficients: &Coefficients, command: Angle) -> CascadeStep {
        self.close(coefficients, Setpoint::Angle(command))
    }

    /// Closes the inner loop alone, around a commanded rate; held within 2^17 deg/s.
    ///
    /// Between this and [`CascadeState::regulate`] the duty does not jump by more than the commanded rate
    /// asks for: the integrator is the same. [`CascadeState::retune`] finds no command to keep then.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, EncoderWord::of(EncoderCount::new(0), Magnet::Steady)).unwrap();
    /// let step = state.regulate_rate(&gains, model_core::control::units::Rate::from_num(8));
    /// assert_eq!(step.compare.get(), 5906); // as a command of 1 deg gives with a gain of 8/s
    /// ```
    #[inline(always)]
    pub fn regulate_rate(&mut self, coefficients: &Coefficients, rate: Rate) -> CascadeStep {
        self.close(coefficients, Setpoint::Rate(rate))
    }

    /// Closes the loops, in one function for both: on the board nearly all of a control law's time is spent here.
    #[cfg_attr(target_os = "none", inline(never))]
    fn close(&mut self, coefficients: &Coefficients, setpoint: Setpoint) -> CascadeStep {
        let mut limits = ActiveLimits::default();
        let rate_command = match setpoint {
            Setpoint::Angle(command) => {
                self.command = Some(command);
                let wanted = coefficients
                    .position
                    .rate_command(command, self.shaft.angle());
                limits.position = wanted.position_limited;
                limits.rate = wanted.rate_limited;
                wanted.rate
            }
            Setpoint::Rate(mut rate) => {
                self.command = None;
                limits.rate = hold_between(&mut rate, WIDEST_RATE, WIDEST_RATE);
                rate
            }
        };
        let gains = &coefficients.rate;
        let limited = self.regulator.step(gains, rate_command, self.rate());
        limits.duty = limited.duty_limited;
        limits.slew = limited.slew_limited;
        CascadeStep {
            rate_command,
            duty: limited.duty,
            compare: self.modulator.next(limited.duty),
            limits,
        }
    }

    /// Lets go of what the regulator holds, for the time in which the bridge is off: the integrator
    /// is emptied, angle and rate are kept.
    pub fn release(&mut self) {
        self.regulator = RateLoopState::default();
        self.command = None;
    }

    /// Forgets the angle: the next valid word is taken to lie within half a turn of zero again.
    pub fn reset_position(&mut self) {
        self.shaft = ShaftAngle::default();
    }

    /// Goes over from old to new coefficients without a jump of the duty. With another zero or
    /// direction of the encoder the angle is another one: it is taken anew from the next word. While the bridge is off
    /// there is no duty to keep, and the integrator stays empty.
    pub fn retune(&mut self, old: &Coefficients, new: &Coefficients) {
        if old.mounting != new.mounting {
            self.reset_position();
        }
        let Some(command) = self.command else {
            return;
        };
        let wanted = |under: &Coefficients| {
            let mut tried = *self;
            tried.regulate(under, command);
            tried.regulator.wanted()
        };
        let jump = wanted(new) - wanted(old);
        self.regulator.absorb(jump);
    }

    /// The measured angle, deg.
    pub fn angle(&self) -> Angle {
        self.shaft.angle()
    }

    /// The estimated rate, deg/s.
    pub fn rate(&self) -> Rate {
        self.rate.rate()
    }

    /// Whether the angle is known: there was a valid word.
    pub fn is_position_known(&self) -> bool {
        self.shaft.is_known()
    }
}
