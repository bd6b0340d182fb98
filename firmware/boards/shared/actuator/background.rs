//! The background task: parameters to the flash, check of the program's flash, and the log.

use firmware::{
    application::{BoardState, Outputs},
    faults::Fault,
    supervisor::Task,
};

use super::{
    parameter_store::ParameterStore, program_check, queues::BackgroundEnds, timebase,
    timing::CONTROL_RATE_HZ, watchdog_supervisor::report_alive,
};
use crate::{
    board::diagnostics,
    peripherals::{flash::Flash, updater::Updater},
};

/// Control periods between two reports of time and stack: 10 s.
const REPORT_INTERVAL: u32 = 10 * CONTROL_RATE_HZ;

/// What the log needs of a control period.
pub struct StepReport {
    tick: u32,
    state: BoardState,
    fault: Option<Fault>,
}

impl StepReport {
    /// The report of a control period with these outputs.
    pub fn new(outputs: &Outputs) -> Self {
        Self {
            tick: outputs.telemetry.tick,
            state: outputs.state,
            fault: outputs.fault,
        }
    }
}

/// Resources of the background task.
pub struct Background {
    pub queues: BackgroundEnds,
    pub flash: Flash,
    pub store: ParameterStore,
    pub updater: Updater,
    pub log: StateLog,
    pub program_check: program_check::Check,
}

impl Background {
    /// Processes the control periods since the last call, usually one.
    pub fn run(&mut self) {
        while let Some(report) = self.queues.reports.dequeue() {
            self.log.update(&report);
        }
        self.write_flash();
        program_check::proceed(&mut self.program_check);
        report_alive(Task::Background);
    }

    /// Continues a save, or else an update. The flash executes one operation at a time: a save
    /// waits for the operation of an update, and an update for the save.
    fn write_flash(&mut self) {
        let is_free = !(self.updater.is_working() && self.flash.is_started());
        if is_free
            && let Some((is_saved, set)) = self.store.run(&mut self.flash, &mut self.queues.to_save)
        {
            if is_saved {
                self.updater.set_bus(&set.board.bus);
            }
            // There is room: the device takes each result within a control period, and a save takes
            // many.
            let _ = self.queues.saved.enqueue((is_saved, set));
        }
        if !self.store.is_running() {
            self.updater.run(&mut self.flash, &mut self.queues);
        }
    }
}

/// Logs changes of state and fault, and periodically the longest step and the stack usage.
#[derive(Default)]
pub struct StateLog {
    state: BoardState,
    fault: Option<Fault>,
}

impl StateLog {
    fn update(&mut self, report: &StepReport) {
        if (report.state, report.fault) != (self.state, self.fault) {
            (self.state, self.fault) = (report.state, report.fault);
            let fault = self.fault.map_or(0, Fault::number);
            defmt::info!("state {}, fault {}", self.state as u8, fault);
        }
        if report.tick.is_multiple_of(REPORT_INTERVAL) {
            defmt::info!(
                "longest step {} cycles, deepest stack {} bytes",
                timebase::longest_step_cycles(),
                diagnostics::maximum_stack_use()
            );
        }
    }
}
