//! What may wait until node and drive are served: the flash and the log.

use firmware::{application::Outputs, drive::StoredParameters, supervisor::Part};
use heapless::spsc::Consumer;

use crate::actuator::{heard, keeper::Keeper, report::Report, slot::Giver};

/// The background's own.
pub struct Background {
    pub outputs: Consumer<'static, Outputs, 3>,
    pub keeper: &'static mut Keeper<StoredParameters>,
    pub saved: Giver<bool>,
    pub report: Report,
}

impl Background {
    /// Serves the control periods that have passed since the last call, usually one.
    pub fn run(&mut self) {
        while let Some(outputs) = self.outputs.dequeue() {
            self.report.update(&outputs);
        }
        if let Some(done) = self.keeper.run() {
            // The node fetches each within a tick, and a save takes many.
            self.saved.put(done);
        }
        heard::from(Part::Background);
    }
}
