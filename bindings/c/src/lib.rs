//! C library of the smart actuator: the board's own control core and its models.
//!
//! No heap, no clock, no thread, no global state. The interface of C is `include/actuator.h`, which
//! is generated from this crate; a test compares the two. On a target without an operating
//! system the library needs nothing but the compiler's own routines.

#![no_std]

#[cfg(any(test, not(target_os = "none")))]
extern crate std;

pub mod actuator;
pub mod error;
mod memory;
pub mod settings;
pub mod state;
pub mod text;

/// No input makes `model-core` or this library panic, but the compiler requires a panic handler.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    loop {}
}
