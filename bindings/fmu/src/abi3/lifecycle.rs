//! Instantiation, initialization, steps and termination.

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use super::Boolean;
use super::step::{IntermediateUpdateCallback, IntermediateUpdates};
use crate::abi::call::{call, elements};
use crate::abi::lifecycle::text;
use crate::abi::report::Reporter;
use crate::abi::{Component, MessageLogger, Status, fmi2FreeInstance, fmi2SetDebugLogging};
use crate::identity;
use crate::instance::Instance;
use crate::variables;
use model_core::actuator::Settings;

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Refusals are always reported, and there is nothing else to switch on or off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut Component,
    loggingOn: Boolean,
    nCategories: usize,
    categories: *const *const c_char,
) -> Status {
    // SAFETY: all from the host.
    unsafe { fmi2SetDebugLogging(instance, loggingOn.into(), nCategories, categories) }
}

/// Creates an instance; null with a message for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: Boolean,
    _loggingOn: Boolean,
    eventModeUsed: Boolean,
    earlyReturnAllowed: Boolean,
    requiredIntermediateVariables: *const u32,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
    intermediateUpdate: Option<IntermediateUpdateCallback>,
) -> *mut Component {
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    let make = || {
        // SAFETY: null or strings.
        let settings = unsafe { found(instanceName, instantiationToken, resourcePath)? };
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
    made("fmi3InstantiateCoSimulation", reporter, updates, make)
}

/// The settings of an instantiation token.
///
/// # Safety
/// The pointers are null or lead to strings.
unsafe fn found(
    name: *const c_char,
    token: *const c_char,
    resources: *const c_char,
) -> Result<Settings, String> {
    // SAFETY: by the contract.
    let (name, token, resources) = unsafe { (text(name), text(token), text(resources)) };
    if name.is_none_or(CStr::is_empty) {
        return Err("instanceName is missing or empty".to_owned());
    }
    let token = token.ok_or("instantiationToken is null")?.to_string_lossy();
    let resources = resources.map(CStr::to_string_lossy);
    identity::find(&token, resources.as_deref())
}

/// The component of an instance; null with a message if there is none.
fn made(
    function: &str,
    reporter: Reporter,
    updates: Option<IntermediateUpdates>,
    make: impl FnOnce() -> Result<Instance, String>,
) -> *mut Component {
    let why = match catch_unwind(AssertUnwindSafe(make)) {
        Ok(Ok(instance)) => {
            return Box::into_raw(Box::new(Component {
                instance,
                reporter,
                updates,
            }));
        }
        Ok(Err(why)) => why,
        Err(_) => "an internal error".to_owned(),
    };
    reporter.report(Status::Error, &format!("{function}: {why}"));
    null_mut()
}

/// Creates an instance of a continuous model, which the host integrates; null with a message for
/// the board and for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    instanceName: *const c_char,
    instantiationToken: *const c_char,
    resourcePath: *const c_char,
    _visible: Boolean,
    _loggingOn: Boolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
) -> *mut Component {
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    let make = || {
        // SAFETY: null or strings.
        let settings = unsafe { found(instanceName, instantiationToken, resourcePath)? };
        Instance::for_exchange(settings)
    };
    made("fmi3InstantiateModelExchange", reporter, None, make)
}

/// Refused: there is no scheduled execution.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: Boolean,
    _loggingOn: Boolean,
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

/// Frees an instance with everything it keeps. Null is passed over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut Component) {
    // SAFETY: an instance from the host, which is not used again.
    unsafe { fmi2FreeInstance(instance) }
}

/// Says where time starts and ends, and begins the initialization. A tolerance means nothing here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut Component,
    _toleranceDefined: Boolean,
    _tolerance: f64,
    startTime: f64,
    stopTimeDefined: Boolean,
    stopTime: f64,
) -> Status {
    let stop_s = (stopTimeDefined != 0).then_some(stopTime);
    let body = |instance: &mut Instance| {
        instance.set_up_experiment(startTime, stop_s)?;
        instance.enter_initialization()
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3EnterInitializationMode", body) }
}

/// Ends the initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut Component) -> Status {
    let body = Instance::exit_initialization;
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3ExitInitializationMode", body) }
}

/// Ends the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut Component) -> Status {
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3Terminate", Instance::terminate) }
}

/// Restores the state directly after the instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut Component) -> Status {
    let body = |instance: &mut Instance| {
        instance.reset();
        Ok(())
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3Reset", body) }
}
