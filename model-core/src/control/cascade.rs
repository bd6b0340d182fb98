//! The whole control step. Coefficients and state are separate types.

use super::{
    arithmetic::Gain,
    encoder_correction::EncoderCorrection,
    encoder_word::{COUNT_DEG, EncoderCount},
    parameters::ControlParameters,
    position_loop::{PositionLoop, RATE_END, RateCommand},
    rate_estimate::{FilterShare, RateEstimate, SLOW_FILTER},
    rate_loop::{RateLoop, RateLoopState},
    shaft_tracker::{Mounting, ShaftTracker},
    units::{Angle, Percent, Rate, angle, limit_between, percent, rate, round},
};
use crate::{
    limits::within,
    parameter::{Parameter, ParameterError},
    time::CONTROL_PERIOD_S,
};

mod signals;
mod single_precision;

pub use signals::{ActiveLimits, CascadeStep, Setpoint};

/// From one end of the duty range to the other: no limit to its change.
const DUTY_STEP_END: Percent = Percent::from_int(200);

/// Everything that does not change from step to step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Coefficients {
    pub(super) mounting: Mounting,
    pub(super) filter: FilterShare,
    pub(super) position: PositionLoop,
    pub(super) rate: RateLoop,
}

impl Coefficients {
    /// Those of the default parameters.
    pub const DEFAULT: Self = match Self::try_new(&ControlParameters::DEFAULT) {
        Ok(coefficients) => coefficients,
        Err(_) => panic!("a default is out of its range"),
    };

    /// The coefficients for these parameters, also in constant expressions: a board needs no
    /// floating point for its defaults.
    ///
    /// # Errors
    /// A [`ParameterError`] that names the parameter which is NaN, out of its range or inconsistent
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
            filter: <FilterShare>::new(p.rate_filter),
            position: position_loop(p),
            rate: rate_loop(p),
        })
    }

    /// How the encoder is mounted.
    pub const fn mounting(&self) -> Mounting {
        self.mounting
    }

    /// Whether the encoder's zero and direction are those of `other`: then angles are comparable.
    pub fn has_mounting_of(&self, other: &Self) -> bool {
        self.mounting == other.mounting
    }

    /// Whether the encoder counts against the shaft's direction.
    pub fn is_reversed(&self) -> bool {
        self.mounting.reversed
    }

    /// The command limited to the position limits.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters, units::angle};
    ///
    /// let p = ControlParameters { position_max_deg: 60.0, ..ControlParameters::DEFAULT };
    /// assert_eq!(Coefficients::try_new(&p).unwrap().reachable(angle(90.0)), angle(60.0));
    /// ```
    pub fn reachable(&self, command: Angle) -> Angle {
        within(command, self.position.min, self.position.max)
    }

    /// Greatest magnitude of the duty, 0 to 100 %.
    ///
    /// ```
    /// use model_core::control::{cascade::Coefficients, parameters::ControlParameters};
    /// use model_core::control::units::percent;
    ///
    /// let p = ControlParameters { duty_limit_pct: 20.0, ..ControlParameters::DEFAULT };
    /// assert_eq!(Coefficients::try_new(&p).unwrap().duty_limit(), percent(20.0));
    /// ```
    pub const fn duty_limit(&self) -> Percent {
        self.rate.duty_limit
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
        gain: Gain::new(p.position_gain),
        min: angle(p.position_min_deg),
        max: angle(p.position_max_deg),
        rate_up: rate(p.rate_command_limit_up_deg_s).at_most(RATE_END),
        rate_down: rate(p.rate_command_limit_down_deg_s).at_most(RATE_END),
    }
}

const fn rate_loop(p: &ControlParameters) -> RateLoop {
    RateLoop {
        proportional: Gain::new(p.proportional_gain),
        integral: Gain::new(p.integral_gain * CONTROL_PERIOD_S),
        anti_windup: Gain::new(p.anti_windup_gain * CONTROL_PERIOD_S),
        feed_forward: Gain::new(p.feed_forward_gain),
        duty_limit: percent(p.duty_limit_pct),
        duty_step: percent(p.duty_slew_pct_s * CONTROL_PERIOD_S).at_most(DUTY_STEP_END),
    }
}

/// The state of the controller between two steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CascadeState {
    shaft: ShaftTracker,
    rate: RateEstimate,
    regulator: RateLoopState,
    /// The last setpoint, which a change of gains needs; `None` while the bridge is off.
    setpoint: Option<Setpoint>,
}

impl Default for CascadeState {
    // Not inlined: it is then written where it stays, not copied.
    #[cfg_attr(target_os = "none", inline(never))]
    fn default() -> Self {
        Self {
            shaft: ShaftTracker::default(),
            rate: RateEstimate::default(),
            regulator: RateLoopState::default(),
            setpoint: None,
        }
    }
}

impl CascadeState {
    /// Takes the encoder's count: once in each control period, before [`CascadeState::regulate`].
    /// Without a valid count angle and rate stay as they are.
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn observe(&mut self, coefficients: &Coefficients, count: Option<EncoderCount>) {
        self.take(coefficients.mounting, coefficients.filter, count);
    }

    /// The same where another sensor knows by how much the rate has changed since the last control
    /// period: the rate changes by that, also without a count, and follows the encoder slowly.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    /// use model_core::control::units::rate;
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe_change(&gains, Some(EncoderCount::new(0)), rate(90.0));
    /// state.observe_change(&gains, None, rate(-20.0));
    /// // The encoder has not turned at the first count: less by 5 % of 90 deg/s at 250 Hz.
    /// assert!((state.rate().to_f64() - 65.5).abs() < 1e-6);
    /// ```
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn observe_change(
        &mut self,
        coefficients: &Coefficients,
        count: Option<EncoderCount>,
        change: Rate,
    ) {
        self.rate.change(change);
        self.take(coefficients.mounting, SLOW_FILTER, count);
    }

    #[inline(always)]
    fn take(&mut self, mounting: Mounting, filter: FilterShare, count: Option<EncoderCount>) {
        match count {
            Some(count) => {
                let motion = self.shaft.update(mounting, count);
                self.rate.update(filter, motion);
            }
            None => self.shaft.miss(1),
        }
    }

    /// Corrects the angle of the last count: in each control period, after
    /// [`CascadeState::observe`].
    pub fn correct(&mut self, correction: &EncoderCorrection) {
        self.shaft.correct(correction);
    }

    /// Counts control periods that did not run: the next difference of counts spans them too.
    pub fn miss(&mut self, periods: u16) {
        self.shaft.miss(periods);
    }

    /// Closes the loops once around a setpoint, an angle or a rate. The limits of position, rate,
    /// duty and slew apply to both. The integrator is shared, so that a change between them does
    /// not make the duty jump by more than the commanded rate does.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    /// use model_core::control::units::{angle, percent, rate};
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, Some(EncoderCount::new(0)));
    /// let mut other = state;
    /// let step = state.regulate(&gains, angle(1.0));
    /// assert_eq!(step.rate_command, rate(8.0));
    /// assert!((step.duty.to_f64() - 8.0 * 10.0 / 7.586).abs() < 1e-8);
    /// assert_eq!(other.regulate(&gains, rate(8.0)), step);
    /// ```
    #[inline(always)]
    pub fn regulate(
        &mut self,
        coefficients: &Coefficients,
        setpoint: impl Into<Setpoint>,
    ) -> CascadeStep {
        self.close(coefficients, setpoint.into())
    }

    /// Closes the loops once around an angle that moves at this rate: it is added to the commanded
    /// one, within the same limits, but not beyond a position limit.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    /// use model_core::control::units::{angle, rate};
    ///
    /// let p = ControlParameters { position_max_deg: 10.0, ..Default::default() };
    /// let gains = Coefficients::try_new(&p).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, Some(EncoderCount::new(0)));
    /// assert_eq!(state.track(&gains, angle(5.0), rate(60.0)).rate_command, rate(100.0));
    /// assert_eq!(state.track(&gains, angle(11.0), rate(60.0)).rate_command, rate(80.0));
    /// ```
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn track(&mut self, coefficients: &Coefficients, angle: Angle, rate: Rate) -> CascadeStep {
        let position = &coefficients.position;
        let command = position.follow_angle(angle, self.shaft.angle());
        let command = position.with_rate(command, rate);
        // A change of gains maintains the duty of this rate.
        self.setpoint = Some(Setpoint::Rate(command.rate));
        self.close_rate_loop(coefficients, command)
    }

    /// Closes the rate loop around a rate to which neither position nor rate limits apply: the ramp
    /// of a stop, which starts at the measured rate. Limited to 2^17 deg/s.
    #[inline(always)]
    pub fn decelerate(&mut self, coefficients: &Coefficients, mut rate: Rate) -> CascadeStep {
        self.setpoint = None;
        let rate_limited = limit_between(&mut rate, RATE_END, RATE_END);
        self.close_rate_loop(
            coefficients,
            RateCommand {
                rate,
                position_limited: false,
                rate_limited,
            },
        )
    }

    /// One function for all callers: on the board nearly all time of the control law is spent here.
    #[cfg_attr(target_os = "none", inline(never))]
    fn close(&mut self, coefficients: &Coefficients, setpoint: Setpoint) -> CascadeStep {
        self.setpoint = Some(setpoint);
        let position = &coefficients.position;
        let command = match setpoint {
            Setpoint::Angle(angle) => position.follow_angle(angle, self.shaft.angle()),
            Setpoint::Rate(rate) => position.follow_rate(rate, self.shaft.angle()),
        };
        self.close_rate_loop(coefficients, command)
    }

    #[inline(always)]
    fn close_rate_loop(
        &mut self,
        coefficients: &Coefficients,
        command: RateCommand,
    ) -> CascadeStep {
        let limited = self
            .regulator
            .regulate(&coefficients.rate, command.rate, self.rate());
        CascadeStep {
            rate_command: command.rate,
            duty: limited.duty,
            limits: ActiveLimits {
                position: command.position_limited,
                rate: command.rate_limited,
                duty: limited.duty_limited,
                slew: limited.slew_limited,
                current: false,
            },
        }
    }

    /// Applies a duty that the loops have not computed, within the limits of duty and slew. The
    /// integrator of the rate loop continues from `rest`, the duty without a torque: what follows
    /// does not start with the duty that accelerated the shaft.
    ///
    /// ```
    /// use model_core::control::{cascade::*, parameters::ControlParameters, units::percent};
    ///
    /// let p = ControlParameters { duty_limit_pct: 20.0, ..Default::default() };
    /// let gains = Coefficients::try_new(&p).unwrap();
    /// let step = CascadeState::default().follow_duty(&gains, percent(-30.0), percent(0.0));
    /// assert_eq!((step.duty, step.limits.duty), (percent(-20.0), true));
    /// ```
    #[cfg_attr(target_os = "none", inline(never))]
    pub fn follow_duty(
        &mut self,
        coefficients: &Coefficients,
        duty: Percent,
        rest: Percent,
    ) -> CascadeStep {
        let limited = self.regulator.limited(&coefficients.rate, duty);
        self.regulator = RateLoopState::of(rest, limited.duty);
        self.setpoint = None;
        CascadeStep {
            rate_command: Rate::ZERO,
            duty: limited.duty,
            limits: ActiveLimits {
                duty: limited.duty_limited,
                slew: limited.slew_limited,
                ..ActiveLimits::default()
            },
        }
    }

    /// This rate within the limits of rate, and of position where the shaft is.
    pub fn permitted(&self, coefficients: &Coefficients, rate: Rate) -> Rate {
        let position = &coefficients.position;
        position.follow_rate(rate, self.shaft.angle()).rate
    }

    /// Limits the duty of the step that was made last, from the least to the most: as the duty
    /// limit does, but for what changes with the motion.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    /// use model_core::control::units::{angle, percent};
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, Some(EncoderCount::new(0)));
    /// let mut step = state.regulate(&gains, angle(90.0));
    /// assert_eq!(step.duty, percent(100.0));
    /// state.limit_duty(&gains, &mut step, (percent(-20.0), percent(60.0)));
    /// assert_eq!((step.duty, step.limits.current), (percent(60.0), true));
    /// ```
    pub fn limit_duty(
        &mut self,
        coefficients: &Coefficients,
        step: &mut CascadeStep,
        window: (Percent, Percent),
    ) {
        if let Some(duty) = self.regulator.limit_duty(&coefficients.rate, window) {
            step.duty = duty;
            step.limits.current = true;
        }
    }

    /// Adds the change of a duty that is fed forward: it acts in the next step, and from then on,
    /// as if it was added to the output of the rate loop.
    ///
    /// ```
    /// use model_core::control::{cascade::*, encoder_word::*, parameters::ControlParameters};
    /// use model_core::control::units::{angle, percent};
    ///
    /// let gains = Coefficients::try_new(&ControlParameters::default()).unwrap();
    /// let mut state = CascadeState::default();
    /// state.observe(&gains, Some(EncoderCount::new(0)));
    /// state.feed_forward(percent(20.0));
    /// assert_eq!(state.regulate(&gains, angle(0.0)).duty, percent(20.0));
    /// ```
    pub fn feed_forward(&mut self, change: Percent) {
        self.regulator.absorb(-change);
    }

    /// Restarts the regulator with this duty, from which the slew limit and the integrator
    /// continue.
    pub fn start_from(&mut self, duty: Percent) {
        self.regulator = RateLoopState::of(duty, duty);
    }

    /// Resets the regulator while the bridge is off: the integrator is emptied, angle and rate
    /// stay.
    pub fn release(&mut self) {
        self.regulator = RateLoopState::default();
        self.setpoint = None;
    }

    /// Discards the angle: the next valid count lies within half a turn of zero again.
    pub fn reset_position(&mut self) {
        self.shaft = ShaftTracker::default();
    }

    /// Changes from old to new coefficients without a jump of the duty. With another zero or
    /// direction of the encoder the angle is discarded and starts again at the next valid count.
    /// While the bridge is off there is no duty to maintain, and the integrator stays empty.
    pub fn retune(&mut self, old: &Coefficients, new: &Coefficients) {
        if old.mounting != new.mounting {
            self.reset_position();
        }
        let Some(setpoint) = self.setpoint else {
            return;
        };
        let unlimited = |under: &Coefficients| {
            let mut trial = *self;
            trial.close(under, setpoint);
            trial.regulator.unlimited()
        };
        let jump = unlimited(new) - unlimited(old);
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

    /// The tracker of the shaft.
    pub fn shaft(&self) -> &ShaftTracker {
        &self.shaft
    }
}
