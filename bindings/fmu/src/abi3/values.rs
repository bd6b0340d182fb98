//! Reading and writing of variables.

use super::Boolean;
use crate::abi::call::{Result, call, elements, elements_mut};
use crate::abi::{Component, Status};
use crate::instance::{Instance, values::Value};
use crate::variables::Type;

/// The references and the places of the values: one value each, as no variable is an array.
///
/// # Safety
/// That of the [module](super).
unsafe fn places<'a, T>(
    (references, count): (*const u32, usize),
    (values, values_count): (*mut T, usize),
) -> Result<(&'a [u32], &'a mut [T])> {
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

/// Writes variables: all or none.
///
/// # Safety
/// That of the [module](super).
unsafe fn set<T: Copy>(
    instance: &mut Instance,
    (references, count): (*const u32, usize),
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

/// Reads real numbers, of which the time is one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *mut f64,
    nValues: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: all from the host.
        let (references, places) =
            unsafe { places((valueReferences, nValueReferences), (values, nValues))? };
        for (reference, place) in references.iter().zip(places) {
            if *reference == instance.time_reference() {
                *place = instance.now_s();
                continue;
            }
            instance.read(Type::Real, &[*reference], |_, value| {
                if let Value::Real(real) = value {
                    *place = real;
                }
            })?;
        }
        Ok(())
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3GetFloat64", body) }
}

/// Reads integers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetInt32(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *mut i32,
    nValues: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: all from the host.
        let (references, places) =
            unsafe { places((valueReferences, nValueReferences), (values, nValues))? };
        instance.read(Type::Integer, references, |index, value| {
            if let (Some(place), Value::Integer(integer)) = (places.get_mut(index), value) {
                *place = integer;
            }
        })
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3GetInt32", body) }
}

/// Reads booleans.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetBoolean(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *mut Boolean,
    nValues: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: all from the host.
        let (references, places) =
            unsafe { places((valueReferences, nValueReferences), (values, nValues))? };
        instance.read(Type::Boolean, references, |index, value| {
            if let (Some(place), Value::Boolean(boolean)) = (places.get_mut(index), value) {
                *place = boolean.into();
            }
        })
    };
    // SAFETY: an instance from the host.
    unsafe { call(instance, "fmi3GetBoolean", body) }
}

/// Writes real numbers: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *const f64,
    nValues: usize,
) -> Status {
    let references = (valueReferences, nValueReferences);
    // SAFETY: all from the host.
    unsafe {
        call(instance, "fmi3SetFloat64", |instance| {
            set(instance, references, (values, nValues), Value::Real)
        })
    }
}

/// Writes integers: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetInt32(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *const i32,
    nValues: usize,
) -> Status {
    let references = (valueReferences, nValueReferences);
    // SAFETY: all from the host.
    unsafe {
        call(instance, "fmi3SetInt32", |instance| {
            set(instance, references, (values, nValues), Value::Integer)
        })
    }
}

/// Writes booleans: all or none.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetBoolean(
    instance: *mut Component,
    valueReferences: *const u32,
    nValueReferences: usize,
    values: *const Boolean,
    nValues: usize,
) -> Status {
    let references = (valueReferences, nValueReferences);
    // SAFETY: all from the host.
    unsafe {
        call(instance, "fmi3SetBoolean", |instance| {
            set(instance, references, (values, nValues), |value| {
                Value::Boolean(value != 0)
            })
        })
    }
}
