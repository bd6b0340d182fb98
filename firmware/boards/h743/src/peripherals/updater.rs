//! The board with an STM32H743 has no bootloader: its drive refuses images.

use firmware::{
    drive::{Slots, UpdateOrder},
    parameters::BusSettings,
};
use heapless::spsc::{Consumer, Producer};

use super::flash::Flash;
use crate::actuator::{canopen_task::SINGLE, update_result::UpdateResult};

/// It writes nothing.
pub struct Updater;

impl Updater {
    /// No slots.
    pub fn new(
        _: &Flash,
        _: Consumer<'static, UpdateOrder<'static>, SINGLE>,
        _: Producer<'static, UpdateResult, SINGLE>,
        _: &BusSettings,
    ) -> (Self, Option<Slots>) {
        (Self, None)
    }

    /// Nothing to be told.
    pub fn set_bus(&mut self, _: &BusSettings) {}

    /// Never.
    pub fn is_working(&self) -> bool {
        false
    }

    /// Nothing to do.
    pub fn run(&mut self, _: &mut Flash) {}
}
