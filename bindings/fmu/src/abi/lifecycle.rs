//! Initialization, termination and reset.

use std::ffi::c_char;

use super::call::{Result, elements};
use super::component::text;
use super::types::{Boolean2, Boolean3};
use crate::description::ERROR_CATEGORY;
use crate::instance::Instance;

interface! {
    "Refusals are always reported, and there is nothing else to switch on or off."
    [fmi2SetDebugLogging] (
        _loggingOn: Boolean2, nCategories: usize, categories: *const *const c_char
    ) |_| check_categories(categories, nCategories);

    "Refusals are always reported, and there is nothing else to switch on or off."
    [fmi3SetDebugLogging] (
        _loggingOn: Boolean3, nCategories: usize, categories: *const *const c_char
    ) |_| check_categories(categories, nCategories);

    "Sets the start and end of time; a tolerance has no effect."
    [fmi2SetupExperiment] (
        _toleranceDefined: Boolean2, _tolerance: f64, startTime: f64, stopTimeDefined: Boolean2,
        stopTime: f64
    ) |instance| instance.set_up_experiment(startTime, (stopTimeDefined != 0).then_some(stopTime));

    "Begins the initialization."
    [fmi2EnterInitializationMode] () Instance::enter_initialization;

    "Sets the start and end of time, and begins the initialization; a tolerance has no effect."
    [fmi3EnterInitializationMode] (
        _toleranceDefined: Boolean3, _tolerance: f64, startTime: f64, stopTimeDefined: Boolean3,
        stopTime: f64
    ) |instance| {
        instance.set_up_experiment(startTime, (stopTimeDefined != 0).then_some(stopTime))?;
        instance.enter_initialization()
    };

    "Ends the initialization."
    [fmi2ExitInitializationMode, fmi3ExitInitializationMode] () Instance::exit_initialization;

    "Ends the run."
    [fmi2Terminate, fmi3Terminate] () Instance::terminate;

    "Restores the state directly after the instantiation."
    [fmi2Reset, fmi3Reset] () |instance| {
        instance.reset();
        Ok(())
    };
}

/// Refuses categories of messages that the FMU does not have.
///
/// # Safety
/// That of the [module](super).
unsafe fn check_categories(categories: *const *const c_char, count: usize) -> Result<()> {
    // SAFETY: a pointer from the host with its count.
    for category in unsafe { elements(categories, count, "categories")? } {
        // SAFETY: null or a string.
        let name = unsafe { text(*category) }.unwrap_or(c"");
        if name.to_bytes() != ERROR_CATEGORY.as_bytes() {
            let name = name.to_string_lossy();
            return Err(format!("category `{name}`, expected {ERROR_CATEGORY}").into());
        }
    }
    Ok(())
}
