//! The control step of the board, in fixed point.

pub mod parameters;
pub mod units;
