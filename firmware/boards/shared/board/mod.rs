//! What the programs of all boards share.
//!
//! Each program includes this module with one line. It is not a part of a library: the libraries
//! forbid unsafe code, which registers and exception handlers need. The programs have the module
//! `chip` beside it, with the names and addresses of their chip's registers.

pub mod diagnostics;
pub mod log;
pub mod safe_state;
pub mod setup;
pub mod watchdog;
