//! Versions, instantiation and release.

use std::ffi::{c_char, c_int, c_void};
use std::ptr::null_mut;

use super::call::elements;
use super::component::{Component, found, free, made, text};
use super::report::Reporter;
use super::types::{
    Boolean2, Boolean3, CO_SIMULATION, CallbackFunctions, MODEL_EXCHANGE, MessageLogger, Status,
};
use super::updates::{IntermediateUpdateCallback, IntermediateUpdates};
use crate::instance::Instance;
use crate::variables;

/// The name of the types platform.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Creates an instance; null with a message for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: *const c_char,
    fmuType: c_int,
    fmuGUID: *const c_char,
    fmuResourceLocation: *const c_char,
    functions: *const CallbackFunctions,
    _visible: Boolean2,
    _loggingOn: Boolean2,
) -> *mut Component {
    if functions.is_null() || !functions.is_aligned() {
        return null_mut();
    }
    // SAFETY: neither null nor misaligned, and it points to the callbacks of the host.
    let callbacks = unsafe { *functions };
    // SAFETY: null or a string.
    let name = unsafe { text(instanceName) };
    let make = || {
        let make = match fmuType {
            CO_SIMULATION => |settings| Ok(Instance::new(settings)),
            MODEL_EXCHANGE => Instance::for_exchange,
            _ => return Err(format!("fmuType is {fmuType}, expected 0 or 1")),
        };
        // SAFETY: null or strings.
        unsafe { found(instanceName, (fmuGUID, "fmuGUID"), fmuResourceLocation) }.and_then(make)
    };
    let reporter = Reporter::new(&callbacks, name.unwrap_or(c""));
    made("fmi2Instantiate", reporter, None, make)
}

/// Creates an instance; null with a message for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: Boolean3,
    _loggingOn: Boolean3,
    eventModeUsed: Boolean3,
    earlyReturnAllowed: Boolean3,
    requiredIntermediateVariables: *const u32,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
    intermediateUpdate: Option<IntermediateUpdateCallback>,
) -> *mut Component {
    let make = || {
        let token = (instantiationToken, "instantiationToken");
        // SAFETY: null or strings.
        let settings = unsafe { found(instanceName, token, resourcePath)? };
        if eventModeUsed != 0 {
            return Err("there is no event mode".to_owned());
        }
        // SAFETY: a pointer from the host with its count.
        let required = unsafe {
            elements(
                requiredIntermediateVariables,
                nRequiredIntermediateVariables,
                "requiredIntermediateVariables",
            )
        };
        let required = required.map_err(|refusal| refusal.message)?;
        variables::only_outputs(&variables::of(&settings), required)?;
        Ok(Instance::new(settings))
    };
    let updates = intermediateUpdate.map(|callback| IntermediateUpdates {
        callback,
        environment: instanceEnvironment,
        can_return_early: earlyReturnAllowed != 0,
    });
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    made("fmi3InstantiateCoSimulation", reporter, updates, make)
}

/// Creates an instance of a continuous model, which the host integrates; null with a message for
/// the board and for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: Boolean3,
    _loggingOn: Boolean3,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
) -> *mut Component {
    let make = || {
        let token = (instantiationToken, "instantiationToken");
        // SAFETY: null or strings.
        unsafe { found(instanceName, token, resourcePath) }.and_then(Instance::for_exchange)
    };
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    made("fmi3InstantiateModelExchange", reporter, None, make)
}

/// Refused: there is no scheduled execution.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: Boolean3,
    _loggingOn: Boolean3,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
    _clockUpdate: *const c_void,
    _lockPreemption: *const c_void,
    _unlockPreemption: *const c_void,
) -> *mut Component {
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    let message = "fmi3InstantiateScheduledExecution: there is no scheduled execution";
    reporter.report(Status::Error, message);
    null_mut()
}

/// Frees an instance with everything it keeps. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(component: *mut Component) {
    // SAFETY: an instance from the host, which is not used again.
    unsafe { free(component) }
}

/// Frees an instance with everything it keeps. Null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(component: *mut Component) {
    // SAFETY: an instance from the host, which is not used again.
    unsafe { free(component) }
}
