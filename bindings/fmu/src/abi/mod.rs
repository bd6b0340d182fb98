//! The C interfaces of FMI 2.0 and 3.0.
//!
//! Function names, argument types and their meaning are those of `fmi2Functions.h` and
//! `fmi3Functions.h` of the standard. Both versions have the same instances, variables, value
//! references and lifecycle; in FMI 3.0 the time is a variable as well. No panic leaves a function,
//! and nothing is global: instances may run in parallel, as long as each is called from one thread
//! at a time.
//!
//! # Safety
//! Callers of all functions must meet the requirements of the standard for the host: a component
//! comes from a function that instantiates and has not been freed; a pointer with a number of
//! elements points to that many; strings are null-terminated. Null pointers are detected and
//! refused. A saved state is a number in a pointer, which is never dereferenced: any value may be
//! passed.
#![allow(
    unsafe_code,
    reason = "pointers from C; each use is argued where it is"
)]
#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    reason = "the standard's names, and the safety section above holds for every function"
)]

#[macro_use]
mod call;
mod component;
mod exchange;
mod instantiation;
mod lifecycle;
mod report;
mod states;
mod step;
mod types;
mod unsupported;
mod updates;
mod values;

pub use component::Component;
pub use exchange::*;
pub use instantiation::*;
pub use lifecycle::*;
pub use states::*;
pub use step::*;
pub use types::*;
pub use unsupported::*;
pub use updates::*;
pub use values::*;
