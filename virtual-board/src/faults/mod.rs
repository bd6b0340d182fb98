//! What breaks, when, and for how long; as Rust values or from a file.
//!
//! ```toml
//! [[fault]]
//! at_ms = 1500.0                 # or at_instruction = 1_000_000
//! for_ms = 100.0                 # for good where it is left out
//! what = { encoder_wire = { line = "data", stuck = "low" } }
//!
//! [[fault]]
//! at_symbol = "application_step" # as the core arrives there ...
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

pub use file::{PlanError, read_plan};
pub(crate) use injector::{Change, Injector};
pub use kind::{Fault, MagnetState, Place};

/// When a fault begins.
#[derive(Debug, Clone, PartialEq)]
pub enum Trigger {
    /// At this instant of virtual time, ns.
    At {
        /// ns from power-on.
        ns: u64,
    },
    /// When so many instructions have been executed.
    Instruction {
        /// Instructions from power-on.
        count: u64,
    },
    /// As the core arrives at a function.
    Symbol {
        /// The function's name in the ELF file.
        name: String,
        /// The how-manieth arrival, from 1.
        hit: u64,
    },
}

/// A fault with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// When it begins.
    pub trigger: Trigger,
    /// How long it lasts, ns; for good where there is none.
    pub for_ns: Option<u64>,
    /// What breaks.
    pub fault: Fault,
}

impl Planned {
    /// A fault for good from this instant on, ms.
    pub fn at_ms(at_ms: u64, fault: Fault) -> Self {
        Self {
            trigger: Trigger::At {
                ns: at_ms * 1_000_000,
            },
            for_ns: None,
            fault,
        }
    }

    /// The same for so long, ms.
    pub fn for_ms(self, for_ms: u64) -> Self {
        Self {
            for_ns: Some(for_ms * 1_000_000),
            ..self
        }
    }
}
