//! What stands in for the bench: motors, gear train, friction and load.

pub mod first_order;
