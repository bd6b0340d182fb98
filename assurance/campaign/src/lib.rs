//! A campaign of faults injected into the emulated board, judged by what the shaft does.
//!
//! The emulated board is powered on, and a master starts a motion. At the instant of an injection the
//! process is copied (`fork.rs`), and the copy carries out the experiment: it inverts one bit of the
//! memory or of a register of the core, or skips an instruction, and continues the motion. Its angle
//! is compared with that of the undisturbed twin. Place and instant of each injection follow
//! from the seed and the number of the experiment.

#![deny(missing_docs)]

pub mod campaign;
pub mod class;
mod experiment;
mod fork;
pub mod injection;
mod injector;
pub mod motion;
mod original;
pub mod outcome;
mod page;
mod reports;
pub mod results;
mod timetable;
mod twin;

pub use page::{Row, table};
