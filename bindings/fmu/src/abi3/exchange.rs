//! Model exchange.

use super::Boolean;
use crate::abi::call::{call, place};
use crate::abi::exchange::{complete_step, evaluate, nominals, set_states};
use crate::abi::{Component, Status};
use crate::instance::Instance;

/// Begins an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterEventMode(instance: *mut Component) -> Status {
    // SAFETY: an instance from the host, here and below.
    unsafe { call(instance, "fmi3EnterEventMode", Instance::enter_event_mode) }
}

/// Processes an event. The iteration ends at once, the nominal values do not change, and the
/// instance does not end the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3UpdateDiscreteStates(
    instance: *mut Component,
    discreteStatesNeedUpdate: *mut Boolean,
    terminateSimulation: *mut Boolean,
    nominalsOfContinuousStatesChanged: *mut Boolean,
    valuesOfContinuousStatesChanged: *mut Boolean,
    nextEventTimeDefined: *mut Boolean,
    nextEventTime: *mut f64,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: pointers from the host.
        let (values_changed, is_defined, next_s) = unsafe {
            *place(discreteStatesNeedUpdate, "discreteStatesNeedUpdate")? = 0;
            *place(terminateSimulation, "terminateSimulation")? = 0;
            *place(
                nominalsOfContinuousStatesChanged,
                "nominalsOfContinuousStatesChanged",
            )? = 0;
            (
                place(
                    valuesOfContinuousStatesChanged,
                    "valuesOfContinuousStatesChanged",
                )?,
                place(nextEventTimeDefined, "nextEventTimeDefined")?,
                place(nextEventTime, "nextEventTime")?,
            )
        };
        let update = instance.update_discrete_states()?;
        *values_changed = update.changed_states.into();
        *is_defined = update.next_event_s.is_some().into();
        *next_s = update.next_event_s.unwrap_or_default();
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(instance, "fmi3UpdateDiscreteStates", body) }
}

/// Begins or continues the integration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterContinuousTimeMode(instance: *mut Component) -> Status {
    let body = Instance::enter_continuous_time_mode;
    // SAFETY: as above.
    unsafe { call(instance, "fmi3EnterContinuousTimeMode", body) }
}

/// Accepts a step of the solver. It needs no event and no end of the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3CompletedIntegratorStep(
    instance: *mut Component,
    _noSetFMUStatePriorToCurrentPoint: Boolean,
    enterEventMode: *mut Boolean,
    terminateSimulation: *mut Boolean,
) -> Status {
    let function = "fmi3CompletedIntegratorStep";
    // SAFETY: as above.
    unsafe { complete_step(instance, function, enterEventMode, terminateSimulation) }
}

/// Sets the time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetTime(instance: *mut Component, time: f64) -> Status {
    // SAFETY: as above.
    unsafe { call(instance, "fmi3SetTime", |instance| instance.set_time(time)) }
}

/// Sets the continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetContinuousStates(
    instance: *mut Component,
    continuousStates: *const f64,
    nContinuousStates: usize,
) -> Status {
    let function = "fmi3SetContinuousStates";
    // SAFETY: as above.
    unsafe { set_states(instance, function, continuousStates, nContinuousStates) }
}

macro_rules! evaluated {
    ($($(#[$about:meta])* $function:ident: $of:expr;)+) => {$(
        $(#[$about])*
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(
            instance: *mut Component,
            values: *mut f64,
            count: usize,
        ) -> Status {
            // SAFETY: as above.
            unsafe { evaluate(instance, stringify!($function), values, count, $of) }
        }
    )+};
}

evaluated! {
    /// Reads the derivatives of the states.
    fmi3GetContinuousStateDerivatives: |e| e.derivatives;
    /// Reads the event indicators.
    fmi3GetEventIndicators: |e| e.indicators;
    /// Reads the continuous states.
    fmi3GetContinuousStates: |e| e.states;
    /// Reads the nominal values of the states.
    fmi3GetNominalsOfContinuousStates: nominals;
}

/// Number of event indicators.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfEventIndicators(
    instance: *mut Component,
    nEventIndicators: *mut usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        *unsafe { place(nEventIndicators, "nEventIndicators")? } = instance.dimensions().1;
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(instance, "fmi3GetNumberOfEventIndicators", body) }
}

/// Number of continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetNumberOfContinuousStates(
    instance: *mut Component,
    nContinuousStates: *mut usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        *unsafe { place(nContinuousStates, "nContinuousStates")? } = instance.dimensions().0;
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(instance, "fmi3GetNumberOfContinuousStates", body) }
}
