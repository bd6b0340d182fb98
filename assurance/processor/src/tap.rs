//! Records the accesses of the emulated board's core to its bus.

use std::collections::VecDeque;

use virtual_board::processor::{Access, AccessKind, BusLayer, CoreBus, VirtualNanos};

/// An access of an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Event {
    /// Whether it writes.
    pub is_write: bool,
    /// Its address.
    pub address: u32,
    /// Its width, bytes.
    pub bytes: u32,
    /// The value written or read.
    pub value: u32,
    /// The instruction.
    pub instruction: u32,
}

/// A bus that records.
pub struct Tap<'a> {
    /// The emulator's bus.
    pub inner: &'a mut dyn CoreBus,
    /// The accesses since the last comparison.
    pub log: &'a mut VecDeque<Event>,
    /// Number of retired instructions up to which the core may run.
    pub end: &'a mut u64,
}

impl BusLayer for Tap<'_> {
    fn behind(&self) -> &dyn CoreBus {
        self.inner
    }

    fn behind_mut(&mut self) -> &mut dyn CoreBus {
        self.inner
    }

    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        let answer = self.inner.access(access, from_code)?;
        if from_code {
            let is_write = access.kind == AccessKind::Write;
            let value = if is_write { access.value } else { answer };
            self.log.push_back(Event {
                is_write,
                address: access.address as u32,
                bytes: u32::from(access.width.bits()) / 8,
                value: value as u32,
                instruction: access.program_counter.unwrap_or(0) as u32,
            });
        }
        Some(answer)
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        let more = self.inner.carry_on(instructions, event)?;
        *self.end = instructions + u64::from(more);
        Some(more)
    }
}
