//! The types of `fmi2FunctionTypes.h` and `fmi2TypesPlatform.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

use super::report::Reporter;
use crate::abi3::step::IntermediateUpdates;
use crate::instance::Instance;

/// `fmi2Boolean`: 0 is false.
pub type Boolean = c_int;

/// `fmi2ValueReference`.
pub type ValueReference = c_uint;

/// `fmi2FMUstate`: the key of a saved state, null for none.
pub type FmuState = *mut c_void;

/// `fmi2Status`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(C)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// Done with a warning; not used.
    Warning = 1,
    /// Not done; the host may continue without it.
    Discard = 2,
    /// Not done; nothing changed.
    Error = 3,
    /// All instances are unusable; not used.
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

/// `fmi3LogMessageCallback`.
pub type MessageLogger = unsafe extern "C" fn(
    environment: *mut c_void,
    status: Status,
    category: *const c_char,
    message: *const c_char,
);

/// `fmi2CallbackFunctions`; only the logger is used.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub struct CallbackFunctions {
    /// Logs a message.
    pub logger: Option<Logger>,
    /// Allocates memory.
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Frees memory.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Called at the end of an asynchronous step.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, Status)>,
    /// First argument of the callbacks.
    pub component_environment: *mut c_void,
}

/// The target of `fmi2Component`.
#[derive(Debug)]
pub struct Component {
    pub(crate) instance: Instance,
    pub(crate) reporter: Reporter,
    /// The intermediate updates of a host of FMI 3.0 that asks for them.
    pub(crate) updates: Option<IntermediateUpdates>,
}
