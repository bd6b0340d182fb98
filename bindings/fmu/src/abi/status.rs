//! Asynchronous steps are not supported: every step is complete when `fmi2DoStep` returns.

use std::ffi::{c_char, c_int};

use super::call::{Result, call, place};
use super::types::{Boolean, Component, Status};
use crate::instance::{Instance, Refusal};

/// `fmi2LastSuccessfulTime` of `fmi2StatusKind`.
pub const LAST_SUCCESSFUL_TIME: c_int = 2;
/// `fmi2Terminated` of `fmi2StatusKind`.
pub const TERMINATED: c_int = 3;

/// Cancels a step: refused, since no step is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: *mut Component) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2CancelStep", |_| Err("no step is pending".into())) }
}

/// The status of a pending step: refused, since no step is pending.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: *mut Component, s: c_int, _value: *mut Status) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetStatus", |_| unknown(s)) }
}

/// Returns the communication point that was reached.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: *mut Component, s: c_int, value: *mut f64) -> Status {
    let body = |instance: &mut Instance| {
        if s != LAST_SUCCESSFUL_TIME {
            return unknown(s);
        }
        // SAFETY: a pointer from the host.
        *unsafe { place(value, "value")? } = instance.now_s();
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetRealStatus", body) }
}

/// The integer status of a step: not available.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(
    c: *mut Component,
    s: c_int,
    _value: *mut c_int,
) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetIntegerStatus", |_| unknown(s)) }
}

/// Reports that the instance does not request the end of the simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: *mut Component,
    s: c_int,
    value: *mut Boolean,
) -> Status {
    let body = |_: &mut Instance| {
        if s != TERMINATED {
            return unknown(s);
        }
        // SAFETY: a pointer from the host.
        *unsafe { place(value, "value")? } = 0;
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetBooleanStatus", body) }
}

/// The string status of a step: not available.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: *mut Component,
    s: c_int,
    _value: *mut *const c_char,
) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetStringStatus", |_| unknown(s)) }
}

fn unknown(kind: c_int) -> Result<()> {
    Err(Refusal {
        is_discard: true,
        message: format!("status kind {kind} is not known of a step that is done"),
    })
}
