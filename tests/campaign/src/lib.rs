//! A campaign of faults injected into the emulated board, judged by what the shaft does.
//!
//! An experiment powers the board on, has a master start a motion, inverts one bit of the memory or
//! of a register of the core, or skips an instruction, at a random instant, and continues the
//! motion. Its angle is compared with that of an undisturbed board with the same master. Place and
//! instant of each injection follow from the seed and the number of the experiment.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod campaign;
pub mod experiment;
pub mod injection;
pub mod injector;
pub mod motion;
pub mod outcome;
mod page;
pub mod results;
mod tell;

pub use page::{Row, replace_table, table};
