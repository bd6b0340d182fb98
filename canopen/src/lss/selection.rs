//! LSS selection of one node by its identity: switch state selective, identify remote slave, fast
//! scan.

use super::Identity;

/// Progress of each of the three services.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Selection {
    selected: u8,
    identified: u8,
    scanned: u8,
}

impl Selection {
    pub const fn new() -> Self {
        Self {
            selected: 0,
            identified: 0,
            scanned: 0,
        }
    }

    /// Switch state selective: four numbers in order, which must match the identity. Returns
    /// whether this was the last.
    pub fn select(&mut self, part: u8, number: u32, identity: Identity) -> bool {
        let own = identity.get(usize::from(part)).copied();
        advance(&mut self.selected, part, 4, own == Some(number))
    }

    /// Identify remote slave: vendor-ID, product code, revision range, serial number range. Returns
    /// whether this was the last.
    pub fn identify(&mut self, part: u8, number: u32, identity: Identity) -> bool {
        let [vendor, product, revision, serial] = identity;
        let fits = match part {
            0 => vendor == number,
            1 => product == number,
            2 => revision >= number,
            3 => revision <= number,
            4 => serial >= number,
            5 => serial <= number,
            _ => false,
        };
        advance(&mut self.identified, part, 6, fits)
    }

    /// One step of a fast scan. `None`: the node does not respond. `Some(true)`: the node is found
    /// and enters the configuration state.
    pub fn fast_scan(
        &mut self,
        number: u32,
        bit: u8,
        sub: u8,
        next: u8,
        identity: Identity,
    ) -> Option<bool> {
        if bit == 0x80 {
            self.scanned = 0;
            return Some(false);
        }
        let own = *identity.get(usize::from(sub))?;
        let checked = u32::MAX.checked_shl(u32::from(bit))?;
        if sub != self.scanned || next > 3 || (own ^ number) & checked != 0 {
            return None;
        }
        if bit != 0 {
            return Some(false);
        }
        // All 32 bits match: continue with the next number, or end the scan if it is an earlier
        // one.
        self.scanned = next;
        Some(next < sub)
    }
}

/// Accepts part `part` of `parts` if it is the next one and matches; part 0 restarts. Returns
/// whether it was the last.
fn advance(stage: &mut u8, part: u8, parts: u8, fits: bool) -> bool {
    if part == 0 {
        *stage = 0;
    }
    if part != *stage || !fits {
        *stage = 0;
        return false;
    }
    *stage += 1;
    let all = *stage == parts;
    if all {
        *stage = 0;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDENTITY: Identity = [0x1234, 0x5341, 0x0001_0000, 0xCAFE_F00D];

    #[test]
    fn selection_requires_all_four_numbers_in_order() {
        let mut selection = Selection::new();
        let mut feed = |parts: &[(u8, u32)]| {
            let select = |_, &(part, number): &(u8, u32)| selection.select(part, number, IDENTITY);
            parts.iter().fold(false, select)
        };
        let all = [
            (0, IDENTITY[0]),
            (1, IDENTITY[1]),
            (2, IDENTITY[2]),
            (3, IDENTITY[3]),
        ];
        assert!(feed(&all));
        assert!(!feed(&all[1..]));
        assert!(!feed(&[all[0], all[1], (2, 0), all[3]]));
        assert!(feed(&all));
    }

    #[test]
    fn identification_matches_ranges() {
        let mut selection = Selection::new();
        let mut feed = |serial: (u32, u32)| {
            let numbers = [IDENTITY[0], IDENTITY[1], 0, u32::MAX, serial.0, serial.1];
            let identify = |_, (part, number)| selection.identify(part, number, IDENTITY);
            (0u8..).zip(numbers).fold(false, identify)
        };
        assert!(feed((IDENTITY[3], IDENTITY[3])));
        assert!(!feed((0, IDENTITY[3] - 1)));
        assert!(!feed((IDENTITY[3] + 1, u32::MAX)));
    }

    /// Master side of CiA 305: a bit is 0 if a node responds, otherwise 1.
    #[test]
    fn fast_scan_finds_the_identity_bit_by_bit() {
        let mut node = Selection::new();
        assert_eq!(node.fast_scan(0, 0x80, 0, 0, IDENTITY), Some(false));
        for sub in 0..4u8 {
            let mut number = 0;
            for bit in (0..32u8).rev() {
                if node.fast_scan(number, bit, sub, sub, IDENTITY).is_none() {
                    number |= 1 << bit;
                }
            }
            assert_eq!(number, IDENTITY[usize::from(sub)]);
            let next = (sub + 1) % 4;
            assert_eq!(
                node.fast_scan(number, 0, sub, next, IDENTITY),
                Some(sub == 3)
            );
        }
    }

    #[test]
    fn fast_scan_ignores_invalid_requests() {
        let mut node = Selection::new();
        for (bit, sub, next) in [(32, 0, 0), (0x7F, 0, 0), (0, 4, 0), (0, 1, 2), (0, 0, 4)] {
            assert_eq!(node.fast_scan(IDENTITY[0], bit, sub, next, IDENTITY), None);
        }
    }
}
