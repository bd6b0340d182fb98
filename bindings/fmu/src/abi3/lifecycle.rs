//! Instantiation, initialization, steps and termination.

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use super::Boolean;
use crate::abi::call::{call, place};
use crate::abi::lifecycle::text;
use crate::abi::report::Reporter;
use crate::abi::{Component, MessageLogger, Status, fmi2FreeInstance, fmi2SetDebugLogging};
use crate::identity;
use crate::instance::Instance;

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
    _earlyReturnAllowed: Boolean,
    _requiredIntermediateVariables: *const u32,
    nRequiredIntermediateVariables: usize,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
    _intermediateUpdate: *const c_void,
) -> *mut Component {
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    let made = catch_unwind(AssertUnwindSafe(|| {
        // SAFETY: null or strings.
        let (name, token, resources) = unsafe {
            (
                text(instanceName),
                text(instantiationToken),
                text(resourcePath),
            )
        };
        if name.is_none_or(CStr::is_empty) {
            return Err("instanceName is missing or empty".to_owned());
        }
        if eventModeUsed != 0 || nRequiredIntermediateVariables != 0 {
            return Err("there is no event mode and no intermediate update".to_owned());
        }
        let token = token.ok_or("instantiationToken is null")?.to_string_lossy();
        let resources = resources.map(CStr::to_string_lossy);
        identity::find(&token, resources.as_deref()).map(Instance::new)
    }));
    let why = match made {
        Ok(Ok(instance)) => {
            return Box::into_raw(Box::new(Component { instance, reporter }));
        }
        Ok(Err(why)) => why,
        Err(_) => "an internal error".to_owned(),
    };
    let message = format!("fmi3InstantiateCoSimulation: {why}");
    reporter.report(Status::Error, &message);
    null_mut()
}

/// Refused: the FMU is for co-simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _instanceName: *const c_char,
    _instantiationToken: *const c_char,
    _resourcePath: *const c_char,
    _visible: Boolean,
    _loggingOn: Boolean,
    instanceEnvironment: *mut c_void,
    logMessage: Option<MessageLogger>,
) -> *mut Component {
    let reporter = Reporter::of_messages(logMessage, instanceEnvironment);
    let message = "fmi3InstantiateModelExchange: the FMU is for co-simulation";
    reporter.report(Status::Error, message);
    null_mut()
}

/// Refused: the FMU is for co-simulation.
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
    let message = "fmi3InstantiateScheduledExecution: the FMU is for co-simulation";
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

/// Steps from one communication point to the next. There are no events and no early returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Component,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: Boolean,
    eventHandlingNeeded: *mut Boolean,
    terminateSimulation: *mut Boolean,
    earlyReturn: *mut Boolean,
    lastSuccessfulTime: *mut f64,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: pointers from the host.
        unsafe {
            *place(eventHandlingNeeded, "eventHandlingNeeded")? = 0;
            *place(terminateSimulation, "terminateSimulation")? = 0;
            *place(earlyReturn, "earlyReturn")? = 0;
            *place(lastSuccessfulTime, "lastSuccessfulTime")? = instance.now_s();
        }
        instance.step(currentCommunicationPoint, communicationStepSize)?;
        // SAFETY: as above.
        unsafe { *place(lastSuccessfulTime, "lastSuccessfulTime")? = instance.now_s() };
        Ok(())
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3DoStep", body) }
}
