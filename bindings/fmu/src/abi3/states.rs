//! Saved FMU states.

use crate::abi::states::{
    deserialize_state, free_state, get_state, serialize_state, set_state, size_state,
};
use crate::abi::{Component, FmuState, Status};

/// Saves the state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(
    instance: *mut Component,
    FMUState: *mut FmuState,
) -> Status {
    // SAFETY: all from the host, here and below.
    unsafe { get_state(instance, "fmi3GetFMUState", FMUState) }
}

/// Restores a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut Component, FMUState: FmuState) -> Status {
    // SAFETY: as above.
    unsafe { set_state(instance, "fmi3SetFMUState", FMUState) }
}

/// Deletes a saved state and sets its pointer to null; null is ignored.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(
    instance: *mut Component,
    FMUState: *mut FmuState,
) -> Status {
    // SAFETY: as above.
    unsafe { free_state(instance, "fmi3FreeFMUState", FMUState) }
}

/// Size of a serialised state in bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut Component,
    FMUState: FmuState,
    size: *mut usize,
) -> Status {
    // SAFETY: as above.
    unsafe { size_state(instance, "fmi3SerializedFMUStateSize", FMUState, size) }
}

/// Serialises a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut Component,
    FMUState: FmuState,
    serializedState: *mut u8,
    size: usize,
) -> Status {
    let function = "fmi3SerializeFMUState";
    // SAFETY: as above.
    unsafe { serialize_state(instance, function, FMUState, serializedState, size) }
}

/// Saves a serialised state; an existing one is replaced.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut Component,
    serializedState: *const u8,
    size: usize,
    FMUState: *mut FmuState,
) -> Status {
    let function = "fmi3DeserializeFMUState";
    // SAFETY: as above.
    unsafe { deserialize_state(instance, function, serializedState, size, FMUState) }
}
