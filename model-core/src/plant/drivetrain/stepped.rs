//! The drivetrain with a PWM bridge, tick by tick.

use core::ops::{Deref, DerefMut};

use super::pwm::PwmBridge;
use super::{Drivetrain, DrivetrainParameters, state};
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

impl SteppedDrivetrain {
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
    ///     (0..20).for_each(|_| drivetrain.advance_tick());
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
        (self.level_v, self.on_ticks, self.passed) = (terminal_v, PERIOD as f64, 0);
    }

    /// Simulates the next tick of the period.
    #[inline]
    pub fn advance_tick(&mut self) {
        let on = self.on_ticks - f64::from(self.passed);
        self.bridge.run_tick(&mut self.drivetrain, self.level_v, on);
        // A period has 20 ticks; the bridge stays off in later ones.
        self.passed = self.passed.saturating_add(1);
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
        let supply_v = self.drivetrain.supply_v;
        (self.level_v, self.on_ticks) = self.bridge.drive(duty_pct, supply_v);
        self.passed = 0;
    }

    fn at(&self, _tick_in_period: usize) -> PlantState {
        state(self.drivetrain.train.output())
    }
}
