//! An actuator that is stepped by its caller, tick by tick.

use core::ops::{Deref, DerefMut};

use super::input::{CommandError, InputLevel};
use super::settings::Settings;
use super::stepped_core::ActuatorCore;
use crate::models::delay::{DelayLine, LONGEST_DELAY, Ring};
use crate::parameter::ParameterError;

/// An actuator, initially at rest at zero.
///
/// By default it holds the memory of the longest delay, 160 KB, and needs no heap.
/// `Actuator<Vec<f64>>` (feature `alloc`) holds that of its own delay: 2.8 KB for the 17.5 ms of
/// the paper. An [`ActuatorCore`] leaves that memory to its caller; its signals and outputs are
/// also those of an actuator.
#[derive(Debug, Clone)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "R: Ring"))]
pub struct Actuator<R = [f64; LONGEST_DELAY]> {
    core: ActuatorCore,
    delay: DelayLine<R>,
}

impl Actuator {
    /// The actuator of these settings.
    ///
    /// # Errors
    /// That of the first parameter that is out of its range or inconsistent with another one.
    ///
    /// ```
    /// use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
    ///
    /// let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    /// let mut actuator = Actuator::try_new(&settings).unwrap();
    /// // The first command is assumed to have been applied before: no delay. 240 deg/s for 100 ms.
    /// actuator.advance(90.0, 2000).unwrap();
    /// assert!((actuator.reading().angle_deg - 24.0).abs() < 1e-9);
    /// ```
    pub fn try_new(settings: &Settings) -> Result<Self, ParameterError> {
        Self::try_with_ring(settings)
    }
}

impl<R: Ring> Actuator<R> {
    /// The actuator of these settings, with a delay line in memory of this kind.
    ///
    /// # Errors
    /// As [`Actuator::try_new`].
    pub fn try_with_ring(settings: &Settings) -> Result<Self, ParameterError> {
        let (core, delay) = ActuatorCore::try_new(settings)?;
        // The memory is that of the longest delay, or of this one.
        let delay = DelayLine::try_new(delay.len() as u64).ok_or(ParameterError::Unknown)?;
        Ok(Self { core, delay })
    }

    /// Advances by this number of ticks of 50 us with a constant command, deg.
    ///
    /// # Errors
    /// [`CommandError::Value`] for a command beyond
    /// [`COMMAND_RANGE`](super::COMMAND_RANGE), and for NaN.
    pub fn advance(&mut self, command_deg: f64, ticks: u64) -> Result<(), CommandError> {
        self.advance_with(InputLevel::Position, command_deg, ticks)
    }

    /// Advances by this number of ticks of 50 us with a constant command in this quantity.
    ///
    /// Sampling and delay of the test set-up apply to every quantity; the first value in a new
    /// quantity is also its past, so that none is taken for another one.
    ///
    /// # Errors
    /// [`CommandError`] for a value out of range, or if the model has no such input.
    ///
    /// ```
    /// use model_core::actuator::{Actuator, InputLevel, ModelKind, PlantKind, Settings};
    ///
    /// let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    /// let mut actuator = Actuator::try_new(&settings).unwrap();
    /// actuator.advance_with(InputLevel::Duty, 50.0, 20_000).unwrap();
    /// // 2.836 (deg/s)/% x 50 % x (1 - exp(-7.586)).
    /// assert!((actuator.reading().rate_deg_s - 141.728).abs() < 1e-3);
    /// ```
    pub fn advance_with(
        &mut self,
        level: InputLevel,
        value: f64,
        ticks: u64,
    ) -> Result<(), CommandError> {
        self.core
            .advance_with(self.delay.parts(), level, value, ticks)
    }
}

impl<R> Deref for Actuator<R> {
    type Target = ActuatorCore;

    fn deref(&self) -> &ActuatorCore {
        &self.core
    }
}

impl<R> DerefMut for Actuator<R> {
    fn deref_mut(&mut self) -> &mut ActuatorCore {
        &mut self.core
    }
}
