//! Acceptance filter of received frames: an SJA1000 in dual-filter mode (data sheet, figures 10 and
//! 12), which defines the acceptance code and mask of a CANUSB.

use embedded_can::Frame;

use crate::CanFrame;

/// Acceptance code and mask; a bit that is set in the mask is "don't care".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Acceptance {
    /// Acceptance code: ACR0 in the upper byte, ACR3 in the lower one.
    pub code: u32,
    /// Acceptance mask, in the same byte order.
    pub mask: u32,
}

impl Default for Acceptance {
    /// Accepts all frames.
    fn default() -> Self {
        Self {
            code: 0,
            mask: u32::MAX,
        }
    }
}

impl Acceptance {
    /// Whether one of the two filters accepts a frame.
    ///
    /// ```
    /// use canopen::{CanFrame, slcan::Acceptance};
    /// // Both filters accept 601h; RTR bit and data are "don't care".
    /// let only = Acceptance { code: 0xC020_C020, mask: 0x001F_001F };
    /// let accepts = |id| only.accepts(&CanFrame::raw(id, false, false, 0, [0; 8]).unwrap());
    /// assert_eq!([0x601, 0x602, 0x001].map(accepts), [true, false, false]);
    /// ```
    #[must_use]
    pub fn accepts(&self, frame: &CanFrame) -> bool {
        let (id, extended) = frame.raw_id();
        let differs = |bits: u32, matter: u32| (bits ^ self.code) & !self.mask & matter;
        if extended {
            // Each filter compares the upper 16 of the 29 bits.
            let upper = id >> 13;
            let bits = upper << 16 | upper;
            return differs(bits, 0xFFFF_0000) == 0 || differs(bits, 0x0000_FFFF) == 0;
        }
        let head = id << 5 | u32::from(frame.is_remote_frame()) << 4;
        let [first, ..] = frame.bytes();
        // Filter 1 also compares the first data byte, its lower nibble in the lower nibble of the
        // last register.
        let bits = (head | u32::from(first >> 4)) << 16 | head | u32::from(first & 15);
        let matter = if frame.data().is_empty() {
            0xFFF0_0000
        } else {
            0xFFFF_000F
        };
        differs(bits, matter) == 0 || differs(bits, 0x0000_FFF0) == 0
    }
}
