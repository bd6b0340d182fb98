//! What the control step works with must not change while the CANopen device is in use for the bus.

use firmware::drive::{Control, Counted};

use super::words::checksum_of;

/// The checksum of what the control step works with, and the number of changes when it was made.
#[derive(Clone, Copy)]
pub struct ControlSeal {
    changes: u32,
    checksum: u32,
}

impl ControlSeal {
    /// The seal of the present values.
    pub fn new(control: &Counted<Control>) -> Self {
        Self {
            changes: control.changes(),
            checksum: checksum_of(&**control),
        }
    }

    /// The seal of the present values, unless they are others than before without a change.
    pub fn renew(self, control: &Counted<Control>) -> Option<Self> {
        let present = Self::new(control);
        let is_changed = present.changes != self.changes;
        (is_changed || present.checksum == self.checksum).then_some(present)
    }
}
