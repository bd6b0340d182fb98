//! Functions of what the FMU does not have. All are refused with a reason.
//!
//! They take more arguments than are declared here, which they do not read: in the calling
//! conventions of C on x86-64 the caller passes and removes them.

use crate::abi::call::call;
use crate::abi::{Component, Status};

macro_rules! refused {
    ($($($function:ident),+: $reason:literal;)+) => {$($(
        /// Refused.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $function(instance: *mut Component) -> Status {
            // SAFETY: an instance from the host.
            unsafe { call(instance, stringify!($function), |_| Err($reason.into())) }
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
