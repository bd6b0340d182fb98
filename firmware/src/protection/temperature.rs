//! Temperature of the board.

use super::{Conditions, lasting::Lasting};
use crate::{
    faults::{Fault, FaultSet},
    parameters::TemperatureLimits,
};

/// For how long it has been too hot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct TemperatureGuard(Lasting);

impl TemperatureGuard {
    /// For how many control periods it has been too hot.
    pub fn periods(&self) -> u16 {
        self.0.periods()
    }

    /// Whether it is too hot.
    pub fn check(&mut self, limits: &TemperatureLimits, c: &Conditions<'_>) -> FaultSet {
        let temperature = c.measured.temperature_mdeg_c;
        let is_hot = temperature.map(|mdeg_c| mdeg_c > limits.over_temperature_mdeg_c);
        let mut present = FaultSet::EMPTY;
        present.put(
            Fault::OverTemperature,
            self.0.update(is_hot, limits.over_temperature_ms),
        );
        present
    }
}
