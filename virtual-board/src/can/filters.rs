//! The acceptance filters of bxCAN: 28 banks with four configurations (RM0090, section 32.7.4).

use super::{Frame, Id};
use crate::faults::FilterBit;

/// Banks that the two controllers share.
pub(super) const BANKS: usize = 28;

/// Contents of the filter registers.
#[derive(Debug, Clone)]
pub(super) struct Filters {
    /// `FMR`: `FINIT`, and the first bank of CAN2.
    pub control: u32,
    /// `FM1R`: list rather than mask.
    pub is_list: u32,
    /// `FS1R`: one 32-bit filter rather than two 16-bit ones.
    pub is_wide: u32,
    /// `FFA1R`: into FIFO 1.
    pub to_second: u32,
    /// `FA1R`.
    pub is_active: u32,
    /// `FiR1` and `FiR2`.
    pub banks: [[u32; 2]; BANKS],
}

/// Destination of an accepted frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Accepted {
    pub fifo: usize,
    /// Filter match index: the filter's number among those of its FIFO.
    pub index: u8,
}

impl Default for Filters {
    fn default() -> Self {
        Self {
            control: 0x2a1c_0e01,
            is_list: 0,
            is_wide: 0,
            to_second: 0,
            is_active: 0,
            banks: [[0; 2]; BANKS],
        }
    }
}

/// Identifier in the format of a 32-bit filter.
fn wide(frame: &Frame) -> u32 {
    let id = match frame.id {
        Id::Standard(id) => u32::from(id) << 21,
        Id::Extended(id) => id << 3 | 1 << 2,
    };
    id | u32::from(frame.remote) << 1
}

/// Identifier in the format of a 16-bit filter: STID, RTR, IDE, EXID[17:15].
fn narrow(frame: &Frame) -> u32 {
    let (standard, extended) = match frame.id {
        Id::Standard(id) => (u32::from(id), 0),
        Id::Extended(id) => (id >> 18, 1 << 3 | (id >> 15 & 7)),
    };
    standard << 5 | u32::from(frame.remote) << 4 | extended
}

impl Filters {
    pub fn is_initialising(&self) -> bool {
        self.control & 1 != 0
    }

    /// Flips a bit of a register.
    pub fn flip(&mut self, bit: FilterBit) {
        match bit {
            FilterBit::Identifiers(bit) => {
                let words = self.banks.as_flattened_mut();
                if let Some(word) = words.get_mut((bit / 32) as usize) {
                    *word ^= 1 << (bit % 32);
                }
            }
            FilterBit::Activation(bank) => self.is_active ^= 1 << (bank % 32),
        }
    }

    fn bit(word: u32, bank: usize) -> bool {
        word >> bank & 1 != 0
    }

    /// Number of filters in a bank.
    fn count(&self, bank: usize) -> u8 {
        match (Self::bit(self.is_wide, bank), Self::bit(self.is_list, bank)) {
            (true, false) => 1,
            (true, true) | (false, false) => 2,
            (false, true) => 4,
        }
    }

    /// Index of the first filter of a bank that accepts the frame.
    fn passes(&self, bank: usize, frame: &Frame) -> Option<u8> {
        let [a, b] = self.banks[bank];
        let halves = |word: u32| [word & 0xffff, word >> 16];
        let hits = match (Self::bit(self.is_wide, bank), Self::bit(self.is_list, bank)) {
            (true, false) => vec![(wide(frame) ^ a) & b & !1 == 0],
            (true, true) => vec![wide(frame) == a & !1, wide(frame) == b & !1],
            (false, false) => [a, b]
                .map(|word| {
                    let [id, mask] = halves(word);
                    (narrow(frame) ^ id) & mask == 0
                })
                .to_vec(),
            (false, true) => [halves(a), halves(b)]
                .concat()
                .iter()
                .map(|id| *id == narrow(frame))
                .collect(),
        };
        hits.iter().position(|hit| *hit).map(|hit| hit as u8)
    }

    /// Destination of the frame; `None` if no filter of CAN1 accepts it. Priority: 32 bits before
    /// 16 bits, list before mask, lower number before higher number.
    pub fn accept(&self, frame: &Frame) -> Option<Accepted> {
        if self.is_initialising() {
            return None;
        }
        let own_banks = ((self.control >> 8 & 0x3f) as usize).min(BANKS);
        let mut numbers = [0_u8; 2];
        let mut best: Option<((bool, bool), Accepted)> = None;
        for bank in 0..own_banks {
            let fifo = usize::from(Self::bit(self.to_second, bank));
            let first = numbers[fifo];
            // Inactive banks are numbered as well.
            numbers[fifo] += self.count(bank);
            if !Self::bit(self.is_active, bank) {
                continue;
            }
            let Some(within) = self.passes(bank, frame) else {
                continue;
            };
            let rank = (Self::bit(self.is_wide, bank), Self::bit(self.is_list, bank));
            if best.as_ref().is_none_or(|(held, _)| rank > *held) {
                let index = first + within;
                best = Some((rank, Accepted { fifo, index }));
            }
        }
        best.map(|(_, accepted)| accepted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standard(id: u16) -> Frame {
        Frame::data_frame(Id::Standard(id), &[])
    }

    fn filters() -> Filters {
        Filters {
            control: 0x2a1c_0e00,
            ..Filters::default()
        }
    }

    #[test]
    fn no_frame_is_accepted_without_an_active_filter_or_in_filter_initialisation() {
        let mut f = filters();
        assert_eq!(f.accept(&standard(1)), None);
        f.is_wide = 1;
        f.is_active = 1;
        assert_eq!(f.accept(&standard(1)), Some(Accepted { fifo: 0, index: 0 }));
        f.control |= 1;
        assert_eq!(f.accept(&standard(1)), None);
    }

    #[test]
    fn a_wide_mask_compares_only_its_set_bits() {
        let mut f = filters();
        (f.is_wide, f.is_active) = (1, 1);
        f.banks[0] = [0x201 << 21, 0x7ff << 21 | 1 << 2 | 1 << 1];
        assert!(f.accept(&standard(0x201)).is_some());
        assert!(f.accept(&standard(0x202)).is_none());
        assert!(
            f.accept(&Frame::remote_frame(Id::Standard(0x201), 0))
                .is_none()
        );
        assert!(
            f.accept(&Frame::data_frame(Id::Extended(0x201 << 18), &[]))
                .is_none()
        );
    }

    #[test]
    fn a_list_accepts_exactly_its_entries() {
        let mut f = filters();
        (f.is_wide, f.is_list, f.is_active) = (0, 1, 1);
        let entry = |id: u32| id << 5;
        f.banks[0] = [entry(1) | entry(2) << 16, entry(3) | entry(4) << 16];
        let index = |id| f.accept(&standard(id)).map(|a| a.index);
        assert_eq!(
            [1, 2, 3, 4, 5].map(index),
            [Some(0), Some(1), Some(2), Some(3), None]
        );
        f.is_wide = 1;
        f.banks[0] = [0x1234_5678 << 3 | 4, 0x7 << 21 | 2];
        let extended = Frame::data_frame(Id::Extended(0x1234_5678), &[]);
        assert_eq!(f.accept(&extended).map(|a| a.index), Some(0));
        let remote = Frame::remote_frame(Id::Standard(7), 0);
        assert_eq!(f.accept(&remote).map(|a| a.index), Some(1));
    }

    #[test]
    fn narrow_masks_compare_the_upper_bits_of_an_extended_identifier() {
        let mut f = filters();
        f.is_active = 1;
        let extended = Frame::data_frame(Id::Extended(0x155 << 18 | 5 << 15), &[]);
        f.banks[0] = [0xffff_0000 | 0x155 << 5 | 1 << 3 | 5, 0xffff_ffff];
        assert_eq!(f.accept(&extended).map(|a| a.index), Some(0));
        f.banks[0][0] ^= 1;
        assert_eq!(f.accept(&extended), None);
    }

    #[test]
    fn the_more_exact_filter_has_priority_and_numbers_count_within_their_fifo() {
        let mut f = filters();
        // Bank 0: two narrow masks that take all; bank 1: a wide list, into FIFO 1, inactive;
        // bank 2: a wide list, into FIFO 1.
        (f.is_wide, f.is_list, f.to_second) = (0b110, 0b110, 0b110);
        f.is_active = 0b101;
        f.banks[2] = [0x10 << 21, 0x11 << 21];
        assert_eq!(
            f.accept(&standard(0x12)),
            Some(Accepted { fifo: 0, index: 0 })
        );
        assert_eq!(
            f.accept(&standard(0x11)),
            Some(Accepted { fifo: 1, index: 3 })
        );
    }

    #[test]
    fn banks_from_the_split_on_belong_to_the_other_controller() {
        let mut f = filters();
        (f.is_wide, f.is_active) = (1 << 14, 1 << 14);
        assert_eq!(f.accept(&standard(1)), None);
        f.control = 0x2a1c_0f00;
        assert!(f.accept(&standard(1)).is_some());
    }
}
