//! Which frames the controller lets in: CAN1's 14 filter banks as one list of 28 identifiers (RM0090,
//! section 32.7.4).

use embedded_can::Id;
use stm32f4xx_hal::pac::CAN1;

/// Identifiers in the list: two a bank.
pub const MOST: usize = 28;

/// Bits of a filter word that say what the frame is.
const REMOTE: u32 = 1 << 1;
const EXTENDED: u32 = 1 << 2;

/// The list, in the layout of the filter registers.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Filters([u32; MOST]);

impl Filters {
    /// The first [`MOST`] of these identifiers, and whether of remote frames; at least one.
    pub fn of(mut identifiers: impl Iterator<Item = (Id, bool)>) -> Self {
        let first = identifiers.next().map_or(0, word);
        // Those that are left over let in what comes in anyway.
        let mut words = [first; MOST];
        for (place, wanted) in words.iter_mut().skip(1).zip(identifiers) {
            *place = word(wanted);
        }
        Self(words)
    }

    /// Lets these frames in, all into queue 0, and no others.
    pub fn put(&self, can: &CAN1) {
        const BANKS: u32 = (1 << (MOST / 2)) - 1;
        can.fmr().modify(|_, w| w.finit().set_bit());
        let (pairs, _) = self.0.as_chunks();
        for (bank, [first, second]) in can.fb_iter().zip(pairs) {
            // SAFETY: any bits make a filter.
            unsafe {
                bank.fr1().write(|w| w.bits(*first));
                bank.fr2().write(|w| w.bits(*second));
            }
        }
        // SAFETY: one bit for each bank.
        unsafe {
            can.fm1r().write(|w| w.bits(BANKS));
            can.ffa1r().write(|w| w.bits(0));
            can.fs1r().write(|w| w.bits(BANKS));
            can.fa1r().write(|w| w.bits(BANKS));
        }
        can.fmr().modify(|_, w| w.finit().clear_bit());
    }
}

fn word((id, remote): (Id, bool)) -> u32 {
    let kind = if remote { REMOTE } else { 0 };
    kind | match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}
