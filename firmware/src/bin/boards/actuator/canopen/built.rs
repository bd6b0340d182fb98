//! What is built once and stays where it is: the device, and who keeps its parameters.

use core::mem::MaybeUninit;

use firmware::{
    application::Start,
    drive::{Device, StoredParameters},
    store::{self, Origin},
    supervisor::ResetCause,
};

use crate::actuator::{
    boot_stack, flash::Flash, keeper::Keeper, serial_number::serial_number, slot::Taker,
};

/// The device with its parameters.
pub struct Built {
    pub device: Device<'static>,
    pub keeper: Keeper<StoredParameters>,
    /// Where the parameters come from.
    pub origin: Origin,
}

/// Builds all of it in its place, with what the flash holds. For `init` alone.
pub fn build(
    place: &'static mut MaybeUninit<Built>,
    (flash, to_save): (Flash, Taker<StoredParameters>),
    reset_cause: ResetCause,
    capture: &'static mut [i32],
) -> &'static mut Built {
    let fill = || {
        let loaded = store::load::<StoredParameters>(&flash);
        let start = Start {
            watchdog: reset_cause == ResetCause::Watchdog,
            parameters_corrupt: loaded.origin == Origin::DefaultsInsteadOfCorrupt,
        };
        let mut device = Device::new(loaded.parameters, start, capture, 0);
        device.drive.diagnostics.reset_cause = reset_cause;
        device.drive.diagnostics.serial_number = serial_number();
        place.write(Built {
            device,
            origin: loaded.origin,
            keeper: Keeper::new(to_save, flash, &loaded),
        });
    };
    // SAFETY: `init` calls this, with interrupts masked, and nothing in it calls the boot stack.
    unsafe { boot_stack::call(fill) };
    // SAFETY: it has just been written.
    unsafe { place.assume_init_mut() }
}
