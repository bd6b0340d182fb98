//! Steps, with the host's intermediate updates.
//!
//! A long step is computed in parts. After each but the last the time that has been reached is
//! reported to the host, which may end the step there: its progress and its interruption.

use super::call::{call, place};
use super::component::Component;
use super::types::{Boolean2, Boolean3, Status};
use super::updates::UPDATE_PERIOD_S;
use crate::instance::Instance;

interface! {
    "Steps from one communication point to the next."
    [fmi2DoStep] (
        currentCommunicationPoint: f64, communicationStepSize: f64,
        _noSetFMUStatePriorToCurrentPoint: Boolean2
    ) |instance| instance.step(currentCommunicationPoint, communicationStepSize);
}

/// Steps from one communication point to the next. There are no events. A step of more than
/// [`UPDATE_PERIOD_S`] calls the host's intermediate update, which may end it early.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Component,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: Boolean3,
    eventHandlingNeeded: *mut Boolean3,
    terminateSimulation: *mut Boolean3,
    earlyReturn: *mut Boolean3,
    lastSuccessfulTime: *mut f64,
) -> Status {
    let function = "fmi3DoStep";
    let (mut now_s, mut whole_s) = (0.0, 0.0);
    let begin = |instance: &mut Instance| {
        now_s = instance.now_s();
        // SAFETY: pointers from the host.
        unsafe {
            *place(eventHandlingNeeded, "eventHandlingNeeded")? = 0;
            *place(terminateSimulation, "terminateSimulation")? = 0;
            *place(earlyReturn, "earlyReturn")? = 0;
            *place(lastSuccessfulTime, "lastSuccessfulTime")? = now_s;
        }
        whole_s = instance.end_of_step(currentCommunicationPoint, communicationStepSize)?;
        Ok(())
    };
    // SAFETY: an instance from the host, here and below.
    let status = unsafe { call(instance, function, begin) };
    // SAFETY: as above; null was refused.
    let updates = match unsafe { instance.as_ref() } {
        Some(component) if status == Status::Ok => component.updates,
        _ => return status,
    };
    let mut end_s = whole_s;
    loop {
        let part_s = match updates {
            Some(_) => (now_s + UPDATE_PERIOD_S).min(end_s),
            None => end_s,
        };
        let advance = |instance: &mut Instance| {
            instance.step_to(part_s)?;
            // SAFETY: pointers from the host, which were checked.
            unsafe {
                *place(lastSuccessfulTime, "lastSuccessfulTime")? = part_s;
                *place(earlyReturn, "earlyReturn")? = (part_s < whole_s && part_s >= end_s).into();
            }
            Ok(())
        };
        // SAFETY: as above. The instance is borrowed for this part only, and not during the update.
        let status = unsafe { call(instance, function, advance) };
        if status != Status::Ok || part_s >= end_s {
            return status;
        }
        now_s = part_s;
        if let Some(updates) = updates {
            // SAFETY: the component is not borrowed.
            end_s = unsafe { updates.report(now_s, end_s) };
        }
        if end_s <= now_s {
            // SAFETY: as above.
            unsafe { *earlyReturn = 1 };
            return Status::Ok;
        }
    }
}
