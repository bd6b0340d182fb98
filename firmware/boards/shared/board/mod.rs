//! What the programs of all boards share.
//!
//! Each program includes this module with one line. It is not a part of a library: the libraries
//! forbid unsafe code, which registers and exception handlers need. The programs have the module
//! `chip` beside it, with the names and addresses of their chip's registers.

/// States in the section `.board`, which is not loaded, what a program is and for which chip.
macro_rules! board_is {
    ($role:literal, $chip:literal) => {
        #[used]
        #[unsafe(link_section = ".board")]
        static BOARD: [u8; BOARD_IS.len()] = {
            let mut bytes = [0; BOARD_IS.len()];
            let mut at = 0;
            while at < bytes.len() {
                bytes[at] = BOARD_IS.as_bytes()[at];
                at += 1;
            }
            bytes
        };
        const BOARD_IS: &str = concat!($role, ", ", $chip);
    };
}

pub mod diagnostics;
pub mod log;
pub mod safe_state;
pub mod setup;
pub mod watchdog;
