//! One controller on the stock bus, and its lines.

use std::collections::BTreeMap;

use rigless::device::Level;
use rigless::emulator::{Error, Memory};
use rigless::mcu::{Operate, Single};
use rigless::soc::{Width, stm32f427};
use rigless::time::VirtualNanos;

use super::super::BxCan;
use super::{Port, Wire};

const CAN1: u64 = 0x4000_6400;
pub const MCR: u64 = 0x00;
pub const MSR: u64 = 0x04;
pub const TSR: u64 = 0x08;
pub const RF0R: u64 = 0x0c;
pub const IER: u64 = 0x14;
pub const ESR: u64 = 0x18;
pub const BTR: u64 = 0x1c;
pub const TI0R: u64 = 0x180;
pub const TDT0R: u64 = 0x184;
pub const TDL0R: u64 = 0x188;
pub const RI0R: u64 = 0x1b0;
pub const RDT0R: u64 = 0x1b4;
pub const RDL0R: u64 = 0x1b8;
pub const RDH0R: u64 = 0x1bc;
const FMR: u64 = 0x200;
const FS1R: u64 = 0x20c;
const FA1R: u64 = 0x21c;

/// 16 MHz / 1, 1 + 13 + 2 quanta.
pub const BTR_1M: u64 = 0x001c_0000;
pub const BTR_500K: u64 = 0x001c_0001;

struct NoMemory;

impl Memory for NoMemory {
    fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
        Err(Error::Memory { address, width })
    }
    fn write(&mut self, address: u64, width: Width, _: u64) -> Result<(), Error> {
        Err(Error::Memory { address, width })
    }
}

pub struct Bench {
    pub part: Single<BxCan>,
    now_ns: u64,
    lines: BTreeMap<u16, Level>,
    pub joined_us: u64,
}

impl Bench {
    /// Out of reset, with a port at 1 Mbit/s.
    pub fn new() -> Self {
        let wire = Wire::new(vec![Port::at_rate(1_000_000)]);
        let model = BxCan::new(Some(wire));
        let part = Single::new(stm32f427::builder(), "CAN1", model).unwrap();
        Self {
            part,
            now_ns: 0,
            lines: BTreeMap::new(),
            joined_us: 0,
        }
    }

    /// On the bus at 1 Mbit/s, all frames into FIFO 0.
    pub fn running() -> Self {
        Self::with(0, BTR_1M)
    }

    pub fn with(control: u64, bit_timing: u64) -> Self {
        let mut bench = Self::new();
        bench.set_up(control, bit_timing);
        bench
    }

    pub fn set_up(&mut self, control: u64, bit_timing: u64) {
        self.write(MCR, 1);
        assert_eq!(self.read(MSR) & 0b11, 1, "initialises");
        self.write(BTR, bit_timing);
        self.write(FS1R, 1);
        self.write(FA1R, 1);
        self.write(FMR, 0x2a1c_0e00);
        self.joined_us = self.now_ns / 1000;
        self.write(MCR, control);
        self.run_us(50);
        assert_eq!(self.read(MSR) & 0b11, 0, "the controller is on the bus");
    }

    pub fn write(&mut self, offset: u64, value: u64) {
        let at = VirtualNanos(self.now_ns);
        self.part
            .write(at, CAN1 + offset, Width::W32, value)
            .unwrap();
        self.settle();
    }

    pub fn read(&mut self, offset: u64) -> u64 {
        let at = VirtualNanos(self.now_ns);
        self.part.read(at, CAN1 + offset, Width::W32).unwrap()
    }

    fn settle(&mut self) {
        self.part.settle(&mut NoMemory).unwrap();
        for change in self.part.drain_interrupts() {
            self.lines.insert(change.interrupt, change.level);
        }
    }

    /// Advances the time as the emulator does: from event to event.
    pub fn run_us(&mut self, us: u64) {
        let end_ns = self.now_ns + us * 1000;
        loop {
            rigless::mcu::Mcu::poll(&mut self.part, VirtualNanos(self.now_ns));
            let next = self.part.next_event().map_or(end_ns, |at| at.0);
            self.now_ns = next.clamp(self.now_ns, end_ns);
            self.part.advance_to(VirtualNanos(self.now_ns));
            self.settle();
            if self.now_ns >= end_ns {
                return;
            }
        }
    }

    /// Four bytes to a standard identifier.
    pub fn transmit(&mut self, mailbox: u64, id: u64, data: u64) {
        let base = 0x10 * mailbox;
        self.write(TDT0R + base, 4);
        self.write(TDL0R + base, data);
        self.write(TI0R + base, id << 21 | 1);
    }

    pub fn wire(&mut self) -> &mut Wire {
        self.part.model.wire.as_mut().unwrap()
    }

    pub fn port(&mut self) -> &mut Port {
        &mut self.wire().ports[0]
    }

    /// Transmit, FIFO 0, FIFO 1, status change.
    pub fn line(&self, position: u16) -> bool {
        self.lines.get(&(19 + position)) == Some(&Level::High)
    }
}
