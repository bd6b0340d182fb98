//! Steps, with the host's intermediate updates.
//!
//! A long step is computed in parts. After each but the last the host is told the time that has
//! been reached, and may end the step there: its progress and its interruption.

use std::ffi::c_void;

use super::Boolean;
use crate::abi::call::{call, place};
use crate::abi::{Component, Status};
use crate::instance::Instance;

/// Simulated time between two updates, s: a PC computes it in 4 ms at most.
pub const UPDATE_PERIOD_S: f64 = 0.1;

/// `fmi3IntermediateUpdateCallback`.
pub type IntermediateUpdateCallback = unsafe extern "C" fn(
    environment: *mut c_void,
    intermediate_update_time: f64,
    intermediate_variable_set_requested: Boolean,
    intermediate_variable_get_allowed: Boolean,
    intermediate_step_finished: Boolean,
    can_return_early: Boolean,
    early_return_requested: *mut Boolean,
    early_return_time: *mut f64,
);

/// Access to the host's intermediate updates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct IntermediateUpdates {
    /// The host's function.
    pub callback: IntermediateUpdateCallback,
    /// Its first argument.
    pub environment: *mut c_void,
    /// Whether the host accepts a step that ends early.
    pub can_return_early: bool,
}

impl IntermediateUpdates {
    /// Tells the host the time that has been reached; returns the end of the step, which the host
    /// may have moved to this time or a later one.
    ///
    /// # Safety
    /// No part of the component is borrowed: the host may read its outputs.
    unsafe fn tell(&self, now_s: f64, end_s: f64) -> f64 {
        let (mut is_requested, mut early_s) = (0, now_s);
        // SAFETY: the host's function with its own argument, and places for its answers.
        unsafe {
            (self.callback)(
                self.environment,
                now_s,
                0,
                1,
                1,
                self.can_return_early.into(),
                &mut is_requested,
                &mut early_s,
            );
        }
        if !self.can_return_early || is_requested == 0 {
            return end_s;
        }
        // A time that has passed, and NaN, count as the present time.
        if early_s > now_s {
            early_s.min(end_s)
        } else {
            now_s
        }
    }
}

/// Steps from one communication point to the next. There are no events. A step of more than
/// [`UPDATE_PERIOD_S`] calls the host's intermediate update, which may end it early.
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
            end_s = unsafe { updates.tell(now_s, end_s) };
        }
        if end_s <= now_s {
            // SAFETY: as above.
            unsafe { *earlyReturn = 1 };
            return Status::Ok;
        }
    }
}
