//! Fault plans: kind, start and duration of faults, as Rust values or from a file.
//!
//! ```toml
//! [[fault]]
//! at_ms = 1500.0                 # or at_instruction = 1_000_000
//! for_ms = 100.0                 # permanent if omitted
//! what = { encoder_wire = { line = "data", stuck = "low" } }
//!
//! [[fault]]
//! at_symbol = "device_control"   # at the entry of this function ...
//! hit = 3                        # ... for the third time
//! what = { flip_ram = { symbol = "STATE", bit = 5 } }
//!
//! [[fault]]
//! at_ms = 2000.0
//! what = "jam"
//! ```

mod file;
mod injector;
mod kind;
mod plant;

pub use file::{PlanError, parse_plan};
pub use injector::{Change, Injector};
pub use kind::{Fault, FilterBit, MagnetState, MemoryLocation};

/// Start of a fault.
#[derive(Debug, Clone, PartialEq)]
pub enum Trigger {
    /// At this instant of virtual time, ns.
    At {
        /// ns from power-on.
        ns: u64,
    },
    /// After this number of executed instructions.
    Instruction {
        /// Instructions from power-on.
        count: u64,
    },
    /// At the entry of a function.
    Symbol {
        /// The function's name in the ELF file.
        name: String,
        /// Number of the entry, from 1.
        hit: u64,
    },
}

/// A planned fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Its start.
    pub trigger: Trigger,
    /// Its duration, ns; `None` for a permanent fault.
    pub for_ns: Option<u64>,
    /// The fault.
    pub fault: Fault,
}

impl Planned {
    /// A permanent fault from this instant on, ms.
    pub fn at_ms(at_ms: u64, fault: Fault) -> Self {
        Self::at_ns(at_ms * 1_000_000, fault)
    }

    /// A permanent fault from this instant on, ns.
    pub fn at_ns(ns: u64, fault: Fault) -> Self {
        Self {
            trigger: Trigger::At { ns },
            for_ns: None,
            fault,
        }
    }

    /// The same fault with this duration, ms.
    pub fn for_ms(self, for_ms: u64) -> Self {
        Self {
            for_ns: Some(for_ms * 1_000_000),
            ..self
        }
    }
}
