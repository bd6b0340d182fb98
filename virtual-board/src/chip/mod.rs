//! The microcontroller: the parts of rigless, with what they lack.

pub mod bus;
