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
/// [`MOST`] the first.
pub fn let_in(can: &CAN1, identifiers: impl Iterator<Item = (Id, bool)>) {
    can.fmr().modify(|_, w| w.finit().set_bit());
    let mut words = identifiers.map(word);
    let mut banks = 0u32;
    for bank in can.fb_iter().take(MOST / 2) {
        let Some(first) = words.next() else { break };
        banks = banks << 1 | 1;
        // SAFETY: any bits make a filter. A second place that is left over lets in what the first one does.
        unsafe {
            bank.fr1().write(|w| w.bits(first));
            bank.fr2().write(|w| w.bits(words.next().unwrap_or(first)));
        }
    }
    // SAFETY: one bit for each bank.
    unsafe {
        can.fm1r().write(|w| w.bits(banks));
        can.ffa1r().write(|w| w.bits(0));
        can.fs1r().write(|w| w.bits(banks));
        can.fa1r().write(|w| w.bits(banks));
    }
    can.fmr().modify(|_, w| w.finit().clear_bit());
}

/// As a list of 32-bit identifiers holds it.
fn word((id, remote): (Id, bool)) -> u32 {
    let kind = if remote { REMOTE } else { 0 };
    kind | match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    }
}
