//! What the board logs while it runs: changes of state, and once in ten seconds how it fares.

use firmware::{
    application::{BoardState, Outputs},
    faults::Fault,
};

use crate::{actuator::ticks, board::stack};

/// Ticks between two reports.
const INTERVAL: u32 = 2500;

/// What was logged last.
#[derive(Default)]
pub struct Report {
    state: BoardState,
    fault: Option<Fault>,
}

impl Report {
    /// Looks at a control period.
    pub fn update(&mut self, outputs: &Outputs) {
        if (outputs.state, outputs.fault) != (self.state, self.fault) {
            (self.state, self.fault) = (outputs.state, outputs.fault);
            let fault = self.fault.map_or(0, Fault::number);
            defmt::info!("state {}, fault {}", self.state as u8, fault);
        }
        if outputs.telemetry.tick.is_multiple_of(INTERVAL) {
            let (cycles, bytes) = (ticks::longest_step_cycles(), stack::deepest_use());
            defmt::info!(
                "longest step {} cycles, deepest stack {} bytes",
                cycles,
                bytes
            );
        }
    }
}
