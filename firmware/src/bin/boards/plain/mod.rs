//! The board with plain CAN frames, without CANopen: `firmware::frames` says which.

pub mod background;
pub mod control_step;
