//! The drivetrain with a PWM bridge, tick by tick.

use core::ops::{Deref, DerefMut};

use super::electrical::Terminal;
use super::pwm::PwmBridge;
use super::{Drivetrain, DrivetrainParameters, DrivetrainState, state};
use crate::parameter::ParameterError;
use crate::plant::{PERIOD, Plant, PlantState, Pwm};

/// A [`Drivetrain`] whose bridge is driven by PWM periods and which is simulated as its caller's
/// time advances: torque, inertia and motion of its load act from the next tick on.
///
/// [`Plant::at`] is the present state at any tick.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SteppedDrivetrain {
    drivetrain: Drivetrain,
    bridge: PwmBridge,
    /// Voltage of the running period while the bridge is on.
    level_v: f64,
    /// Its on time, ticks.
    on_ticks: f64,
    /// Ticks of the period that have passed.
    passed: u32,
}

/// What changes in a [`SteppedDrivetrain`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SteppedState {
    drivetrain: DrivetrainState,
    level_v: f64,
    on_ticks: f64,
    passed: u32,
}

impl SteppedDrivetrain {
    /// The present state.
    #[inline(always)]
    pub(crate) fn state(&self) -> SteppedState {
        SteppedState {
            drivetrain: self.drivetrain.state(),
            level_v: self.level_v,
            on_ticks: self.on_ticks,
            passed: self.passed,
        }
    }

    /// Continues from a state.
    #[inline(always)]
    pub(crate) fn set_state(&mut self, state: &SteppedState) {
        self.drivetrain.set_state(&state.drivetrain);
        self.level_v = state.level_v;
        self.on_ticks = state.on_ticks;
        self.passed = state.passed;
    }

    /// A drivetrain at rest at zero.
    ///
    /// # Errors
    /// As [`Drivetrain::try_new`].
    ///
    /// ```
    /// use model_core::plant::{Plant, Pwm};
    /// use model_core::plant::drivetrain::{DrivetrainParameters, stepped::SteppedDrivetrain};
    ///
    /// let mut drivetrain =
    ///     SteppedDrivetrain::try_new(&DrivetrainParameters::default(), Pwm::Average).unwrap();
    /// for _ in 0..1000 {
    ///     drivetrain.start_period(50.0);
    ///     drivetrain.advance_ticks(20);
    /// }
    /// // Half of 283.6 deg/s, less the share of Coulomb friction.
    /// assert!((drivetrain.reading().output.rate_deg_s - 136.94).abs() < 0.2);
    /// ```
    pub fn try_new(parameters: &DrivetrainParameters, pwm: Pwm) -> Result<Self, ParameterError> {
        Ok(Self {
            drivetrain: Drivetrain::try_new(parameters)?,
            bridge: PwmBridge::new(parameters, pwm),
            level_v: 0.0,
            on_ticks: 0.0,
            passed: 0,
        })
    }

    /// As [`Plant::start_period`], with a voltage at the terminals instead of a duty; it is limited
    /// to the supply, and NaN counts as 0.
    pub fn start_period_at_volts(&mut self, terminal_v: f64) {
        self.drivetrain.settle();
        (self.level_v, self.on_ticks, self.passed) = (terminal_v, PERIOD as f64, 0);
    }

    /// Simulates the next ticks of the period, up to 20.
    #[inline]
    pub fn advance_ticks(&mut self, ticks: u32) {
        let end = self.passed.saturating_add(ticks);
        if f64::from(end) <= self.on_ticks {
            let level = Terminal::Driven(self.level_v);
            self.drivetrain.advance_ticks(level, ticks);
        } else {
            for passed in self.passed..end {
                let on = self.on_ticks - f64::from(passed);
                self.bridge.run_tick(&mut self.drivetrain, self.level_v, on);
            }
        }
        // A period has 20 ticks; the bridge stays off in later ones.
        self.passed = end;
    }

    /// Supply of the bridge, V.
    pub fn supply_v(&self) -> f64 {
        self.drivetrain.supply_v
    }
}

impl Deref for SteppedDrivetrain {
    type Target = Drivetrain;

    fn deref(&self) -> &Drivetrain {
        &self.drivetrain
    }
}

impl DerefMut for SteppedDrivetrain {
    fn deref_mut(&mut self) -> &mut Drivetrain {
        &mut self.drivetrain
    }
}

impl Plant for SteppedDrivetrain {
    fn start_period(&mut self, duty_pct: f64) {
        self.drivetrain.settle();
        let supply_v = self.drivetrain.supply_v;
        (self.level_v, self.on_ticks) = self.bridge.drive(duty_pct, supply_v);
        self.passed = 0;
    }

    #[inline(always)]
    fn pass_to(&mut self, tick_in_period: usize) {
        self.advance_ticks((tick_in_period as u32).saturating_sub(self.passed));
    }

    #[inline(always)]
    fn at(&self, _tick_in_period: usize) -> PlantState {
        state(self.drivetrain.train.output())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plant::drivetrain::friction::FrictionParameters;

    #[test]
    fn ticks_at_once_are_those_one_after_the_other() {
        let friction = FrictionParameters {
            friction_model: 6.0,
            ..Default::default()
        };
        let parameters = DrivetrainParameters {
            friction,
            ..Default::default()
        };
        for pwm in [Pwm::Average, Pwm::Switched] {
            let mut at_once = SteppedDrivetrain::try_new(&parameters, pwm).unwrap();
            let mut one_by_one = at_once.clone();
            for duty_pct in [80.0, -35.0, 3.0, 0.0, 100.0] {
                for _ in 0..30 {
                    at_once.start_period(duty_pct);
                    [7, 13]
                        .into_iter()
                        .for_each(|ticks| at_once.advance_ticks(ticks));
                    one_by_one.start_period(duty_pct);
                    (0..20).for_each(|_| one_by_one.advance_ticks(1));
                    assert_eq!(at_once.reading(), one_by_one.reading(), "{pwm:?}");
                }
            }
        }
    }
}
