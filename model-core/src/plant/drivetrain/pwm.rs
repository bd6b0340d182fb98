//! The drivetrain with a PWM bridge.

use super::electrical::Terminal;
use super::load::Recording;
use super::{Drivetrain, DrivetrainParameters, Instant, Reading, state};
use crate::parameter::ParameterError;
use crate::plant::{PERIOD, Plant, PlantState, Pwm, bridge_duty_pct};
use crate::time::TICK_S;

/// The bridge within a PWM period.
#[derive(Debug, Clone, Copy)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PwmBridge {
    pwm: Pwm,
    off: Terminal,
}

impl PwmBridge {
    pub fn new(parameters: &DrivetrainParameters, pwm: Pwm) -> Self {
        let off = if parameters.electrical.coast_when_off >= 0.5 {
            Terminal::Coast
        } else {
            Terminal::Brake
        };
        Self { pwm, off }
    }

    /// Voltage and on time, in ticks, for a duty.
    #[inline(always)]
    pub fn drive(&self, duty_pct: f64, supply_v: f64) -> (f64, f64) {
        let share = bridge_duty_pct(duty_pct) / 100.0;
        match self.pwm {
            Pwm::Average => (supply_v * share, PERIOD as f64),
            Pwm::Switched => (libm::copysign(supply_v, share), share.abs() * PERIOD as f64),
        }
    }

    /// Simulates one tick; the switching edge is `on` ticks after its start.
    #[inline(always)]
    pub fn run_tick(&self, drivetrain: &mut Drivetrain, level_v: f64, on: f64) {
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
                drivetrain.advance(terminal, time_s);
            }
        }
    }
}

/// A [`Drivetrain`] whose bridge is driven by PWM periods.
///
/// A period is simulated at its start and its states are stored, so reading has no side effect.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PwmDrivetrain<'a> {
    drivetrain: Drivetrain,
    bridge: PwmBridge,
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
        let bridge = PwmBridge::new(parameters, pwm);
        let instants = [drivetrain.instant(); PERIOD + 1];
        Ok(Self {
            drivetrain,
            bridge,
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
}

impl Plant for PwmDrivetrain<'_> {
    #[inline(always)]
    fn start_period(&mut self, duty_pct: f64) {
        self.drivetrain.settle();
        let (level_v, on_ticks) = self.bridge.drive(duty_pct, self.drivetrain.supply_v);
        self.instants[0] = self.instants[PERIOD];
        for tick in 0..PERIOD {
            if let Some(recording) = &self.recording {
                let torque_nm = recording.torque_nm(self.tick);
                self.drivetrain.set_recorded_torque_nm(torque_nm);
            }
            let on = on_ticks - tick as f64;
            self.bridge.run_tick(&mut self.drivetrain, level_v, on);
            // 2^64 ticks are 29 million years.
            self.tick = self.tick.saturating_add(1);
            self.instants[tick + 1] = self.drivetrain.instant();
        }
    }

    fn at(&self, tick_in_period: usize) -> PlantState {
        state(self.instants[tick_in_period.min(PERIOD)].output)
    }
}
