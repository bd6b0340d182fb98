//! CANopen of a board without an image that may run: program download (CiA 302-3).
//!
//! | object | meaning |
//! |---|---|
//! | 1F50h:1 | program data: an image, to the staging area |
//! | 1F51h:1 | program control: reads 0, stopped; 1 installs and starts, 3 clears the staging |
//! | 1F56h:1 | identity of the image in the staging area; 0 for none |
//! | 1F57h:1 | flash status: the error of the last download in bits 1 to 7, [`FlashStatus`] |
//! | 2104h | as in the program: identity and bytes of an image that was broken off, next offset |
//!
//! The server is that of the crate `canopen`, with these and the mandatory objects. LSS stores
//! node-ID and bit rate in the log; a program that starts later writes its own there.

use core::task::Poll;

use canopen::dictionary::{Access, Address, DataType, Dictionary, Entry, Limits};
use canopen::{Abort, Application, BitRate, NodeId};

use crate::{
    check::header_of,
    flash::{Flash, FlashError},
    header::HEADER_SIZE,
    install::Bootloader,
    log,
    record::{Bus, State},
    signature::Verifier,
};

/// Highest sub-index, or a constant, of a program object.
const ONE: u32 = 1;

const CONTROL: Limits = Limits::unsigned(0, 3);

const ENTRIES: &[Entry] = &[
    Entry::new(0x1000, 0, DataType::U32, Access::Const),
    Entry::new(0x1001, 0, DataType::U8, Access::Read),
    Entry::new(0x1017, 0, DataType::U16, Access::ReadWrite).value(1000),
    Entry::new(0x1018, 0, DataType::U8, Access::Const).value(4),
    Entry::new(0x1018, 1, DataType::U32, Access::Const),
    Entry::new(0x1018, 2, DataType::U32, Access::Read),
    Entry::new(0x1018, 3, DataType::U32, Access::Const),
    Entry::new(0x1018, 4, DataType::U32, Access::Read),
    Entry::new(0x1F50, 0, DataType::U8, Access::Const).value(ONE),
    Entry::new(0x1F50, 1, DataType::Domain, Access::Write),
    Entry::new(0x1F51, 0, DataType::U8, Access::Const).value(ONE),
    Entry::new(0x1F51, 1, DataType::U8, Access::ReadWrite).limits(&CONTROL),
    Entry::new(0x1F56, 0, DataType::U8, Access::Const).value(ONE),
    Entry::new(0x1F56, 1, DataType::U32, Access::Read),
    Entry::new(0x1F57, 0, DataType::U8, Access::Const).value(ONE),
    Entry::new(0x1F57, 1, DataType::U32, Access::Read),
    Entry::new(0x2104, 0, DataType::U8, Access::Const).value(3),
    Entry::new(0x2104, 1, DataType::U32, Access::Read),
    Entry::new(0x2104, 2, DataType::U32, Access::Read),
    Entry::new(0x2104, 3, DataType::U32, Access::ReadWrite),
];

/// The objects of the bootloader.
pub const DICTIONARY: Dictionary = match Dictionary::try_new(ENTRIES, &[], &[]) {
    Ok(dictionary) => dictionary,
    Err(_) => panic!("the objects of the bootloader are inconsistent"),
};

/// Error of the last download (CiA 302-3, object 1F57h).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum FlashStatus {
    /// None.
    Good = 0,
    /// The image is refused.
    NoValidProgram = 1,
    /// The flash cannot be erased or written.
    WriteError = 5,
}

/// The application behind the objects.
#[derive(Debug)]
pub struct Waiting<'a, F, V> {
    bootloader: Bootloader<'a, F, V>,
    serial_number: u32,
    status: FlashStatus,
    /// Bytes of a word that is not complete, and their number.
    word: [u8; 4],
    count: usize,
    /// Where in the image the download began, and where the next one begins.
    offset: u32,
    next_offset: u32,
    /// Bytes of the image in the staging area, whole words.
    written: u32,
    is_requested: bool,
    /// A bit rate that LSS has set, kbit/s.
    bit_rate_kbit_s: Option<u16>,
}

impl<'a, F: Flash, V: Verifier> Waiting<'a, F, V> {
    /// A board with this serial number, object 1018h:4.
    pub fn new(bootloader: Bootloader<'a, F, V>, serial_number: u32) -> Self {
        Self {
            bootloader,
            serial_number,
            status: FlashStatus::Good,
            word: [u8::MAX; 4],
            count: 0,
            offset: 0,
            next_offset: 0,
            written: 0,
            is_requested: false,
            bit_rate_kbit_s: None,
        }
    }

    /// Whether the installation is requested: the board shall restart.
    pub fn is_requested(&self) -> bool {
        self.is_requested
    }

    /// The bit rate to switch to, kbit/s, once.
    pub fn take_bit_rate(&mut self) -> Option<u16> {
        self.bit_rate_kbit_s.take()
    }

    fn capacity(&self) -> u32 {
        self.bootloader.layout.slot.size()
    }

    /// Identity of the image of which there is the beginning or all; 0 for none.
    fn kept(&self) -> u32 {
        if self.written < HEADER_SIZE {
            return 0;
        }
        let staging = &self.bootloader.layout.staging;
        let header = header_of(self.bootloader.flash, staging);
        header.map_or(0, |header| header.identity())
    }

    fn set_next_offset(&mut self, offset: u32) -> Result<(), Abort> {
        if offset != 0 && (offset != self.written || self.kept() == 0) {
            return Err(Abort::Value);
        }
        self.next_offset = offset;
        Ok(())
    }

    fn clear(&mut self, length: u32) -> Result<(), Abort> {
        self.written = 0;
        self.next_offset = 0;
        let staging = self.bootloader.layout.staging;
        let erased = self.bootloader.erase(&staging, length);
        self.noted(erased)
    }

    /// Notes and reports an error of the flash.
    fn noted(&mut self, done: Result<(), FlashError>) -> Result<(), Abort> {
        done.map_err(|FlashError| {
            self.status = FlashStatus::WriteError;
            Abort::Hardware
        })
    }

    /// Writes the word that is complete, or the last one, which begins at `address`.
    fn write_word(&mut self, address: u32) -> Result<(), Abort> {
        let word = u32::from_le_bytes(core::mem::replace(&mut self.word, [u8::MAX; 4]));
        self.count = 0;
        if word == u32::MAX {
            return Ok(());
        }
        let written = self.bootloader.flash.program(address, word);
        self.noted(written)
    }

    fn start(&mut self) -> Result<(), Abort> {
        match self.bootloader.request() {
            Ok(written) => {
                self.noted(written)?;
                self.is_requested = true;
                Ok(())
            }
            Err(_) => {
                self.status = FlashStatus::NoValidProgram;
                Err(Abort::DeviceState)
            }
        }
    }
}

impl<F: Flash, V: Verifier> Application for Waiting<'_, F, V> {
    fn read(&mut self, entry: &Entry) -> Result<u64, Abort> {
        let staging = &self.bootloader.layout.staging;
        let address = entry.address();
        Ok(match (address.index, address.sub) {
            (0x1018, 2) => self.bootloader.hardware.into(),
            (0x1018, 4) => self.serial_number.into(),
            (0x1F51, 1) => 0,
            (0x1F56, 1) => {
                let staged = header_of(self.bootloader.flash, staging);
                staged.map_or(0, |header| header.identity()).into()
            }
            (0x1F57, 1) => (self.status as u64) << 1,
            (0x2104, 1) => self.kept().into(),
            (0x2104, 2) => self.written.into(),
            (0x2104, 3) => self.next_offset.into(),
            _ => return Err(Abort::NoObject),
        })
    }

    fn write(&mut self, entry: &Entry, value: u64) -> Result<(), Abort> {
        match (entry.address().index, value) {
            (0x1F51, 0) => Ok(()),
            (0x1F51, 1) => self.start(),
            (0x1F51, 3) => self.clear(self.capacity()),
            (0x1F51, _) => Err(Abort::Value),
            (0x2104, offset) => self.set_next_offset(offset as u32),
            _ => Err(Abort::NoObject),
        }
    }

    fn domain_begin(&mut self, _: Address, size: Option<u32>) -> Result<(), Abort> {
        let offset = core::mem::take(&mut self.next_offset);
        let room = self.capacity().saturating_sub(offset);
        let length = size.unwrap_or(room);
        if length > room {
            return Err(Abort::TooLong);
        }
        self.status = FlashStatus::Good;
        self.word = [u8::MAX; 4];
        self.count = 0;
        self.offset = offset;
        if offset == 0 {
            self.clear(length)?;
        }
        Ok(())
    }

    fn domain_write(&mut self, _: Address, offset: u32, data: &[u8]) -> Result<(), Abort> {
        let start = self.bootloader.layout.staging.start();
        for (at, byte) in (self.offset.saturating_add(offset)..).zip(data) {
            if at >= self.capacity() {
                return Err(Abort::TooLong);
            }
            if let Some(place) = self.word.get_mut(self.count) {
                *place = *byte;
            }
            self.count += 1;
            if self.count == self.word.len() {
                self.write_word(start.saturating_add(at & !3))?;
                self.written = at.saturating_add(1);
            }
        }
        Ok(())
    }

    fn domain_end(&mut self, _: Address, size: u32) -> Poll<Result<(), Abort>> {
        let start = self.bootloader.layout.staging.start();
        let ended = match self.count {
            0 => Ok(()),
            _ => self.write_word(start.saturating_add(self.offset.saturating_add(size) & !3)),
        };
        let checked = ended.and_then(|()| {
            self.bootloader.check_staged().map_err(|_| {
                self.status = FlashStatus::NoValidProgram;
                self.written = 0;
                Abort::Value
            })
        });
        Poll::Ready(checked)
    }

    fn supports_bit_rate(&self, bit_rate: BitRate) -> bool {
        Bus::kbit_s_of(bit_rate).is_some()
    }

    fn set_bit_rate(&mut self, bit_rate: BitRate) {
        self.bit_rate_kbit_s = Bus::kbit_s_of(bit_rate);
    }

    fn store_lss(
        &mut self,
        node_id: Option<NodeId>,
        bit_rate: Option<BitRate>,
    ) -> Poll<Result<(), Abort>> {
        let state = self.bootloader.state();
        let bus = Bus {
            node_id: node_id.map_or(state.bus.node_id, NodeId::get),
            kbit_s: bit_rate
                .and_then(Bus::kbit_s_of)
                .unwrap_or(state.bus.kbit_s),
        };
        let records = &self.bootloader.layout.records;
        let next = State { bus, ..state };
        let written = log::append(self.bootloader.flash, records, &next);
        Poll::Ready(self.noted(written))
    }
}
