//! The interface on its own bus, and the array in a map.

use std::collections::BTreeMap;

use rigless::device::Level;
use rigless::emulator::{Error, Memory};
use rigless::mcu::{Operate, Single};
use rigless::soc::Width;
use rigless::time::VirtualNanos;

pub(in crate::flash) use super::super::interface::register::{KEYS, cr::*, sr::*};
use super::super::{FlashTimes, Interface};
use crate::chip::bus;

const FLASH: u64 = 0x4002_3c00;
pub const KEYR: u64 = 0x04;
pub const SR: u64 = 0x0c;
pub const CR: u64 = 0x10;
pub const BASE: u64 = 0x0800_0000;
pub const PAGE: u64 = 0x0810_0000;

/// Words of 32 bits.
pub const X32: u64 = 2 << PSIZE_SHIFT;

#[derive(Default)]
struct Array(BTreeMap<u64, u8>);

impl Memory for Array {
    fn read(&mut self, address: u64, width: Width) -> Result<u64, Error> {
        let byte = |at| u64::from(self.0.get(&at).copied().unwrap_or(0xff));
        let bytes = 0..u64::from(width.bytes());
        Ok(bytes.map(|i| byte(address + i) << (8 * i)).sum())
    }
    fn write(&mut self, address: u64, width: Width, _: u64) -> Result<(), Error> {
        Err(Error::Memory { address, width })
    }
    fn program(&mut self, address: u64, width: Width, value: u64) -> Result<(), Error> {
        for i in 0..u64::from(width.bytes()) {
            self.0.insert(address + i, (value >> (8 * i)) as u8);
        }
        Ok(())
    }
}

pub struct Bench {
    pub part: Single<Interface>,
    array: Array,
    now_ns: u64,
    line: Level,
    reports: usize,
}

impl Bench {
    pub fn new() -> Self {
        let model = Interface::new(FlashTimes::TYPICAL, 1);
        Self {
            part: Single::new(bus::builder().unwrap(), "FLASH", model).unwrap(),
            array: Array::default(),
            now_ns: 0,
            line: Level::Low,
            reports: 0,
        }
    }

    pub fn unlocked() -> Self {
        let mut bench = Self::new();
        bench.unlock();
        assert_eq!(bench.read(CR), 0);
        bench
    }

    pub fn unlock(&mut self) {
        KEYS.into_iter().for_each(|key| self.write(KEYR, key));
    }

    pub fn write(&mut self, offset: u64, value: u64) {
        self.access(FLASH + offset, value);
    }

    /// A word into the array.
    pub fn store(&mut self, address: u64, value: u64) {
        self.access(address, value);
    }

    fn access(&mut self, address: u64, value: u64) {
        let at = VirtualNanos(self.now_ns);
        self.part.write(at, address, Width::W32, value).unwrap();
        self.settle();
    }

    pub fn read(&mut self, offset: u64) -> u64 {
        let at = VirtualNanos(self.now_ns);
        self.part.read(at, FLASH + offset, Width::W32).unwrap()
    }

    fn settle(&mut self) {
        let refused = self.part.settle(&mut self.array).unwrap();
        assert!(refused.is_empty(), "{refused:?}");
        if let Some(change) = self.part.drain_interrupts().last() {
            self.line = change.level;
        }
        self.reports += self.part.drain_told().len();
    }

    pub fn run_us(&mut self, us: u64) {
        let end_ns = self.now_ns + us * 1000;
        while self.now_ns < end_ns {
            let next = self.part.next_event().map_or(end_ns, |at| at.0);
            self.now_ns = next.clamp(self.now_ns, end_ns);
            self.part.advance_to(VirtualNanos(self.now_ns));
            self.settle();
        }
    }

    /// The word at an address of the array.
    pub fn array(&mut self, address: u64) -> u64 {
        self.array.read(address, Width::W32).unwrap()
    }

    pub fn line(&self) -> bool {
        self.line == Level::High
    }

    pub fn reports(&self) -> usize {
        self.reports
    }

    /// The requested state of the supply, if a cut was due.
    pub fn power(&mut self) -> Option<bool> {
        self.part.take_power_request()
    }
}
