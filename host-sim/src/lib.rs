//! Simulation of the smart actuator on a PC: the board's control core, the models of the paper,
//! CAN, and the evaluation of traces.

pub mod analysis;
pub mod can;
pub mod commission;
pub mod dronecan_client;
pub mod error;
pub mod file;
pub mod fit_page;
pub mod input;
pub mod mjcf;
pub mod page;
pub mod plot;
pub mod report;
pub mod scenario;
pub mod servo_bus;
pub mod settings;
pub mod simulate;
pub mod table;
pub mod trace;
pub mod trace_file;
pub mod tune;
