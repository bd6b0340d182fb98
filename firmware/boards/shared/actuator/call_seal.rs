//! What a call for the bus accesses rarely must not change while the CANopen device is in use.

use canopen::{Counted, PdoTable};
use firmware::drive::{Commands, Control, Device, RPDOS, TPDOS};

use super::words::checksum_of;

/// The bounds of the loops of the checksums rely on these sizes: 3, 44 and 28 times eight words.
const _: () = assert!(size_of::<Commands>() <= 3 * 32);
const _: () = assert!(size_of::<Control>() <= 44 * 32);
const _: () = assert!(size_of::<PdoTable<RPDOS, TPDOS>>() <= 28 * 32);

/// Seals of application and axis, and of the parameters of the PDOs.
#[derive(Clone, Copy)]
pub struct CallSeal {
    control: CountedSeal,
    pdos: CountedSeal,
}

impl CallSeal {
    /// The seal of the present values.
    pub fn new(device: &Device<'_>) -> Self {
        Self {
            control: CountedSeal::new(device.drive.control(), checksum_of_control),
            pdos: CountedSeal::new(device.node().pdo_table(), checksum_of_pdos),
        }
    }

    /// The seal of the present values; `None` if any of them has changed without an access.
    pub fn renew(self, device: &Device<'_>) -> Option<Self> {
        let present = Self::new(device);
        let is_intact = self.control.leads_to(present.control) && self.pdos.leads_to(present.pdos);
        is_intact.then_some(present)
    }

    /// The seal after a control step, which may change application and axis but no parameter of a
    /// PDO; `None` if one has changed without an access.
    pub fn renew_after_step(self, device: &Device<'_>) -> Option<Self> {
        let present = Self::new(device);
        self.pdos.leads_to(present.pdos).then_some(present)
    }
}

/// The checksum of a value, and the number of accesses to it when it was computed.
#[derive(Clone, Copy)]
struct CountedSeal {
    accesses: u32,
    checksum: u32,
}

impl CountedSeal {
    fn new<T>(value: &Counted<T>, checksum: impl FnOnce(&T) -> u32) -> Self {
        Self {
            accesses: value.accesses(),
            checksum: checksum(value),
        }
    }

    /// Whether the value of a later seal is the same, or was accessed since.
    fn leads_to(self, later: Self) -> bool {
        self.accesses != later.accesses || self.checksum == later.checksum
    }
}

/// The checksum of the commands to the drive.
#[inline(never)]
pub fn checksum_of_commands(device: &Device<'_>) -> u32 {
    checksum_of(device.drive.commands())
}

#[inline(never)]
fn checksum_of_control(control: &Control) -> u32 {
    checksum_of(control)
}

#[inline(never)]
fn checksum_of_pdos(table: &PdoTable<RPDOS, TPDOS>) -> u32 {
    checksum_of(table)
}
