//! Saved FMU states.

use std::ptr::{null_mut, without_provenance_mut};

use super::call::{call, elements, elements_mut, place};
use super::types::{Component, FmuState, Status};
use crate::instance::Instance;

/// Saves the state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut Component, FMUstate: *mut FmuState) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        let state = unsafe { place(FMUstate, "FMUstate")? };
        let key = (!state.is_null()).then(|| state.addr());
        *state = without_provenance_mut(instance.keep(key)?);
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2GetFMUstate", body) }
}

/// Restores a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut Component, FMUstate: FmuState) -> Status {
    let body = |instance: &mut Instance| instance.put_back(FMUstate.addr());
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2SetFMUstate", body) }
}

/// Deletes a saved state and sets its pointer to null; null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut Component, FMUstate: *mut FmuState) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        let state = unsafe { place(FMUstate, "FMUstate")? };
        if !state.is_null() {
            instance.forget(state.addr())?;
            *state = null_mut();
        }
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2FreeFMUstate", body) }
}

/// Size of a serialised state in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: *mut Component,
    FMUstate: FmuState,
    size: *mut usize,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        let size = unsafe { place(size, "size")? };
        *size = instance.bytes(FMUstate.addr())?.len();
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2SerializedFMUstateSize", body) }
}

/// Serialises a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut Component,
    FMUstate: FmuState,
    serializedState: *mut u8,
    size: usize,
) -> Status {
    let body = |instance: &mut Instance| {
        let bytes = instance.bytes(FMUstate.addr())?;
        if size != bytes.len() {
            return Err(format!("size is {size}, expected {}", bytes.len()).into());
        }
        // SAFETY: a pointer from the host with its count.
        let places = unsafe { elements_mut(serializedState, size, "serializedState")? };
        places.copy_from_slice(&bytes);
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2SerializeFMUstate", body) }
}

/// Saves a serialised state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut Component,
    serializedState: *const u8,
    size: usize,
    FMUstate: *mut FmuState,
) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: pointers from the host, the first with its count.
        let (state, bytes) = unsafe {
            (
                place(FMUstate, "FMUstate")?,
                elements(serializedState, size, "serializedState")?,
            )
        };
        let key = (!state.is_null()).then(|| state.addr());
        *state = without_provenance_mut(instance.keep_bytes(bytes, key)?);
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, "fmi2DeSerializeFMUstate", body) }
}
