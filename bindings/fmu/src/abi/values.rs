//! Reading and writing of variables.

use std::ffi::{c_char, c_int};

use super::call::{Result, call, elements, elements_mut};
use super::types::{Boolean, Component, Status, ValueReference};
use crate::instance::{Instance, values::Value};
use crate::variables::Type;

/// Reads `nvr` variables of a type as `T`.
///
/// # Safety
/// That of the [module](super).
unsafe fn get<T>(
    instance: &Instance,
    of_type: Type,
    (vr, nvr): (*const ValueReference, usize),
    value: *mut T,
    convert: impl Fn(Value) -> Option<T>,
) -> Result<()> {
    // SAFETY: pointers from the host with their count.
    let (references, places) =
        unsafe { (elements(vr, nvr, "vr")?, elements_mut(value, nvr, "value")?) };
    instance.read(of_type, references, |index, value| {
        if let (Some(place), Some(value)) = (places.get_mut(index), convert(value)) {
            *place = value;
        }
    })
}

/// Writes `nvr` variables from `T`.
///
/// # Safety
/// That of the [module](super).
unsafe fn set<T: Copy>(
    instance: &mut Instance,
    (vr, nvr): (*const ValueReference, usize),
    value: *const T,
    convert: impl Fn(T) -> Value,
) -> Result<()> {
    // SAFETY: pointers from the host with their count.
    let (references, values) =
        unsafe { (elements(vr, nvr, "vr")?, elements(value, nvr, "value")?) };
    let values = values.iter().map(|value| convert(*value));
    instance.write(references.iter().copied().zip(values))
}

/// Reads real numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *mut f64,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2GetReal", |instance| {
            get(
                instance,
                Type::Real,
                (vr, nvr),
                value,
                |value| match value {
                    Value::Real(real) => Some(real),
                    _ => None,
                },
            )
        })
    }
}

/// Reads integers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *mut c_int,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2GetInteger", |instance| {
            get(
                instance,
                Type::Integer,
                (vr, nvr),
                value,
                |value| match value {
                    Value::Integer(integer) => Some(integer),
                    _ => None,
                },
            )
        })
    }
}

/// Reads booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *mut Boolean,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2GetBoolean", |instance| {
            get(
                instance,
                Type::Boolean,
                (vr, nvr),
                value,
                |value| match value {
                    Value::Boolean(boolean) => Some(boolean.into()),
                    _ => None,
                },
            )
        })
    }
}

/// Reads strings: the FMU has no string variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: *mut Component,
    _vr: *const ValueReference,
    nvr: usize,
    _value: *mut *const c_char,
) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetString", |_| none("a string", nvr)) }
}

/// Writes real numbers: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *const f64,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2SetReal", |instance| {
            set(instance, (vr, nvr), value, Value::Real)
        })
    }
}

/// Writes integers: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *const c_int,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2SetInteger", |instance| {
            set(instance, (vr, nvr), value, Value::Integer)
        })
    }
}

/// Writes booleans: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: *mut Component,
    vr: *const ValueReference,
    nvr: usize,
    value: *const Boolean,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        call(c, "fmi2SetBoolean", |instance| {
            set(instance, (vr, nvr), value, |value| {
                Value::Boolean(value != 0)
            })
        })
    }
}

/// Writes strings: the FMU has no string variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: *mut Component,
    _vr: *const ValueReference,
    nvr: usize,
    _value: *const *const c_char,
) -> Status {
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2SetString", |_| none("a string", nvr)) }
}

/// Sets derivatives of inputs: not supported, since inputs are held.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: *mut Component,
    _vr: *const ValueReference,
    nvr: usize,
    _order: *const c_int,
    _value: *const f64,
) -> Status {
    // SAFETY: a component from the host.
    unsafe {
        call(c, "fmi2SetRealInputDerivatives", |_| {
            none("interpolated", nvr)
        })
    }
}

/// Reads derivatives of outputs: not supported.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: *mut Component,
    _vr: *const ValueReference,
    nvr: usize,
    _order: *const c_int,
    _value: *mut f64,
) -> Status {
    // SAFETY: a component from the host.
    unsafe {
        call(c, "fmi2GetRealOutputDerivatives", |_| {
            none("with derivatives", nvr)
        })
    }
}

/// Reads directional derivatives: not supported.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: *mut Component,
    _vUnknown_ref: *const ValueReference,
    nUnknown: usize,
    _vKnown_ref: *const ValueReference,
    _nKnown: usize,
    _dvKnown: *const f64,
    _dvUnknown: *mut f64,
) -> Status {
    // SAFETY: a component from the host.
    unsafe {
        call(c, "fmi2GetDirectionalDerivative", |_| {
            none("with derivatives", nUnknown)
        })
    }
}

/// Refuses any number of variables except zero.
fn none(what: &str, count: usize) -> Result<()> {
    match count {
        0 => Ok(()),
        _ => Err(format!("no variable is {what}").into()),
    }
}
