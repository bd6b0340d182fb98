//! A direct path from the core to the CRC unit.
//!
//! The program checks its flash continuously: three of four accesses to peripherals are words for
//! this unit, which takes no time and has no events. They bypass the emulator's bus, which settles
//! the whole chip at each access.

use crate::chip::Remainder;
use crate::processor::{
    Access, AccessKind, BusLayer, CoreBus, Layered, Queued, VirtualNanos, Width,
};

/// DR of the unit, and the registers of RCC, which can stop its clock (RM0090, table 1).
const DR: u64 = 0x4002_3000;
const CR: u64 = 0x4002_3008;
const RCC: std::ops::Range<u64> = 0x4002_3800..0x4002_3c00;

/// The unit at the bus of a core.
#[derive(Debug)]
pub(super) struct CrcPort {
    remainder: Remainder,
    /// The bus has taken a write to the unit, and its clock was not changed since.
    is_open: bool,
}

impl CrcPort {
    pub fn new(remainder: Remainder) -> Self {
        Self {
            remainder,
            is_open: false,
        }
    }

    /// After a reset its clock is off.
    pub fn close(&mut self) {
        self.is_open = false;
    }
}

/// The bus of a run with the unit in front of it.
pub(super) struct CrcBus<'a> {
    inner: &'a mut dyn CoreBus,
    port: &'a mut CrcPort,
    /// Number of retired instructions up to which the core may run while its next event is this.
    end: u64,
    event: Option<VirtualNanos>,
    /// The last access was one to the unit.
    is_own: bool,
}

impl<'a> CrcBus<'a> {
    /// The bus of a run up to this number of retired instructions.
    pub fn new(inner: &'a mut dyn CoreBus, port: &'a mut CrcPort, end: u64) -> Layered<Self> {
        Layered(Self {
            inner,
            port,
            end,
            event: None,
            is_own: false,
        })
    }
}

impl BusLayer for CrcBus<'_> {
    fn behind(&self) -> &dyn CoreBus {
        self.inner
    }

    fn behind_mut(&mut self) -> &mut dyn CoreBus {
        self.inner
    }

    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        let is_write = access.kind == AccessKind::Write;
        if self.port.is_open && is_write && access.address == DR && access.width == Width::W32 {
            self.port.remainder.update(access.value as u32);
            self.is_own = true;
            return Some(0);
        }
        self.is_own = false;
        let answer = self.inner.access(access, from_code);
        if is_write && access.address == CR {
            self.port.is_open = answer.is_some();
        } else if is_write && RCC.contains(&access.address) {
            self.port.is_open = false;
        }
        answer
    }

    fn queued(&mut self) -> Vec<Queued> {
        if self.is_own {
            return Vec::new();
        }
        self.inner.queued()
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        if self.is_own && event == self.event {
            let left = self.end.saturating_sub(instructions);
            return (left > 0).then_some(left as u32);
        }
        let more = self.inner.carry_on(instructions, event)?;
        (self.end, self.event) = (instructions + u64::from(more), event);
        Some(more)
    }
}
