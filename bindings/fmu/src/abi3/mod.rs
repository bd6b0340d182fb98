//! The C interface of FMI 3.0.
//!
//! Function names, argument types and their meaning are those of `fmi3Functions.h` of the standard.
//! Instances, variables and their value references are those of FMI 2.0, see [`crate::abi`]; the
//! time is a variable as well.
//!
//! # Safety
//! As in [`crate::abi`].
#![allow(
    unsafe_code,
    reason = "pointers from C; each use is argued where it is"
)]
#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    reason = "the standard's names, and the safety section above holds for every function"
)]

mod exchange;
mod lifecycle;
mod states;
pub(crate) mod step;
mod unsupported;
mod values;

pub use exchange::*;
pub use lifecycle::*;
pub use states::*;
pub use step::*;
pub use unsupported::*;
pub use values::*;

/// `fmi3Boolean`, a C `bool`: read as a byte, as a host may write any.
pub type Boolean = u8;
