//! What tells this chip from all others.

use stm32f4xx_hal::signature::Uid;

/// The three words of the unique ID (RM0090, section 39.1) in one: wafer, lot and place on the wafer are in different
/// bits of each.
pub fn serial_number() -> u32 {
    let words: &[u32; 3] = {
        // SAFETY: three words of read-only memory that is always there.
        unsafe { &*core::ptr::from_ref(Uid::get()).cast() }
    };
    let [x_y, wafer_and_lot, lot] = *words;
    x_y ^ wafer_and_lot.rotate_left(11) ^ lot.rotate_left(22)
}
