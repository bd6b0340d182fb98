//! Application and axis must not change while the CANopen device is in use for the bus.

use firmware::drive::{Control, Counted};

use super::words::checksum_of;

/// The checksum of application and axis, and the number of accesses to them when it was computed.
#[derive(Clone, Copy)]
pub struct ControlSeal {
    accesses: u32,
    checksum: u32,
}

impl ControlSeal {
    /// The seal of the present values.
    pub fn new(control: &Counted<Control>) -> Self {
        Self {
            accesses: control.accesses(),
            checksum: checksum(control),
        }
    }

    /// The seal of the present values; none if they have changed without an access.
    pub fn renew(self, control: &Counted<Control>) -> Option<Self> {
        let present = Self::new(control);
        let was_accessed = present.accesses != self.accesses;
        (was_accessed || present.checksum == self.checksum).then_some(present)
    }
}

#[inline(never)]
fn checksum(control: &Control) -> u32 {
    checksum_of(control)
}
