//! Functions of what the FMU does not have.

use std::ffi::{c_char, c_int};

use super::call::{Result, call, place};
use super::component::Component;
use super::types::{Boolean2, LAST_SUCCESSFUL_TIME, Status, TERMINATED, ValueReference};
use crate::instance::Refusal;

interface! {
    "Reads strings: the FMU has no string variables."
    [fmi2GetString] (_vr: *const ValueReference, nvr: usize, _value: *mut *const c_char)
    |_| none("a string", nvr);

    "Writes strings: the FMU has no string variables."
    [fmi2SetString] (_vr: *const ValueReference, nvr: usize, _value: *const *const c_char)
    |_| none("a string", nvr);

    "Sets derivatives of inputs: not supported, since inputs are held."
    [fmi2SetRealInputDerivatives] (
        _vr: *const ValueReference, nvr: usize, _order: *const c_int, _value: *const f64
    ) |_| none("interpolated", nvr);

    "Reads derivatives of outputs: not supported."
    [fmi2GetRealOutputDerivatives] (
        _vr: *const ValueReference, nvr: usize, _order: *const c_int, _value: *mut f64
    ) |_| none("with derivatives", nvr);

    "Reads directional derivatives: not supported."
    [fmi2GetDirectionalDerivative] (
        _vUnknown_ref: *const ValueReference, nUnknown: usize,
        _vKnown_ref: *const ValueReference, _nKnown: usize,
        _dvKnown: *const f64, _dvUnknown: *mut f64
    ) |_| none("with derivatives", nUnknown);

    "Cancels a step: refused, since every step is complete when `fmi2DoStep` returns."
    [fmi2CancelStep] () |_| Err("no step is pending".into());

    "The status of a pending step: refused, since no step is pending."
    [fmi2GetStatus] (s: c_int, _value: *mut Status) |_| unknown(s);

    "Returns the communication point that was reached."
    [fmi2GetRealStatus] (s: c_int, value: *mut f64) |instance| {
        if s != LAST_SUCCESSFUL_TIME {
            return unknown(s);
        }
        *place(value, "value")? = instance.now_s();
        Ok(())
    };

    "The integer status of a step: not available."
    [fmi2GetIntegerStatus] (s: c_int, _value: *mut c_int) |_| unknown(s);

    "Reports that the instance does not request the end of the simulation."
    [fmi2GetBooleanStatus] (s: c_int, value: *mut Boolean2) |_| {
        if s != TERMINATED {
            return unknown(s);
        }
        *place(value, "value")? = 0;
        Ok(())
    };

    "The string status of a step: not available."
    [fmi2GetStringStatus] (s: c_int, _value: *mut *const c_char) |_| unknown(s);
}

fn unknown(kind: c_int) -> Result<()> {
    Err(Refusal {
        is_discard: true,
        message: format!("status kind {kind} is not known of a step that is done"),
    })
}

/// Refuses any number of variables except zero.
fn none(what: &str, count: usize) -> Result<()> {
    match count {
        0 => Ok(()),
        _ => Err(format!("no variable is {what}").into()),
    }
}

/// Functions of FMI 3.0 that take more arguments than are declared here, which they do not read: in
/// the calling conventions of C on x86-64 the caller passes and removes them.
macro_rules! refused {
    ($($($function:ident),+: $reason:literal;)+) => {$($(
        /// Refused.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(component: *mut Component) -> Status {
            // SAFETY: an instance from the host.
            unsafe { call(component, stringify!($function), |_| Err($reason.into())) }
        }
    )+)+};
}

refused! {
    fmi3GetFloat32, fmi3SetFloat32: "no variable is of this type";
    fmi3GetInt8, fmi3SetInt8: "no variable is of this type";
    fmi3GetUInt8, fmi3SetUInt8: "no variable is of this type";
    fmi3GetInt16, fmi3SetInt16: "no variable is of this type";
    fmi3GetUInt16, fmi3SetUInt16: "no variable is of this type";
    fmi3GetUInt32, fmi3SetUInt32: "no variable is of this type";
    fmi3GetInt64, fmi3SetInt64: "no variable is of this type";
    fmi3GetUInt64, fmi3SetUInt64: "no variable is of this type";
    fmi3GetString, fmi3SetString: "no variable is of this type";
    fmi3GetBinary, fmi3SetBinary: "no variable is of this type";
    fmi3GetClock, fmi3SetClock: "no variable is of this type";
    fmi3GetNumberOfVariableDependencies, fmi3GetVariableDependencies:
        "the dependencies do not change: the model description has them";
    fmi3GetDirectionalDerivative, fmi3GetAdjointDerivative, fmi3GetOutputDerivatives:
        "there are no derivatives";
    fmi3EnterConfigurationMode, fmi3ExitConfigurationMode: "there is no structural parameter";
    fmi3GetIntervalDecimal, fmi3GetIntervalFraction, fmi3GetShiftDecimal, fmi3GetShiftFraction,
    fmi3SetIntervalDecimal, fmi3SetIntervalFraction, fmi3SetShiftDecimal, fmi3SetShiftFraction,
    fmi3ActivateModelPartition: "there is no clock";
    fmi3EnterStepMode: "there is no event mode in co-simulation";
    fmi3EvaluateDiscreteStates: "there are no discrete states to evaluate";
}
