//! Sectors (RM0090, table 6): in each bank four of 16 KiB, one of 64 KiB, seven of 128 KiB.

/// First address of the array.
pub const BASE: u64 = 0x0800_0000;
/// Size of the array.
pub const SIZE: u64 = 2 << 20;
/// First address of bank 2.
pub const BANK_2: u64 = BASE + SIZE / 2;

const KIB: u64 = 1 << 10;

/// A sector of the array.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sector {
    /// 0 to 23.
    pub number: u32,
    /// Its first address.
    pub base: u64,
    /// Bytes in it.
    pub size: u64,
}

impl Sector {
    /// The sector of this number, 0 to 23.
    ///
    /// ```
    /// use virtual_board::flash::Sector;
    ///
    /// let sector = Sector::of_number(13).unwrap();
    /// assert_eq!((sector.base, sector.size), (0x0810_4000, 16 << 10));
    /// ```
    pub fn of_number(number: u32) -> Option<Self> {
        let (bank, within) = (u64::from(number / 12), u64::from(number % 12));
        let (offset, size) = match within {
            0..=3 => (within * 16 * KIB, 16 * KIB),
            4 => (64 * KIB, 64 * KIB),
            _ => ((within - 4) * 128 * KIB, 128 * KIB),
        };
        (bank < 2).then_some(Self {
            number,
            base: BASE + bank * (SIZE / 2) + offset,
            size,
        })
    }

    /// The sector of a value of `CR.SNB`: 0 to 11, and 16 to 27 for bank 2.
    pub(super) fn of_field(field: u64) -> Option<Self> {
        match field as u32 {
            number @ 0..=11 => Self::of_number(number),
            number @ 16..=27 => Self::of_number(number - 4),
            _ => None,
        }
    }

    /// The sector of an address.
    pub fn at(address: u64) -> Option<Self> {
        (0..24)
            .filter_map(Self::of_number)
            .find(|sector| (sector.base..sector.base + sector.size).contains(&address))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sectors_cover_the_array_without_a_gap() {
        let mut next = BASE;
        for number in 0..24 {
            let sector = Sector::of_number(number).unwrap();
            assert_eq!(sector.base, next);
            next += sector.size;
        }
        assert_eq!(next, BASE + SIZE);
        assert_eq!(Sector::of_number(24), None);
        assert_eq!(Sector::at(0x0810_4000).map(|s| s.number), Some(13));
        assert_eq!(Sector::at(next), None);
    }

    #[test]
    fn the_register_counts_bank_2_from_16() {
        assert_eq!(Sector::of_field(16), Sector::of_number(12));
        assert_eq!([12, 15, 28].map(Sector::of_field), [None; 3]);
    }
}
