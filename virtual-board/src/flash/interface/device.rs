//! Register and array accesses of the firmware.

use rigless::device::{Device, DeviceContext, Level, RegisterFile};
use rigless::soc::Width;
use rigless::soc::stm32f427::generated::flash::Register as R;
use rigless::time::{EventId, VirtualNanos};

use super::super::operation::Operation;
use super::Interface;
use super::register::{KeyProgress, cr, sr};

/// Tokens of accesses to the array: purpose and address.
pub(super) const IGNORED: u64 = 0;
pub(super) const PROGRAM: u64 = 1 << 40;
pub(super) const DAMAGE: u64 = 1 << 41;
const ADDRESS: u64 = 0xffff_ffff;

impl Interface {
    fn write_control(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        if self.is_set(cr::LOCK) {
            return;
        }
        if self.is_busy() {
            context.tell(
                "CR",
                "written during an operation: the chip stalls the core, RM0090 3.6.1",
            );
            return;
        }
        self.control = value;
        if value & cr::LOCK != 0 {
            self.control &= !cr::STRT;
        } else if value & cr::STRT != 0 {
            self.start_erase(context);
        }
    }

    fn write_key(&mut self, value: u64, context: &mut DeviceContext<'_>) {
        match self.key.enter(value) {
            KeyProgress::Incomplete => {}
            KeyProgress::Unlocked => self.control &= !cr::LOCK,
            KeyProgress::Rejected => {
                self.control |= cr::LOCK;
                context.tell(
                    "KEYR",
                    "a wrong key: locked until the next reset, RM0090 3.6.1",
                );
            }
        }
    }

    /// Error of a store to the array, if any (RM0090, section 3.6.4).
    fn store_error(&self, address: u64, width: Width) -> Option<u64> {
        let parallelism = match width {
            Width::W8 => 0,
            Width::W16 => 1,
            Width::W32 => 2,
            Width::W64 => 3,
        };
        if !self.is_set(cr::PG) || self.is_set(cr::LOCK | cr::SER | cr::MER | cr::MER1) {
            Some(sr::PGSERR)
        } else if self.control >> cr::PSIZE_SHIFT & 0b11 != parallelism {
            Some(sr::PGPERR)
        } else if !address.is_multiple_of(u64::from(width.bytes())) {
            Some(sr::PGAERR)
        } else {
            None
        }
    }

    fn publish(&mut self, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        let busy = if self.is_busy() { sr::BSY } else { 0 };
        registers.set(R::Cr, self.control);
        registers.set(R::Sr, self.status | busy);
        let ended = self.is_set(cr::EOPIE) && self.status & sr::EOP != 0;
        let failed = self.is_set(cr::ERRIE) && self.status & sr::OPERR != 0;
        let line = Level::from(ended || failed);
        if line != self.line {
            self.line = line;
            context.interrupt(0, line);
        }
    }
}

impl Device for Interface {
    type Register = R;

    fn write(
        &mut self,
        register: R,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        match register {
            R::Cr => self.write_control(value, context),
            R::Keyr => self.write_key(value, context),
            R::Sr => self.status &= !value,
            R::Acr | R::Optkeyr | R::Optcr | R::Optcr1 => {
                self.options.write(register, value, registers, context);
            }
        }
        self.publish(registers, context);
    }

    fn write_region(
        &mut self,
        address: u64,
        width: Width,
        value: u64,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) -> bool {
        if self.is_busy() {
            let reason = "a store during an operation: the chip stalls the core, RM0090 3.6.4";
            context.tell("SR", reason);
        } else if let Some(error) = self.store_error(address, width) {
            self.fail(error);
        } else {
            let operation = Operation::Program {
                address,
                width,
                value,
            };
            self.start(operation, self.times.program_ns, context);
        }
        self.publish(registers, context);
        true
    }

    fn on_event(
        &mut self,
        event: EventId,
        registers: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        if self.cut_event == Some(event) {
            self.cut_event = None;
            self.lose_power(context);
        } else if self.ends == Some(event) {
            self.ends = None;
            self.end(context);
        } else {
            self.options.on_event(event, registers, context);
        }
        self.publish(registers, context);
    }

    fn on_access(
        &mut self,
        token: u64,
        held: u64,
        _: &mut RegisterFile,
        context: &mut DeviceContext<'_>,
    ) {
        let address = token & ADDRESS;
        if token & DAMAGE != 0 {
            let Some(damage) = &mut self.damage else {
                return;
            };
            let left = damage.content_after(held);
            context.program(address, damage.operation().piece_width(), left, IGNORED);
        } else if token & PROGRAM != 0
            && let Some(operation) = self.finishing.take()
        {
            let value = operation.complete(held);
            context.program(address, operation.piece_width(), value, IGNORED);
        }
    }

    fn on_clock(&mut self, hz: u64, registers: &mut RegisterFile, context: &mut DeviceContext<'_>) {
        self.options.on_clock(hz, registers, context);
    }

    fn peek(&self, register: R, registers: &RegisterFile, now: VirtualNanos) -> Option<u64> {
        self.options.peek(register, registers, now)
    }
}
