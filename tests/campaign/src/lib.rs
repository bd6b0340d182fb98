//! A campaign of faults injected into the emulated board, judged by what the shaft does.
//!
//! The emulated board is powered on, and a master starts a motion. At the instant of an injection the
//! process is copied (`fork.rs`), and the copy carries out the experiment: it inverts one bit of the
//! memory or of a register of the core, or skips an instruction, and continues the motion. Its angle
//! is compared with that of the undisturbed twin. Place and instant of each injection follow
//! from the seed and the number of the experiment.
//!
//! Before the experiments of a motion its undisturbed board is recorded (`recording.rs`): an
//! injection into what is overwritten before it is read, or never read, has no effect
//! (`defuse.rs`), and one experiment stands for all that the same pass of a check reads first
//! (`pruning.rs`).

#![deny(missing_docs)]

mod accesses;
pub mod campaign;
pub mod class;
mod defuse;
mod digest;
mod effects;
mod experiment;
mod fork;
pub mod history;
pub mod injection;
mod injector;
mod liveness;
pub mod motion;
pub mod outcome;
mod page;
mod picture;
mod pruning;
mod recording;
pub mod results;
mod routes;
mod snapshots;
mod streams;
mod survey;
mod tell;
mod timetable;
mod twin;

pub use page::{Row, replace_table, table, total};
pub use picture::picture;
