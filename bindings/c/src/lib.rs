//! C library of the smart actuator: the board's own control core and its models.
//!
//! No heap, no clock, no thread, no global state. What C sees stands in `include/actuator.h`, which
//! is made from this crate; a test holds it against the source. On a target without an operating
//! system the library needs nothing but the compiler's own routines.

#![no_std]

#[cfg(any(test, not(target_os = "none")))]
extern crate std;

pub mod actuator;
pub mod error;
mod memory;
pub mod settings;
pub mod text;

/// No input makes `model-core` or this library panic; the linker wants a place to go all the same.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
