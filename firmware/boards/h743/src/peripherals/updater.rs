//! The board with an STM32H743 has no bootloader: its drive refuses images.

use firmware::{drive::Slots, parameters::BusSettings};

use super::flash::Flash;
use crate::actuator::queues::BackgroundEnds;

/// It writes nothing.
pub struct Updater;

impl Updater {
    /// No slots.
    pub fn new(_: &Flash, _: &BusSettings) -> (Self, Option<Slots>) {
        (Self, None)
    }

    /// Nothing to report.
    pub fn set_bus(&mut self, _: &BusSettings) {}

    /// Never.
    pub fn is_working(&self) -> bool {
        false
    }

    /// Nothing to do.
    pub fn run(&mut self, _: &mut Flash, _: &mut BackgroundEnds) {}
}
