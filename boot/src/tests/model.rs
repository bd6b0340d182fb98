//! A model of the flash whose supply can be cut in any operation.

use core::task::Poll;
use std::{vec, vec::Vec};

use rand_pcg::{Pcg32, rand_core::Rng};

use crate::{
    flash::{Flash, FlashError, PolledFlash, ReadFlash},
    layout::{Layout, Region, Sector},
};

const fn sector(number: u8, start: u32, size: u32) -> Sector {
    Sector {
        number,
        start,
        size,
    }
}

/// The sectors of a small flash: each region has more than one, and eight records fill a sector of
/// the log.
pub const SMALL: Layout = Layout {
    slot: Region {
        sectors: &[sector(0, 0, 256), sector(1, 256, 256), sector(2, 512, 256)],
    },
    staging: Region {
        sectors: &[sector(3, 1024, 512), sector(4, 1536, 512)],
    },
    backup: Region {
        sectors: &[sector(5, 2048, 512), sector(6, 2560, 512)],
    },
    records: [sector(7, 3072, 256), sector(8, 3328, 256)],
};

/// Addresses that nothing of the bootloader may change.
pub const PARAMETERS: core::ops::Range<usize> = 768..1024;

const SIZE: usize = 3584;

/// How far an operation has come when the supply is cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// Nothing has changed.
    None,
    /// Bits are between their old and their new content: at each start they read as one or the
    /// other, by chance of this seed.
    Partial(u64),
    /// As [`Progress::Partial`], but all bits except one of each word have their new content: a
    /// word that reads right at one start, and wrong at another.
    Nearly(u64),
    /// The operation is complete.
    Complete,
}

/// A word whose last operation was interrupted.
#[derive(Debug, Clone, Copy)]
struct Unstable {
    at: usize,
    before: u32,
    after: u32,
}

/// The flash.
#[derive(Debug, Clone)]
pub struct Model {
    bytes: Vec<u8>,
    unstable: Vec<Unstable>,
    random: Pcg32,
    /// Operations until the supply is cut, and how.
    cut: Option<(u64, Progress)>,
    is_off: bool,
    /// Operations since the model was made.
    pub operations: u64,
    /// Result of the last operation without a wait, and for how many polls it continues.
    ended: Result<(), FlashError>,
    busy: u8,
}

/// Polls for which an operation continues.
const BUSY: u8 = 2;

impl Model {
    /// An erased flash with random parameters.
    pub fn new() -> Self {
        let mut bytes = vec![0xff; SIZE];
        let mut random = Pcg32::new(1, 1);
        random.fill_bytes(&mut bytes[PARAMETERS]);
        Self {
            bytes,
            unstable: Vec::new(),
            random,
            cut: None,
            is_off: false,
            operations: 0,
            ended: Ok(()),
            busy: 0,
        }
    }

    /// Content, as a programmer writes it.
    pub fn load(&mut self, address: u32, content: &[u8]) {
        let at = address as usize;
        self.bytes[at..at + content.len()].copy_from_slice(content);
    }

    /// Cuts the supply in the operation after this number of others.
    pub fn cut_after(&mut self, operations: u64, progress: Progress) {
        self.cut = Some((operations, progress));
        if let Progress::Partial(seed) | Progress::Nearly(seed) = progress {
            self.random = Pcg32::new(seed, operations);
        }
    }

    /// Whether the supply was cut.
    pub fn is_off(&self) -> bool {
        self.is_off
    }

    /// Whether a planned cut has not come.
    pub fn awaits_cut(&self) -> bool {
        self.cut.is_some()
    }

    /// Power-on: words whose operation was interrupted read anew.
    pub fn power_on(&mut self) {
        self.is_off = false;
        self.ended = Ok(());
        self.busy = 0;
        for index in 0..self.unstable.len() {
            let Unstable { at, before, after } = self.unstable[index];
            let chance = self.random.next_u32();
            self.put(at, before & chance | after & !chance);
        }
    }

    fn get(&self, at: usize) -> u32 {
        u32::from_le_bytes(self.bytes[at..at + 4].try_into().expect("four bytes"))
    }

    fn put(&mut self, at: usize, word: u32) {
        self.bytes[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }

    /// One operation, which makes this of each word.
    fn operate(
        &mut self,
        words: core::ops::Range<usize>,
        make: impl Fn(u32) -> u32,
    ) -> Result<(), FlashError> {
        if self.is_off {
            return Err(FlashError);
        }
        self.operations += 1;
        let progress = match self.cut {
            Some((0, progress)) => progress,
            _ => Progress::Complete,
        };
        for at in words.step_by(4) {
            self.change(at, &make, progress);
        }
        self.is_off = matches!(self.cut, Some((0, _)));
        self.cut = match self.cut {
            Some((left, progress)) => left.checked_sub(1).map(|left| (left, progress)),
            None => None,
        };
        if self.is_off { Err(FlashError) } else { Ok(()) }
    }

    fn change(&mut self, at: usize, make: &impl Fn(u32) -> u32, progress: Progress) {
        if progress == Progress::None {
            return;
        }
        let held = self.get(at);
        let known = self.unstable.iter().position(|word| word.at == at);
        let (before, after) = match known {
            Some(index) => {
                let Unstable { before, after, .. } = self.unstable.swap_remove(index);
                (before, after)
            }
            None => (held, held),
        };
        let (before, after) = match progress {
            Progress::Partial(_) => (before, make(after)),
            Progress::Nearly(_) => {
                let after = make(after);
                let changed = before ^ after;
                (after ^ (changed & changed.wrapping_neg()), after)
            }
            _ => (make(before), make(after)),
        };
        if before == after {
            self.put(at, after);
            return;
        }
        self.unstable.push(Unstable { at, before, after });
        let chance = self.random.next_u32();
        self.put(at, before & chance | after & !chance);
    }
}

impl ReadFlash for Model {
    fn bytes(&self, address: u32, length: u32) -> &[u8] {
        &self.bytes[address as usize..(address + length) as usize]
    }
}

impl Flash for Model {
    fn erase(&mut self, sector: u8) -> Result<(), FlashError> {
        let regions = [SMALL.slot, SMALL.staging, SMALL.backup];
        let sectors = regions.into_iter().flat_map(|region| region.sectors);
        let found = sectors.chain(&SMALL.records).find(|s| s.number == sector);
        let found = found.expect("a sector of the bootloader");
        let start = found.start as usize;
        self.operate(start..start + found.size as usize, |_| u32::MAX)
    }

    fn program(&mut self, address: u32, word: u32) -> Result<(), FlashError> {
        let at = address as usize;
        assert!(!PARAMETERS.contains(&at), "{at:#x}");
        self.operate(at..at + 4, |held| held & word)
    }
}

impl PolledFlash for Model {
    fn start_erase(&mut self, sector: u8) {
        assert_eq!(self.busy, 0, "an operation goes on");
        self.ended = self.erase(sector);
        self.busy = BUSY;
    }

    fn start_program(&mut self, address: u32, word: u32) {
        assert_eq!(self.busy, 0, "an operation goes on");
        self.ended = self.program(address, word);
        self.busy = BUSY;
    }

    fn ended(&mut self) -> Poll<Result<(), FlashError>> {
        match self.busy.checked_sub(1) {
            Some(busy) => {
                self.busy = busy;
                Poll::Pending
            }
            None => Poll::Ready(self.ended),
        }
    }
}

#[test]
fn an_interrupted_word_reads_differently_at_each_start_until_it_is_erased() {
    let mut flash = Model::new();
    flash.cut_after(0, Progress::Partial(3));
    assert!(flash.program(0, 0x1234_5678).is_err());
    let mut read = || {
        flash.power_on();
        flash.word(0)
    };
    let (first, second) = (read(), read());
    assert_ne!(first, second);
    assert_eq!(first & 0x1234_5678, 0x1234_5678);
    flash.erase(0).expect("the supply is on");
    flash.power_on();
    assert_eq!(flash.word(0), u32::MAX);
}
