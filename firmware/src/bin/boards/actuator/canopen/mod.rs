//! The board on CANopen: the drive steps at the edge of each tick, the node works at two of the PWM edges
//! between them.

pub mod background;
pub mod built;
pub mod setup;
pub mod station;
pub mod wanted;
