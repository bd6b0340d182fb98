//! The C interface of FMI 2.0.
//!
//! Function names, argument types and their meaning are those of `fmi2Functions.h` of the standard.
//! Every function except the first two takes a component and returns a status. No panic leaves a
//! function, and nothing is global: instances may run in parallel, as long as each is called from
//! one thread at a time.
//!
//! # Safety
//! Callers of all functions must meet the requirements of the standard for the host: a component
//! comes from `fmi2Instantiate` and has not been freed; a pointer with a number of elements points
//! to that many; strings are null-terminated. Null pointers are detected and refused. A saved state
//! is a number in a pointer, which is never dereferenced: any value may be passed.
#![allow(
    unsafe_code,
    reason = "pointers from C; each use is argued where it is"
)]
#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    reason = "the standard's names, and the safety section above holds for every function"
)]

pub(crate) mod call;
pub(crate) mod exchange;
pub(crate) mod lifecycle;
pub(crate) mod report;
pub(crate) mod states;
mod status;
mod types;
mod values;

pub use exchange::*;
pub use lifecycle::*;
pub use states::*;
pub use status::*;
pub use types::*;
pub use values::*;
