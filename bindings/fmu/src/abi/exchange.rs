//! Model exchange.

use std::ffi::c_int;

use super::call::{call, elements, elements_mut, place};
use super::types::{Boolean, Component, Status};
use crate::exchange::Update;
use crate::instance::{Instance, Result, exchange::Evaluation};

/// `fmi2EventInfo`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[repr(C)]
pub struct EventInfo {
    /// Whether the event iteration goes on; it does not.
    pub new_discrete_states_needed: Boolean,
    /// Whether the instance ends the simulation; it does not.
    pub terminate_simulation: Boolean,
    /// Whether the nominal values have changed; they do not.
    pub nominals_of_continuous_states_changed: Boolean,
    /// Whether the event has changed the continuous states.
    pub values_of_continuous_states_changed: Boolean,
    /// Whether the time of the next event is known.
    pub next_event_time_defined: Boolean,
    /// That time.
    pub next_event_time: f64,
}

/// Begins an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: *mut Component) -> Status {
    // SAFETY: a component from the host, here and below.
    unsafe { call(c, "fmi2EnterEventMode", Instance::enter_event_mode) }
}

/// Processes an event.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(
    c: *mut Component,
    fmi2eventInfo: *mut EventInfo,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        let info = unsafe { place(fmi2eventInfo, "fmi2eventInfo")? };
        let Update {
            changed_states,
            next_event_s,
        } = instance.update_discrete_states()?;
        *info = EventInfo {
            values_of_continuous_states_changed: changed_states.into(),
            next_event_time_defined: next_event_s.is_some().into(),
            next_event_time: next_event_s.unwrap_or_default(),
            ..EventInfo::default()
        };
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, "fmi2NewDiscreteStates", body) }
}

/// Begins or continues the integration.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: *mut Component) -> Status {
    let body = Instance::enter_continuous_time_mode;
    // SAFETY: as above.
    unsafe { call(c, "fmi2EnterContinuousTimeMode", body) }
}

/// Accepts a step of the solver. It needs no event and no end of the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: *mut Component,
    _noSetFMUStatePriorToCurrentPoint: Boolean,
    enterEventMode: *mut Boolean,
    terminateSimulation: *mut Boolean,
) -> Status {
    let function = "fmi2CompletedIntegratorStep";
    // SAFETY: as above.
    unsafe { complete_step(c, function, enterEventMode, terminateSimulation) }
}

/// Sets the time.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: *mut Component, time: f64) -> Status {
    // SAFETY: as above.
    unsafe { call(c, "fmi2SetTime", |instance| instance.set_time(time)) }
}

/// Sets the continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(
    c: *mut Component,
    x: *const f64,
    nx: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { set_states(c, "fmi2SetContinuousStates", x, nx) }
}

/// Reads the derivatives of the states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(
    c: *mut Component,
    derivatives: *mut f64,
    nx: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { evaluate(c, "fmi2GetDerivatives", derivatives, nx, |e| e.derivatives) }
}

/// Reads the event indicators.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: *mut Component,
    eventIndicators: *mut f64,
    ni: usize,
) -> Status {
    let function = "fmi2GetEventIndicators";
    // SAFETY: as above.
    unsafe { evaluate(c, function, eventIndicators, ni, |e| e.indicators) }
}

/// Reads the continuous states.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(
    c: *mut Component,
    x: *mut f64,
    nx: usize,
) -> Status {
    // SAFETY: as above.
    unsafe { evaluate(c, "fmi2GetContinuousStates", x, nx, |e| e.states) }
}

/// Reads the nominal values of the states: one degree and the like.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: *mut Component,
    x_nominal: *mut f64,
    nx: usize,
) -> Status {
    let function = "fmi2GetNominalsOfContinuousStates";
    // SAFETY: as above.
    unsafe { evaluate(c, function, x_nominal, nx, nominals) }
}

/// Accepts a step of the solver; the answers are "false", the default of each version's type.
///
/// # Safety
/// That of the [module](super).
pub(crate) unsafe fn complete_step<B: Default>(
    c: *mut Component,
    function: &str,
    enter_event_mode: *mut B,
    terminate_simulation: *mut B,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: pointers from the host.
        unsafe {
            *place(enter_event_mode, "enterEventMode")? = B::default();
            *place(terminate_simulation, "terminateSimulation")? = B::default();
        }
        instance.complete_step()
    };
    // SAFETY: as above.
    unsafe { call(c, function, body) }
}

/// The nominal values of the states.
pub(crate) fn nominals(evaluation: Evaluation) -> Vec<f64> {
    vec![1.0; evaluation.states.len()]
}

/// Sets the continuous states.
///
/// # Safety
/// That of the [module](super).
pub(crate) unsafe fn set_states(
    c: *mut Component,
    function: &str,
    states: *const f64,
    count: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host with its count.
        instance.set_states(unsafe { elements(states, count, "the states")? })
    };
    // SAFETY: as above.
    unsafe { call(c, function, body) }
}

/// Writes a part of the evaluated equations to the host's memory.
///
/// # Safety
/// That of the [module](super).
pub(crate) unsafe fn evaluate(
    c: *mut Component,
    function: &str,
    values: *mut f64,
    count: usize,
    of: impl FnOnce(Evaluation) -> Vec<f64>,
) -> Status {
    let body = |instance: &mut Instance| -> Result<()> {
        let found = of(instance.evaluated()?);
        if found.len() != count {
            let expected = found.len();
            return Err(format!("the number of values is {count}, expected {expected}").into());
        }
        // SAFETY: a pointer from the host with its count.
        unsafe { elements_mut(values, count, "the values")? }.copy_from_slice(&found);
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, function, body) }
}

/// `fmi2ModelExchange` of `fmi2Type`.
pub const MODEL_EXCHANGE: c_int = 0;
