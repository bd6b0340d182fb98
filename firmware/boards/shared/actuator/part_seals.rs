//! Parts of the CANopen device that must not change while it is in use, unless that use accesses
//! them.

use core::mem::replace;

use canopen::{Counted, PdoTable};
use firmware::drive::{Commands, Control, Device, RPDOS, TPDOS};

use super::words::checksum_of;

/// The bounds of the loops of the checksums rely on these sizes: 3, 44 and 28 times eight words.
const _: () = assert!(size_of::<Commands>() <= 3 * 32);
const _: () = assert!(size_of::<Control>() <= 44 * 32);
const _: () = assert!(size_of::<PdoTable<RPDOS, TPDOS>>() <= 28 * 32);

/// Seals of application and axis, of the parameters of the PDOs, and of the commands to the drive.
pub struct PartSeals {
    control: CountedSeal,
    pdos: CountedSeal,
    commands: CountedSeal,
}

impl PartSeals {
    /// The seals of the present values.
    #[inline(never)]
    pub fn new(device: &Device<'_>) -> Self {
        Self {
            control: CountedSeal::new(device.drive.control(), checksum_of_control),
            pdos: CountedSeal::new(device.node().pdo_table(), checksum_of_pdos),
            commands: CountedSeal::new(device.drive.commands(), checksum_of_commands),
        }
    }

    /// Seals the present values; returns whether none of them has changed without an access since
    /// the last time.
    pub fn renew(&mut self, device: &Device<'_>) -> bool {
        let before = replace(self, Self::new(device));
        before.control.leads_to(self.control)
            && before.pdos.leads_to(self.pdos)
            && before.commands.leads_to(self.commands)
    }

    /// Seals the commands that process data have made.
    pub fn renew_commands(&mut self, device: &Device<'_>) {
        self.commands = CountedSeal::new(device.drive.commands(), checksum_of_commands);
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

#[inline(never)]
fn checksum_of_control(control: &Control) -> u32 {
    checksum_of(control)
}

#[inline(never)]
fn checksum_of_pdos(table: &PdoTable<RPDOS, TPDOS>) -> u32 {
    checksum_of(table)
}

#[inline(never)]
fn checksum_of_commands(commands: &Commands) -> u32 {
    checksum_of(commands)
}
