//! Acceptance filter of the CAN controller: 14 filter banks as one list of 28 identifiers (RM0090,
//! section 32.7.4).

use embedded_can::Id;
use firmware::drive::{RPDOS, TPDOS};
use stm32f4xx_hal::pac::CAN1;

/// Identifiers of the filter list: two in each bank.
const FILTERS: usize = 28;

/// Maximum number of identifiers that a node receives.
const MAXIMUM: usize = canopen::SERVICE_IDENTIFIERS + RPDOS + TPDOS;
const _: () = assert!(MAXIMUM <= FILTERS);

/// Bits of a filter word that give the kind of the frame.
const REMOTE: u32 = 1 << 1;
const EXTENDED: u32 = 1 << 2;

/// Filter words of the identifiers that the node receives.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct AcceptedIds {
    words: [u32; MAXIMUM],
    count: usize,
}

impl AcceptedIds {
    /// The list of these identifiers, each with whether of remote frames.
    pub fn new(identifiers: impl Iterator<Item = (Id, bool)>) -> Self {
        let mut accepted = Self {
            words: [0; MAXIMUM],
            count: 0,
        };
        for (word, identifier) in accepted.words.iter_mut().zip(identifiers) {
            *word = filter_word(identifier);
            accepted.count += 1;
        }
        accepted
    }

    /// Filter words of the list.
    fn words(&self) -> impl Iterator<Item = u32> {
        self.words.iter().take(self.count).copied()
    }
}

/// Sets the filter up after a reset, while its initialisation mode is on: frames with these
/// identifiers go to FIFO 0, all others are rejected.
pub fn set_up(can: &CAN1, accepted: &AcceptedIds) {
    // SAFETY: one bit for each bank; banks without an identifier remain inactive.
    unsafe {
        can.fm1r().write(|w| w.bits(u32::MAX >> 4));
        can.ffa1r().write(|w| w.bits(0));
        can.fs1r().write(|w| w.bits(u32::MAX >> 4));
    }
    can.fmr().modify(|_, w| w.finit().clear_bit());
    change(can, accepted);
}

/// Changes the list while frames are received. Only the banks that differ are off meanwhile, so
/// that the others continue to receive; the change may be interrupted.
pub fn change(can: &CAN1, accepted: &AcceptedIds) {
    let mut words = accepted.words();
    let mut active_banks = 0;
    for (number, bank) in can.fb_iter().take(FILTERS / 2).enumerate() {
        let Some(first) = words.next() else { break };
        // The second half of the last bank repeats the first.
        let second = words.next().unwrap_or(first);
        let bit = 1 << number;
        active_banks |= bit;
        if (bank.fr1().read().bits(), bank.fr2().read().bits()) != (first, second) {
            // SAFETY: one bit for each bank, and any bits make a filter.
            unsafe {
                can.fa1r().modify(|r, w| w.bits(r.bits() & !bit));
                bank.fr1().write(|w| w.bits(first));
                bank.fr2().write(|w| w.bits(second));
            }
        }
    }
    // SAFETY: as above.
    can.fa1r().write(|w| unsafe { w.bits(active_banks) });
}

/// The 32-bit word of an identifier in list mode.
fn filter_word((id, is_remote): (Id, bool)) -> u32 {
    let kind = if is_remote { REMOTE } else { 0 };
    kind | match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}
