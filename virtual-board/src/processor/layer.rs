//! Buses in front of the bus of the emulator.

use super::{Access, Checked, CoreBus, InterruptLine, Queued, VirtualNanos};

/// A bus in front of another one, which does what this one does not override.
pub trait BusLayer {
    /// The bus behind.
    fn behind(&self) -> &dyn CoreBus;

    /// The same, to be used.
    fn behind_mut(&mut self) -> &mut dyn CoreBus;

    /// As [`CoreBus::access`].
    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        self.behind_mut().access(access, from_code)
    }

    /// As [`CoreBus::carry_on`].
    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        self.behind_mut().carry_on(instructions, event)
    }

    /// As [`CoreBus::queued`].
    fn queued(&mut self) -> Vec<Queued> {
        self.behind_mut().queued()
    }
}

/// A layer as the bus of a core.
#[derive(Debug)]
pub struct Layered<L>(pub L);

impl<L: BusLayer> CoreBus for Layered<L> {
    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        self.0.access(access, from_code)
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        self.0.carry_on(instructions, event)
    }

    fn time(&self, instructions: u64) -> VirtualNanos {
        self.0.behind().time(instructions)
    }

    fn queued(&mut self) -> Vec<Queued> {
        self.0.queued()
    }

    fn acknowledge(&mut self, line: InterruptLine, instructions: u64) -> Option<u64> {
        self.0.behind_mut().acknowledge(line, instructions)
    }

    fn read_checked(&mut self, access: Access, report: bool) -> Option<Checked> {
        self.0.behind_mut().read_checked(access, report)
    }

    fn write_checked(&mut self, access: Access) -> Option<bool> {
        self.0.behind_mut().write_checked(access)
    }

    fn stops_before(&mut self, access: &Access) -> bool {
        self.0.behind_mut().stops_before(access)
    }

    fn send_trace(&mut self, bytes: &[u8]) {
        self.0.behind_mut().send_trace(bytes);
    }
}
