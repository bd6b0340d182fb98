//! What the tests on the emulated board share: the program, its frames, and the same application
//! run natively on the same plant.

pub mod canopen;
pub mod chain;
pub mod comm;
pub mod cuts;
pub mod frames;
pub mod native;
pub mod native_plant;
pub mod runs;
