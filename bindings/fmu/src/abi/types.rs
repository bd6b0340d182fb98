//! The types of `fmi2FunctionTypes.h` and `fmi2TypesPlatform.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

use super::report::Reporter;
use crate::instance::Instance;

/// `fmi2Boolean`: 0 is false.
pub type Boolean = c_int;

/// `fmi2ValueReference`.
pub type ValueReference = c_uint;

/// `fmi2FMUstate`: the key of a kept state, null for none.
pub type FmuState = *mut c_void;

/// `fmi2Status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done, but something is odd; not used.
    Warning = 1,
    /// Not done; the host may go on without it.
    Discard = 2,
    /// Not done; nothing changed.
    Error = 3,
    /// No instance works any more; not used.
    Fatal = 4,
    /// Will be done later; not used.
    Pending = 5,
}

/// `fmi2CallbackLogger`.
pub type Logger = unsafe extern "C" fn(
    environment: *mut c_void,
    instance_name: *const c_char,
    status: Status,
    category: *const c_char,
    message: *const c_char,
    ...
);

/// `fmi2CallbackFunctions`; only the logger is used.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Takes messages.
    pub logger: Option<Logger>,
    /// Gives memory.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Takes memory back.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Told when an asynchronous step ends.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, Status)>,
    /// What the callbacks get as their first argument.
    pub component_environment: *mut c_void,
}

/// What `fmi2Component` leads to.
#[derive(Debug)]
pub struct Component {
    pub(super) instance: Instance,
    pub(super) reporter: Reporter,
}
