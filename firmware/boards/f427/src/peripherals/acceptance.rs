//! Acceptance filter of the CAN controller: 14 filter banks as one list of 28 identifiers, or of 14
//! identifiers with masks (RM0090, section 32.7.4).

use drivers::can::AcceptedIds;

use crate::chip::pac::CAN1;

/// Identifiers of the filter list: two in each bank.
const FILTERS: usize = 28;
const _: () = assert!(AcceptedIds::MAXIMUM <= FILTERS);

/// The registers of the filter, which no other part of the program accesses after the start.
pub struct Acceptance(CAN1);

impl Acceptance {
    /// The filter after a reset, while its initialisation mode is on: frames with these identifiers
    /// go to FIFO 0, all others are rejected. It has masks as long as the first list has.
    pub fn new(can: CAN1, accepted: &AcceptedIds) -> Self {
        let lists = if accepted.has_masks() {
            0
        } else {
            u32::MAX >> 4
        };
        // SAFETY: one bit for each bank; banks without an identifier remain inactive.
        unsafe {
            can.fm1r().write(|w| w.bits(lists));
            can.ffa1r().write(|w| w.bits(0));
            can.fs1r().write(|w| w.bits(u32::MAX >> 4));
        }
        can.fmr().modify(|_, w| w.finit().clear_bit());
        let mut acceptance = Self(can);
        acceptance.set(accepted);
        acceptance
    }

    /// Makes these the identifiers of the frames that are received, while frames are received. Only
    /// the banks that differ are off meanwhile, so that the others continue to receive; the change
    /// may be interrupted. It also corrects identifiers and activation bits that have changed by
    /// themselves.
    pub fn set(&mut self, accepted: &AcceptedIds) {
        let can = &self.0;
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
}
