//! The boards as data: parts with their pins, the netlist, the processor's pins and the figures of
//! the data sheets, in the CSV files of `firmware/hardware/data`.
//!
//! [`mod@check`] finds errors of the design: pins that are not connected, supplies out of range,
//! outputs that oppose each other, measurements that saturate below a limit of the program.
//! [`mod@write`] generates the tables of `docs/hardware.md`, the schematic, the bill of materials
//! and the constants of model and firmware, so that each figure is in one file.

#![deny(missing_docs)]

pub mod check;
mod data;
mod design;
mod figures;
mod quantity;
mod rows;
mod servo_bus;
pub mod write;

pub use data::DataError;
pub use design::{Design, Net, PinOf, Range};
pub use figures::Divider;
pub use rows::{Electrical, Figure, Limit, Part, Pin, ProcessorPin};
pub use servo_bus::ServoBus;
