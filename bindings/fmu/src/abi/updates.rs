//! Intermediate updates of a host of FMI 3.0.

use std::ffi::c_void;

use super::types::Boolean3;

/// Simulated time between two updates, s: a PC computes it in 4 ms at most.
pub const UPDATE_PERIOD_S: f64 = 0.1;

/// `fmi3IntermediateUpdateCallback`.
pub type IntermediateUpdateCallback = unsafe extern "C" fn(
    environment: *mut c_void,
    intermediate_update_time: f64,
    intermediate_variable_set_requested: Boolean3,
    intermediate_variable_get_allowed: Boolean3,
    intermediate_step_finished: Boolean3,
    can_return_early: Boolean3,
    early_return_requested: *mut Boolean3,
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
    /// Reports the time that has been reached; returns the end of the step, which the host may have
    /// moved to this time or a later one.
    ///
    /// # Safety
    /// No part of the component is borrowed: the host may read its outputs.
    pub(crate) unsafe fn report(&self, now_s: f64, end_s: f64) -> f64 {
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
