//! CAN on the PC: actuators that run natively on a virtual bus, and a client for real and simulated
//! buses.
//!
//! ```text
//! client ── link ── slcan over TCP, a serial line or a terminal ── server ── bus ── native nodes
//!              └── SocketCAN ── real actuators
//! ```

mod acceptance;
pub mod bus;
pub mod bus_load;
pub mod capture;
pub mod client;
pub mod excitation;
pub mod fault_history;
pub mod link;
pub mod mapped;
pub mod motor_objects;
pub mod multicast;
pub mod names;
pub mod native_link;
pub mod native_node;
pub mod node_fault;
pub mod scan;
pub mod sdo;
pub mod server;
pub mod service;
pub mod supervised;
pub mod telemetry;
pub mod update;
