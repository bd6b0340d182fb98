//! What a communication cycle exchanges with the other tasks: parameters to be saved, updates, the
//! state of the bus and of the queues.

use cortex_m::peripheral::SCB;
use firmware::timing::{COMMUNICATION_PERIODS, periods};

use super::{
    super::{
        bus_status, timebase, timing::CYCLES_PER_US, update_result::UpdateResult,
        watchdog_supervisor,
    },
    CommTask,
};

/// Communication cycles in 4 ms.
const STALE_CYCLES: usize = COMMUNICATION_PERIODS.len() * periods(4) as usize;

impl CommTask {
    /// Requests that process data be discarded that has waited for 4 ms in which no frame left the
    /// board, and has what was discarded sampled anew: after a gap of the bus the
    /// first telemetry is the newest.
    pub(super) fn discard_stale(&mut self) {
        let (cycles, before) = self.waited;
        let transmitted = bus_status::transmitted();
        let waits = (self.queues.process_data.len() > 0) && transmitted == before;
        self.waited = (if waits { cycles + 1 } else { 0 }, transmitted);
        if self.waited.0 >= STALE_CYCLES || !self.queues.process_data.ready() {
            bus_status::request_discard();
        }
        let discarded = bus_status::discarded();
        if discarded != self.discarded {
            self.discarded = discarded;
            self.device.repeat_process_data();
        }
    }

    pub(super) fn update_diagnostics(&mut self) {
        let diagnostics = &mut self.device.drive.diagnostics;
        diagnostics.receive_overflows = bus_status::lost_frames();
        diagnostics.bus_offs = bus_status::bus_offs();
        diagnostics.transmit_overflows = bus_status::discarded();
        diagnostics.starved_periods = watchdog_supervisor::starved_periods();
        diagnostics.longest_step_us = timebase::longest_step_cycles() / CYCLES_PER_US;
    }

    /// Sends a set of parameters to be saved, and takes the result of the last save.
    pub(super) fn exchange_with_store(&mut self) {
        if let Some((is_saved, memory)) = self.queues.save_results.dequeue() {
            self.device.drive.saved(is_saved);
            self.set_to_save = Some(memory);
        }
        if self.set_to_save.is_some()
            && let Some(set) = self.device.drive.take_save()
            && let Some(memory) = self.set_to_save.take()
        {
            *memory = *set;
            // There is room: only one set is on its way.
            let _ = self.queues.to_save.enqueue(memory);
        }
    }

    /// Sends orders of an update, takes their results, and restarts the processor for the
    /// bootloader.
    pub(super) fn exchange_with_updater(&mut self) {
        let drive = &mut self.device.drive;
        match self.queues.update_results.dequeue() {
            Some(UpdateResult::Staged(buffer, result)) => drive.staged(buffer, result),
            Some(UpdateResult::Confirmed(is_written)) => drive.confirmed(is_written),
            Some(UpdateResult::Requested(is_written)) => drive.requested(is_written),
            None => {}
        }
        if self.queues.to_update.ready()
            && let Some(order) = drive.take_update()
        {
            // There is room.
            let _ = self.queues.to_update.enqueue(order);
        }
        if drive.step_update() {
            SCB::sys_reset();
        }
    }

    /// Sends a change of the bit rate to the CAN controller.
    pub(super) fn forward_bit_rate(&mut self) {
        if let Some(kbit_s) = self.device.drive.take_bit_rate() {
            bus_status::request_bit_rate(kbit_s);
        }
    }
}
