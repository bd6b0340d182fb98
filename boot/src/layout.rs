//! Where everything is in the flash.
//!
//! ```
//! use bootloader::layout::STM32F427;
//!
//! assert_eq!(STM32F427.slot.start(), 0x0800_8000);
//! assert_eq!(STM32F427.slot.size(), 224 << 10);
//! assert!(STM32F427.staging.size() >= STM32F427.slot.size());
//! ```

/// A sector, the unit of an erase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sector {
    /// Its number, as the flash interface counts.
    pub number: u8,
    /// Its first address.
    pub start: u32,
    /// Bytes in it.
    pub size: u32,
}

impl Sector {
    const fn new(number: u8, start: u32, kib: u32) -> Self {
        Self {
            number,
            start,
            size: kib << 10,
        }
    }
}

/// Sectors without a gap that hold an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// The sectors in the order of their addresses; at least one.
    pub sectors: &'static [Sector],
}

impl Region {
    /// Its first address.
    pub fn start(&self) -> u32 {
        self.sectors.first().map_or(0, |sector| sector.start)
    }

    /// Bytes in it.
    pub fn size(&self) -> u32 {
        self.sectors.iter().map(|sector| sector.size).sum()
    }
}

/// The places of a chip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// The image that runs: header, then program.
    pub slot: Region,
    /// The image to be installed.
    pub staging: Region,
    /// The image that ran before.
    pub backup: Region,
    /// The two sectors of the log, which are written in turn.
    pub records: [Sector; 2],
}

/// The STM32F427 with 2 MiB (RM0090, table 6). The bootloader is in sectors 0 and 1, the slot in
/// sectors 2 to 5 behind it, both in bank 1. All others are in bank 2, which is erased and written
/// while the program runs from bank 1: the parameters in sectors 12 and 13, the log in 14 and 15,
/// staging and backup in two sectors of 128 KiB each.
pub const STM32F427: Layout = Layout {
    slot: Region {
        sectors: &[
            Sector::new(2, 0x0800_8000, 16),
            Sector::new(3, 0x0800_c000, 16),
            Sector::new(4, 0x0801_0000, 64),
            Sector::new(5, 0x0802_0000, 128),
        ],
    },
    staging: Region {
        sectors: &[
            Sector::new(17, 0x0812_0000, 128),
            Sector::new(18, 0x0814_0000, 128),
        ],
    },
    backup: Region {
        sectors: &[
            Sector::new(19, 0x0816_0000, 128),
            Sector::new(20, 0x0818_0000, 128),
        ],
    },
    records: [
        Sector::new(14, 0x0810_8000, 16),
        Sector::new(15, 0x0810_c000, 16),
    ],
};
