//! Model exchange.

use super::call::{Result, elements, elements_mut, place};
use super::types::{Boolean2, Boolean3, EventInfo};
use crate::exchange::Update;
use crate::instance::{Instance, exchange::Evaluation};

interface! {
    "Begins an event."
    [fmi2EnterEventMode, fmi3EnterEventMode] () Instance::enter_event_mode;

    "Processes an event."
    [fmi2NewDiscreteStates] (fmi2eventInfo: *mut EventInfo) |instance| {
        let info = place(fmi2eventInfo, "fmi2eventInfo")?;
        let Update { changed_states, next_event_s } = instance.update_discrete_states()?;
        *info = EventInfo {
            values_of_continuous_states_changed: changed_states.into(),
            next_event_time_defined: next_event_s.is_some().into(),
            next_event_time: next_event_s.unwrap_or_default(),
            ..EventInfo::default()
        };
        Ok(())
    };

    "Processes an event. The iteration ends at once, the nominal values do not change, and the \
     instance does not end the simulation."
    [fmi3UpdateDiscreteStates] (
        discreteStatesNeedUpdate: *mut Boolean3,
        terminateSimulation: *mut Boolean3,
        nominalsOfContinuousStatesChanged: *mut Boolean3,
        valuesOfContinuousStatesChanged: *mut Boolean3,
        nextEventTimeDefined: *mut Boolean3,
        nextEventTime: *mut f64
    ) |instance| {
        *place(discreteStatesNeedUpdate, "discreteStatesNeedUpdate")? = 0;
        *place(terminateSimulation, "terminateSimulation")? = 0;
        *place(nominalsOfContinuousStatesChanged, "nominalsOfContinuousStatesChanged")? = 0;
        let changed = place(valuesOfContinuousStatesChanged, "valuesOfContinuousStatesChanged")?;
        let is_defined = place(nextEventTimeDefined, "nextEventTimeDefined")?;
        let next_s = place(nextEventTime, "nextEventTime")?;
        let Update { changed_states, next_event_s } = instance.update_discrete_states()?;
        *changed = changed_states.into();
        *is_defined = next_event_s.is_some().into();
        *next_s = next_event_s.unwrap_or_default();
        Ok(())
    };

    "Begins or continues the integration."
    [fmi2EnterContinuousTimeMode, fmi3EnterContinuousTimeMode] ()
    Instance::enter_continuous_time_mode;

    "Accepts a step of the solver. It needs no event and no end of the simulation."
    [fmi2CompletedIntegratorStep] (
        _noSetFMUStatePriorToCurrentPoint: Boolean2, enterEventMode: *mut Boolean2,
        terminateSimulation: *mut Boolean2
    ) |instance| complete_step(instance, enterEventMode, terminateSimulation);

    "Accepts a step of the solver. It needs no event and no end of the simulation."
    [fmi3CompletedIntegratorStep] (
        _noSetFMUStatePriorToCurrentPoint: Boolean3, enterEventMode: *mut Boolean3,
        terminateSimulation: *mut Boolean3
    ) |instance| complete_step(instance, enterEventMode, terminateSimulation);

    "Sets the time."
    [fmi2SetTime, fmi3SetTime] (time: f64) |instance| instance.set_time(time);

    "Sets the continuous states."
    [fmi2SetContinuousStates, fmi3SetContinuousStates] (states: *const f64, count: usize)
    |instance| instance.set_states(elements(states, count, "the states")?);

    "Reads the derivatives of the states."
    [fmi2GetDerivatives, fmi3GetContinuousStateDerivatives] (values: *mut f64, count: usize)
    |instance| evaluate(instance, (values, count), |e| e.derivatives);

    "Reads the event indicators."
    [fmi2GetEventIndicators, fmi3GetEventIndicators] (values: *mut f64, count: usize)
    |instance| evaluate(instance, (values, count), |e| e.indicators);

    "Reads the continuous states."
    [fmi2GetContinuousStates, fmi3GetContinuousStates] (values: *mut f64, count: usize)
    |instance| evaluate(instance, (values, count), |e| e.states);

    "Reads the nominal values of the states: one degree and the like."
    [fmi2GetNominalsOfContinuousStates, fmi3GetNominalsOfContinuousStates] (
        values: *mut f64, count: usize
    ) |instance| evaluate(instance, (values, count), |e| vec![1.0; e.states.len()]);

    "Number of event indicators."
    [fmi3GetNumberOfEventIndicators] (nEventIndicators: *mut usize) |instance| {
        *place(nEventIndicators, "nEventIndicators")? = instance.dimensions().1;
        Ok(())
    };

    "Number of continuous states."
    [fmi3GetNumberOfContinuousStates] (nContinuousStates: *mut usize) |instance| {
        *place(nContinuousStates, "nContinuousStates")? = instance.dimensions().0;
        Ok(())
    };
}

/// Accepts a step of the solver; the answers are "false", the default of each version's type.
///
/// # Safety
/// That of the [module](super).
unsafe fn complete_step<B: Default>(
    instance: &mut Instance,
    enter_event_mode: *mut B,
    terminate_simulation: *mut B,
) -> Result<()> {
    // SAFETY: pointers from the host.
    unsafe {
        *place(enter_event_mode, "enterEventMode")? = B::default();
        *place(terminate_simulation, "terminateSimulation")? = B::default();
    }
    instance.complete_step()
}

/// Writes a part of the evaluated equations to the host's memory.
///
/// # Safety
/// That of the [module](super).
unsafe fn evaluate(
    instance: &Instance,
    (values, count): (*mut f64, usize),
    of: impl FnOnce(Evaluation) -> Vec<f64>,
) -> Result<()> {
    let found = of(instance.evaluated()?);
    if found.len() != count {
        let expected = found.len();
        return Err(format!("the number of values is {count}, expected {expected}").into());
    }
    // SAFETY: a pointer from the host with its count.
    unsafe { elements_mut(values, count, "the values")? }.copy_from_slice(&found);
    Ok(())
}
