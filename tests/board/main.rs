//! The release ELF on the emulated board.

mod closed_loop;
