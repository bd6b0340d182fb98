//! Instantiation, initialization, steps and termination.

use std::ffi::{CStr, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use super::call::{call, elements};
use super::exchange::MODEL_EXCHANGE;
use super::report::Reporter;
use super::types::{Boolean, CallbackFunctions, Component, Status};
use crate::description::ERROR_CATEGORY;
use crate::identity;
use crate::instance::Instance;

/// `fmi2CoSimulation` of `fmi2Type`.
pub const CO_SIMULATION: c_int = 1;

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

/// Creates an instance; null with a message for invalid arguments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: *const c_char,
    fmuType: c_int,
    fmuGUID: *const c_char,
    fmuResourceLocation: *const c_char,
    functions: *const CallbackFunctions,
    _visible: Boolean,
    _loggingOn: Boolean,
) -> *mut Component {
    if functions.is_null() || !functions.is_aligned() {
        return null_mut();
    }
    // SAFETY: neither null nor misaligned, and it points to the callbacks of the host.
    let callbacks = unsafe { *functions };
    // SAFETY: null or a string, here and below.
    let name = unsafe { text(instanceName) };
    let reporter = Reporter::new(&callbacks, name.unwrap_or(c""));
    let made = catch_unwind(AssertUnwindSafe(|| {
        let make = match fmuType {
            CO_SIMULATION => |settings| Ok(Instance::new(settings)),
            MODEL_EXCHANGE => Instance::for_exchange,
            _ => return Err(format!("fmuType is {fmuType}, expected 0 or 1")),
        };
        if name.is_none_or(CStr::is_empty) {
            return Err("instanceName is missing or empty".to_owned());
        }
        // SAFETY: as above.
        let (guid, resources) = unsafe { (text(fmuGUID), text(fmuResourceLocation)) };
        let guid = guid.ok_or("fmuGUID is null")?.to_string_lossy();
        let resources = resources.map(CStr::to_string_lossy);
        identity::find(&guid, resources.as_deref()).and_then(make)
    }));
    let why = match made {
        Ok(Ok(instance)) => {
            return Box::into_raw(Box::new(Component {
                instance,
                reporter,
                updates: None,
            }));
        }
        Ok(Err(why)) => why,
        Err(_) => "an internal error".to_owned(),
    };
    reporter.report(Status::Error, &format!("fmi2Instantiate: {why}"));
    null_mut()
}

/// The string that a pointer leads to; `None` for null.
///
/// # Safety
/// The pointer is null, or leads to a string that ends in a nul and lives for `'a`.
pub(crate) unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: not null; the rest as promised.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// Frees an instance with everything it keeps. Null is passed over.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: *mut Component) {
    if !c.is_null() {
        // SAFETY: it comes from `Box::into_raw` in `fmi2Instantiate`, and is not used again.
        drop(unsafe { Box::from_raw(c) });
    }
}

/// Refusals are always reported, and there is nothing else to switch on or off.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: *mut Component,
    _loggingOn: Boolean,
    nCategories: usize,
    categories: *const *const c_char,
) -> Status {
    let body = |_: &mut Instance| {
        // SAFETY: a pointer from the host with its count.
        for category in unsafe { elements(categories, nCategories, "categories")? } {
            // SAFETY: null or a string.
            let name = unsafe { text(*category) }.unwrap_or(c"");
            if name.to_bytes() != ERROR_CATEGORY.as_bytes() {
                let name = name.to_string_lossy();
                return Err(format!("category `{name}`, expected {ERROR_CATEGORY}").into());
            }
        }
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2SetDebugLogging", body) }
}

/// Says where time starts and ends; a tolerance means nothing here.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: *mut Component,
    _toleranceDefined: Boolean,
    _tolerance: f64,
    startTime: f64,
    stopTimeDefined: Boolean,
    stopTime: f64,
) -> Status {
    let stop_s = (stopTimeDefined != 0).then_some(stopTime);
    // SAFETY: a component from the host.
    unsafe {
        call(c, "fmi2SetupExperiment", |instance| {
            instance.set_up_experiment(startTime, stop_s)
        })
    }
}

/// Begins the initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: *mut Component) -> Status {
    // SAFETY: a component from the host.
    unsafe {
        call(
            c,
            "fmi2EnterInitializationMode",
            Instance::enter_initialization,
        )
    }
}

/// Ends the initialization.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: *mut Component) -> Status {
    // SAFETY: a component from the host.
    unsafe {
        call(
            c,
            "fmi2ExitInitializationMode",
            Instance::exit_initialization,
        )
    }
}

/// Ends the run.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: *mut Component) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2Terminate", Instance::terminate) }
}

/// Restores the state directly after the instantiation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: *mut Component) -> Status {
    let body = |instance: &mut Instance| {
        instance.reset();
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2Reset", body) }
}

/// Steps from one communication point to the next.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: *mut Component,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: Boolean,
) -> Status {
    let body =
        |instance: &mut Instance| instance.step(currentCommunicationPoint, communicationStepSize);
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2DoStep", body) }
}
