//! The types of `fmi2FunctionTypes.h`, `fmi2TypesPlatform.h` and `fmi3PlatformTypes.h`.

use std::ffi::{c_char, c_int, c_uint, c_void};

/// `fmi2Boolean`: 0 is false.
pub type Boolean2 = c_int;

/// `fmi3Boolean`, a C `bool`: read as a byte, as a host may write any.
pub type Boolean3 = u8;

/// `fmi2ValueReference` and `fmi3ValueReference`.
pub type ValueReference = c_uint;

/// `fmi2FMUstate` and `fmi3FMUState`: the key of a saved state, null for none.
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

/// `fmi2EventInfo`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct EventInfo {
    /// Whether the event iteration continues; it does not.
    pub new_discrete_states_needed: Boolean2,
    /// Whether the instance ends the simulation; it does not.
    pub terminate_simulation: Boolean2,
    /// Whether the nominal values have changed; they do not.
    pub nominals_of_continuous_states_changed: Boolean2,
    /// Whether the event has changed the continuous states.
    pub values_of_continuous_states_changed: Boolean2,
    /// Whether the time of the next event is known.
    pub next_event_time_defined: Boolean2,
    /// That time.
    pub next_event_time: f64,
}

/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: c_int = 3;
