//! Simulation of the smart actuator on the host: the board's own control core, the paper's models
//! and everything that looks at their traces.

pub mod analysis;
pub mod plot;
pub mod report;
pub mod trace;
pub mod tune;
