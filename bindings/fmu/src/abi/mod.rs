//! The C interface of FMI 2.0 for co-simulation.
//!
//! Function names, argument types and their meaning are those of `fmi2Functions.h` of the standard.
//! Every function but the first two takes a component and gives a status. No panic leaves a
//! function, and nothing is global: instances may run in parallel, as long as each is called from
//! one thread at a time.
//!
//! # Safety
//! What the standard asks of the host is asked of the callers of all functions here: a component
//! comes from `fmi2Instantiate` and was not freed; a pointer that comes with a number of elements
//! leads to so many; strings end in a nul. Null pointers are found and refused. A kept state is a
//! number in the guise of a pointer, which is never followed: any value may be passed.
#![allow(
    unsafe_code,
    reason = "pointers from C; each use is argued where it is"
)]
#![allow(
    non_snake_case,
    clippy::missing_safety_doc,
    reason = "the standard's names, and the safety section above holds for every function"
)]

mod call;
mod lifecycle;
mod report;
mod states;
mod status;
mod types;
mod values;

pub use lifecycle::*;
pub use states::*;
pub use status::*;
pub use types::*;
pub use values::*;
