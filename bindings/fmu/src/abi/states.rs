//! Saved FMU states, for both versions of the standard.

use std::ptr::{null_mut, without_provenance_mut};

use super::call::{call, elements, elements_mut, place};
use super::types::{Component, FmuState, Status};
use crate::instance::Instance;

/// Saves the state; an existing one is replaced.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn get_state(c: *mut Component, function: &str, FMUstate: *mut FmuState) -> Status {
    let body = |instance: &mut Instance| {
        // SAFETY: a pointer from the host.
        let state = unsafe { place(FMUstate, "FMUstate")? };
        let key = (!state.is_null()).then(|| state.addr());
        *state = without_provenance_mut(instance.keep(key)?);
        Ok(())
    };
    // SAFETY: a component from the host.
    unsafe { call(c, function, body) }
}

/// Restores a saved state.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn set_state(c: *mut Component, function: &str, FMUstate: FmuState) -> Status {
    let body = |instance: &mut Instance| instance.put_back(FMUstate.addr());
    // SAFETY: a component from the host.
    unsafe { call(c, function, body) }
}

/// Deletes a saved state and sets its pointer to null; null is ignored.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn free_state(c: *mut Component, function: &str, FMUstate: *mut FmuState) -> Status {
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
    unsafe { call(c, function, body) }
}

/// Size of a serialised state in bytes.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn size_state(
    c: *mut Component,
    function: &str,
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
    unsafe { call(c, function, body) }
}

/// Serialises a saved state.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn serialize_state(
    c: *mut Component,
    function: &str,
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
    unsafe { call(c, function, body) }
}

/// Saves a serialised state; an existing one is replaced.
///
/// # Safety
/// That of the [module](super).
pub unsafe fn deserialize_state(
    c: *mut Component,
    function: &str,
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
    unsafe { call(c, function, body) }
}

/// Saves the state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: *mut Component, FMUstate: *mut FmuState) -> Status {
    // SAFETY: all from the host.
    unsafe { get_state(c, "fmi2GetFMUstate", FMUstate) }
}

/// Restores a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: *mut Component, FMUstate: FmuState) -> Status {
    // SAFETY: all from the host.
    unsafe { set_state(c, "fmi2SetFMUstate", FMUstate) }
}

/// Deletes a saved state and sets its pointer to null; null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: *mut Component, FMUstate: *mut FmuState) -> Status {
    // SAFETY: all from the host.
    unsafe { free_state(c, "fmi2FreeFMUstate", FMUstate) }
}

/// Size of a serialised state in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: *mut Component,
    FMUstate: FmuState,
    size: *mut usize,
) -> Status {
    // SAFETY: all from the host.
    unsafe { size_state(c, "fmi2SerializedFMUstateSize", FMUstate, size) }
}

/// Serialises a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: *mut Component,
    FMUstate: FmuState,
    serializedState: *mut u8,
    size: usize,
) -> Status {
    // SAFETY: all from the host.
    unsafe { serialize_state(c, "fmi2SerializeFMUstate", FMUstate, serializedState, size) }
}

/// Saves a serialised state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: *mut Component,
    serializedState: *const u8,
    size: usize,
    FMUstate: *mut FmuState,
) -> Status {
    // SAFETY: all from the host.
    unsafe {
        deserialize_state(
            c,
            "fmi2DeSerializeFMUstate",
            serializedState,
            size,
            FMUstate,
        )
    }
}
