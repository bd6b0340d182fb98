//! What the tests on the emulated board share.

#[path = "../../src/board_elf.rs"]
pub mod board_elf;
