//! Which frames the controller lets in: CAN1's 14 filter banks as one list of 28 identifiers (RM0090,
//! section 32.7.4).

use embedded_can::Id;
use stm32f4xx_hal::pac::CAN1;

/// Identifiers in the list: two a bank.
pub const MOST: usize = 28;

/// Bits of a filter word that say what the frame is.
const REMOTE: u32 = 1 << 1;
const EXTENDED: u32 = 1 << 2;

/// Lets the frames with these identifiers in, remote ones where it says so, all into queue 0, and no others; of more than
/// [`MOST`] the first. After a reset the filters are in their initialisation; here they leave it.
pub fn set_up(can: &CAN1, identifiers: impl Iterator<Item = (Id, bool)>) {
    // SAFETY: one bit for each bank; banks without an identifier stay off.
    unsafe {
        can.fm1r().write(|w| w.bits(u32::MAX >> 4));
        can.ffa1r().write(|w| w.bits(0));
        can.fs1r().write(|w| w.bits(u32::MAX >> 4));
    }
    can.fmr().modify(|_, w| w.finit().clear_bit());
    change(can, identifiers);
}

/// The same while frames come in. Banks that change are off meanwhile, the others go on: while the filters as a whole are
/// initialised nothing would come in, and a change may be interrupted.
pub fn change(can: &CAN1, identifiers: impl Iterator<Item = (Id, bool)>) {
    let mut words = identifiers.map(word);
    let mut banks = 0;
    for (number, bank) in can.fb_iter().take(MOST / 2).enumerate() {
        let Some(first) = words.next() else { break };
        // A second place that is left over lets in what the first one does.
        let second = words.next().unwrap_or(first);
        let is_on = 1 << number;
        banks |= is_on;
        if (bank.fr1().read().bits(), bank.fr2().read().bits()) != (first, second) {
            // SAFETY: one bit for each bank, and any bits make a filter.
            unsafe {
                can.fa1r().modify(|r, w| w.bits(r.bits() & !is_on));
                bank.fr1().write(|w| w.bits(first));
                bank.fr2().write(|w| w.bits(second));
            }
        }
    }
    // SAFETY: as above.
    can.fa1r().write(|w| unsafe { w.bits(banks) });
}

/// As a list of 32-bit identifiers holds it.
fn word((id, remote): (Id, bool)) -> u32 {
    let kind = if remote { REMOTE } else { 0 };
    kind | match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}
