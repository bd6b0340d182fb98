//! The drivetrain with a PWM bridge.

use super::electrical::Terminal;
use super::load::Recording;
use super::{Drivetrain, DrivetrainParameters, Instant, Reading, state};
use crate::parameter::ParameterError;
use crate::plant::{PERIOD, Plant, PlantState, Pwm, bridge_duty_pct};
use crate::time::TICK_S;

/// A [`Drivetrain`] whose bridge is driven by PWM periods.
///
/// A period is simulated at its start and its states are stored, so reading has no side effect.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PwmDrivetrain<'a> {
    drivetrain: Drivetrain,
    pwm: Pwm,
    off: Terminal,
    #[cfg_attr(feature = "serde", serde(skip))]
    recording: Option<Recording<'a>>,
    tick: u64,
    instants: [Instant; PERIOD + 1],
}

impl<'a> PwmDrivetrain<'a> {
    /// A drivetrain at rest at zero, with a recorded load if there is one.
    ///
    /// # Errors
    /// As [`Drivetrain::try_new`].
    ///
    /// ```
    /// use model_core::plant::{Plant, Pwm, drivetrain::{DrivetrainParameters, pwm::PwmDrivetrain}};
    ///
    /// let mut drivetrain = PwmDrivetrain::try_new(&DrivetrainParameters::default(), Pwm::Average, None).unwrap();
    /// for _ in 0..1000 {
    ///     drivetrain.start_period(50.0);
    /// }
    /// // Half of 283.6 deg/s, less the share of Coulomb friction.
    /// assert!((drivetrain.at(20).rate_deg_s - 136.94).abs() < 0.2);
    /// ```
    pub fn try_new(
        parameters: &DrivetrainParameters,
        pwm: Pwm,
        recording: Option<Recording<'a>>,
    ) -> Result<Self, ParameterError> {
        let drivetrain = Drivetrain::try_new(parameters)?;
        let off = if parameters.electrical.coast_when_off >= 0.5 {
            Terminal::Coast
        } else {
            Terminal::Brake
        };
        let instants = [drivetrain.instant(); PERIOD + 1];
        Ok(Self {
            drivetrain,
            pwm,
            off,
            recording,
            tick: 0,
            instants,
        })
    }

    /// State and signals at a tick of the running period, as [`Plant::at`].
    pub fn reading_at(&self, tick_in_period: usize) -> Reading {
        let instant = &self.instants[tick_in_period.min(PERIOD)];
        self.drivetrain.reading_of(instant)
    }

    /// Adds a torque to the external load from the next period, Nm, unless a recording does.
    pub fn set_load_torque_nm(&mut self, torque_nm: f64) {
        self.drivetrain.set_recorded_torque_nm(torque_nm);
    }

    /// Adds an inertia to the load from the next period, kg m^2, as
    /// [`Drivetrain::set_added_inertia_kg_m2`].
    pub fn set_load_inertia_kg_m2(&mut self, inertia_kg_m2: f64) {
        self.drivetrain.set_added_inertia_kg_m2(inertia_kg_m2);
    }

    /// Moves the load at the end of the running period, as [`Drivetrain::push_load`].
    pub fn push_load(&mut self, angle_deg: f64, impulse_nms: f64) {
        self.drivetrain.push_load(angle_deg, impulse_nms);
        self.instants[PERIOD] = self.drivetrain.instant();
    }

    /// Supply of the bridge, V.
    pub fn supply_v(&self) -> f64 {
        self.drivetrain.supply_v
    }

    /// As [`Plant::start_period`], with a voltage at the terminals instead of a duty; it is limited
    /// to the supply, and NaN counts as 0.
    pub fn start_period_at_volts(&mut self, terminal_v: f64) {
        self.run_period(terminal_v, PERIOD as f64);
    }

    /// Simulates a period with this voltage at the terminals for so many ticks.
    #[inline(always)]
    fn run_period(&mut self, level_v: f64, on_ticks: f64) {
        self.instants[0] = self.instants[PERIOD];
        for tick in 0..PERIOD {
            if let Some(recording) = &self.recording {
                let torque_nm = recording.torque_nm(self.tick);
                self.drivetrain.set_recorded_torque_nm(torque_nm);
            }
            self.run_tick(level_v, on_ticks - tick as f64);
            // 2^64 ticks are 29 million years.
            self.tick = self.tick.saturating_add(1);
            self.instants[tick + 1] = self.drivetrain.instant();
        }
    }

    /// Simulates one tick; the switching edge is `on` ticks after its start.
    #[inline(always)]
    fn run_tick(&mut self, level_v: f64, on: f64) {
        let parts = if on >= 1.0 {
            [(Terminal::Driven(level_v), TICK_S), (self.off, 0.0)]
        } else if on > 0.0 {
            let (on_s, off_s) = (on * TICK_S, (1.0 - on) * TICK_S);
            [(Terminal::Driven(level_v), on_s), (self.off, off_s)]
        } else {
            [(self.off, TICK_S), (self.off, 0.0)]
        };
        for (terminal, time_s) in parts {
            if time_s > 0.0 {
                self.drivetrain.advance(terminal, time_s);
            }
        }
    }
}

impl Plant for PwmDrivetrain<'_> {
    #[inline(always)]
    fn start_period(&mut self, duty_pct: f64) {
        let share = bridge_duty_pct(duty_pct) / 100.0;
        let supply_v = self.drivetrain.supply_v;
        let (level_v, on_ticks) = match self.pwm {
            Pwm::Average => (supply_v * share, PERIOD as f64),
            Pwm::Switched => (libm::copysign(supply_v, share), share.abs() * PERIOD as f64),
        };
        self.run_period(level_v, on_ticks);
    }

    fn at(&self, tick_in_period: usize) -> PlantState {
        state(self.instants[tick_in_period.min(PERIOD)].output)
    }
}
