//! The board's control step in closed loop with a plant (reference semantics S9).
//!
//! At each PWM edge the pending duty takes effect; at every fourth edge the control step then
//! samples the encoder and computes the next duty, which takes effect one PWM period later.

use crate::control::{
    cascade::{CascadeState, CascadeStep, Coefficients, Setpoint},
    pwm_timer::{Modulator, PwmCompare},
    units::percent,
};
use crate::plant::{Plant, bridge_duty_pct, drivetrain::stepped::SteppedDrivetrain};
use crate::sensors::{encoder::Encoder, noise::Noise};
use crate::time::{CONTROL_PERIOD_TICKS, UPDATE_PERIOD_TICKS};

crate::parameters! {
    /// The timer that switches the bridge.
    pub struct TimerParameters {
        /// 1: the on time is a whole number of timer counts, 1/560 %; 0: it is exactly the computed
        /// duty.
        timer_counts [""]: 0.0, "choice", 0.0, 1.0, "0: the loop is that of the equations; the board's timer counts";
    }
}

impl TimerParameters {
    fn counts(&self) -> bool {
        self.timer_counts >= 0.5
    }
}

/// The board's loop, which starts with a control step at tick 0.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosedLoop<P> {
    coefficients: Coefficients,
    #[cfg_attr(feature = "serde", serde(with = "crate::parameter::as_values"))]
    timer: TimerParameters,
    encoder: Encoder,
    /// Motor, gear train and load.
    pub plant: P,
    now: LoopState,
}

/// What changes in a [`ClosedLoop`], without plant and encoder. It is one piece of memory, so that
/// a copy takes few instructions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct LoopState {
    control: CascadeState,
    modulator: Modulator,
    /// The last control step.
    step: CascadeStep,
    /// Its duty as a compare value of the timer.
    compare: PwmCompare,
    duty_pct: f64,
    /// The duty that takes effect at the next edge, %.
    pending_duty_pct: f64,
    tick: u64,
}

impl<P: Plant> ClosedLoop<P> {
    /// Closes the loop around a plant.
    ///
    /// ```
    /// use model_core::actuator::closed_loop::ClosedLoop;
    /// use model_core::control::{cascade::Coefficients, units::angle};
    /// use model_core::plant::{Plant, Pwm, first_order::FirstOrder};
    /// use model_core::sensors::{encoder::Encoder, noise::Noise};
    ///
    /// let gains = Coefficients::try_new(&Default::default()).unwrap();
    /// let encoder = Encoder::new(Default::default(), Noise::new(0, 0));
    /// let motor = FirstOrder::try_new(Default::default(), Pwm::Average).unwrap();
    /// let mut board = ClosedLoop::new(gains, Default::default(), encoder, motor);
    /// for _ in 0..2000 {
    ///     board.start_period(|_| angle(90.0));
    /// }
    /// // Within one encoder count after two seconds.
    /// assert!((board.plant.at(20).angle_deg - 90.0).abs() < 0.09);
    /// ```
    pub fn new(
        coefficients: Coefficients,
        timer: TimerParameters,
        encoder: Encoder,
        plant: P,
    ) -> Self {
        Self {
            coefficients,
            timer,
            encoder,
            plant,
            now: LoopState::default(),
        }
    }

    /// Processes the PWM edge at which the next period of 20 ticks starts; `command` returns the
    /// command that has arrived at a tick, an angle or a rate.
    #[inline(always)]
    pub fn start_period<S: Into<Setpoint>>(&mut self, command: impl FnOnce(u64) -> S) {
        self.now.duty_pct = self.now.pending_duty_pct;
        self.plant.start_period(self.now.duty_pct);
        if self.now.tick.is_multiple_of(CONTROL_PERIOD_TICKS) {
            self.control(command(self.now.tick));
        }
        self.now.tick += UPDATE_PERIOD_TICKS;
    }

    fn control(&mut self, command: impl Into<Setpoint>) {
        let count = self.encoder.valid_count(self.plant.at(0).angle_deg);
        self.now.control.observe(&self.coefficients, count);
        // Without a valid count the last duty remains: protections are part of the board's
        // application.
        if count.is_some() {
            self.now.step = self.now.control.regulate(&self.coefficients, command);
            self.now.compare = self.now.modulator.next(self.now.step.duty);
            self.now.pending_duty_pct = if self.timer.counts() {
                self.now.compare.duty_pct()
            } else {
                self.now.step.duty.to_f64()
            };
        }
    }

    /// Processes the PWM edge with both loops open: this duty, %, takes effect at once.
    ///
    /// The board goes on to measure angle and rate; its regulator is empty when the loops close.
    pub fn start_open_period(&mut self, duty_pct: f64) {
        let limited_pct = bridge_duty_pct(duty_pct);
        let duty = percent(limited_pct);
        self.now.compare = self.now.modulator.next(duty);
        let duty_pct = if self.timer.counts() {
            self.now.compare.duty_pct()
        } else {
            limited_pct
        };
        self.plant.start_period(duty_pct);
        self.observe(duty_pct);
    }

    /// Measures without regulating, in the periods in which the control step runs. The duty is
    /// also that of the next edge, if the loops close then.
    fn observe(&mut self, duty_pct: f64) {
        (self.now.duty_pct, self.now.pending_duty_pct) = (duty_pct, duty_pct);
        self.now.step = CascadeStep {
            duty: percent(duty_pct),
            ..CascadeStep::default()
        };
        if self.now.tick.is_multiple_of(CONTROL_PERIOD_TICKS) {
            let count = self.encoder.valid_count(self.plant.at(0).angle_deg);
            self.now.control.observe(&self.coefficients, count);
            self.now.control.release();
        }
        self.now.tick += UPDATE_PERIOD_TICKS;
    }

    /// Changes the coefficients of the control step without a jump of the duty.
    pub fn retune(&mut self, coefficients: Coefficients) {
        self.now.control.retune(&self.coefficients, &coefficients);
        self.coefficients = coefficients;
    }

    /// The last control step.
    pub fn last_step(&self) -> &CascadeStep {
        &self.now.step
    }

    /// Its duty as a compare value of the timer.
    pub fn compare(&self) -> PwmCompare {
        self.now.compare
    }

    /// The present state of the loop and of the encoder's noise.
    #[inline(always)]
    pub(super) fn state(&self) -> (&LoopState, &Noise) {
        (&self.now, &self.encoder.noise)
    }

    /// Continues from a state.
    #[inline(always)]
    pub(super) fn set_state(&mut self, (now, noise): (&LoopState, &Noise)) {
        self.now = *now;
        self.encoder.noise.clone_from(noise);
    }

    /// The duty of the running period, %.
    pub fn duty_pct(&self) -> f64 {
        self.now.duty_pct
    }

    /// The measured angle, deg.
    pub fn angle_meas_deg(&self) -> f64 {
        self.now.control.angle().to_f64()
    }

    /// The estimated rate, deg/s.
    pub fn rate_meas_deg_s(&self) -> f64 {
        self.now.control.rate().to_f64()
    }
}

impl ClosedLoop<SteppedDrivetrain> {
    /// Processes the PWM edge with this voltage, V, at the motor's terminals during the whole
    /// period. The duty is that of the same mean voltage, and 0 without a supply.
    pub fn start_period_at_volts(&mut self, terminal_v: f64) {
        self.plant.start_period_at_volts(terminal_v);
        let share = terminal_v / self.plant.supply_v();
        self.observe(bridge_duty_pct(100.0 * share));
    }
}
