//! Reading and writing of variables.

use std::ffi::c_int;

use super::call::{Result, elements, elements_mut};
use super::types::{Boolean2, Boolean3, ValueReference};
use crate::instance::{Instance, values::Value};
use crate::variables::Type;

interface! {
    "Reads real numbers."
    [fmi2GetReal] (vr: *const ValueReference, nvr: usize, value: *mut f64)
    |instance| get(instance, Type::Real, (vr, nvr), (value, nvr), real);

    "Reads real numbers, of which the time is one."
    [fmi3GetFloat64] (
        references: *const ValueReference, count: usize, values: *mut f64, nValues: usize
    ) |instance| {
        let (references, places) = places((references, count), (values, nValues))?;
        for (reference, place) in references.iter().zip(places) {
            if *reference == instance.time_reference() {
                *place = instance.now_s();
                continue;
            }
            instance.read(Type::Real, &[*reference], |_, value| {
                *place = real(value).unwrap_or(*place);
            })?;
        }
        Ok(())
    };

    "Reads integers."
    [fmi2GetInteger] (vr: *const ValueReference, nvr: usize, value: *mut c_int)
    |instance| get(instance, Type::Integer, (vr, nvr), (value, nvr), integer);

    "Reads integers."
    [fmi3GetInt32] (
        references: *const ValueReference, count: usize, values: *mut i32, nValues: usize
    ) |instance| get(instance, Type::Integer, (references, count), (values, nValues), integer);

    "Reads booleans."
    [fmi2GetBoolean] (vr: *const ValueReference, nvr: usize, value: *mut Boolean2)
    |instance| get(instance, Type::Boolean, (vr, nvr), (value, nvr), boolean);

    "Reads booleans."
    [fmi3GetBoolean] (
        references: *const ValueReference, count: usize, values: *mut Boolean3, nValues: usize
    ) |instance| get(instance, Type::Boolean, (references, count), (values, nValues), boolean);

    "Writes real numbers: all or none."
    [fmi2SetReal] (vr: *const ValueReference, nvr: usize, value: *const f64)
    |instance| set(instance, (vr, nvr), (value, nvr), Value::Real);

    "Writes real numbers: all or none."
    [fmi3SetFloat64] (
        references: *const ValueReference, count: usize, values: *const f64, nValues: usize
    ) |instance| set(instance, (references, count), (values, nValues), Value::Real);

    "Writes integers: all or none."
    [fmi2SetInteger] (vr: *const ValueReference, nvr: usize, value: *const c_int)
    |instance| set(instance, (vr, nvr), (value, nvr), Value::Integer);

    "Writes integers: all or none."
    [fmi3SetInt32] (
        references: *const ValueReference, count: usize, values: *const i32, nValues: usize
    ) |instance| set(instance, (references, count), (values, nValues), Value::Integer);

    "Writes booleans: all or none."
    [fmi2SetBoolean] (vr: *const ValueReference, nvr: usize, value: *const Boolean2)
    |instance| set(instance, (vr, nvr), (value, nvr), |value| Value::Boolean(value != 0));

    "Writes booleans: all or none."
    [fmi3SetBoolean] (
        references: *const ValueReference, count: usize, values: *const Boolean3, nValues: usize
    ) |instance| {
        set(instance, (references, count), (values, nValues), |value| Value::Boolean(value != 0))
    };
}

fn real(value: Value) -> Option<f64> {
    match value {
        Value::Real(real) => Some(real),
        _ => None,
    }
}

fn integer(value: Value) -> Option<i32> {
    match value {
        Value::Integer(integer) => Some(integer),
        _ => None,
    }
}

fn boolean<B: From<bool>>(value: Value) -> Option<B> {
    match value {
        Value::Boolean(boolean) => Some(boolean.into()),
        _ => None,
    }
}

/// The references and the places of the values: one value each, as no variable is an array.
///
/// # Safety
/// That of the [module](super).
unsafe fn places<'a, T>(
    (references, count): (*const ValueReference, usize),
    (values, values_count): (*mut T, usize),
) -> Result<(&'a [ValueReference], &'a mut [T])> {
    check(count, values_count)?;
    // SAFETY: pointers from the host with their count.
    unsafe {
        Ok((
            elements(references, count, "valueReferences")?,
            elements_mut(values, count, "values")?,
        ))
    }
}

fn check(references: usize, values: usize) -> Result<()> {
    if references == values {
        return Ok(());
    }
    Err(format!("nValues is {values}, expected {references}: no variable is an array").into())
}

/// Reads variables of a type as `T`.
///
/// # Safety
/// That of the [module](super).
unsafe fn get<T>(
    instance: &Instance,
    of_type: Type,
    references: (*const ValueReference, usize),
    values: (*mut T, usize),
    convert: impl Fn(Value) -> Option<T>,
) -> Result<()> {
    // SAFETY: pointers from the host with their counts.
    let (references, places) = unsafe { places(references, values)? };
    instance.read(of_type, references, |index, value| {
        if let (Some(place), Some(value)) = (places.get_mut(index), convert(value)) {
            *place = value;
        }
    })
}

/// Writes variables from `T`: all or none.
///
/// # Safety
/// That of the [module](super).
unsafe fn set<T: Copy>(
    instance: &mut Instance,
    (references, count): (*const ValueReference, usize),
    (values, values_count): (*const T, usize),
    convert: impl Fn(T) -> Value,
) -> Result<()> {
    check(count, values_count)?;
    // SAFETY: pointers from the host with their count.
    let (references, values) = unsafe {
        (
            elements(references, count, "valueReferences")?,
            elements(values, count, "values")?,
        )
    };
    let values = values.iter().map(|value| convert(*value));
    instance.write(references.iter().copied().zip(values))
}
