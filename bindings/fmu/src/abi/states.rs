//! Saved FMU states.

use std::ptr::{null_mut, without_provenance_mut};

use super::call::{elements, elements_mut, place};
use super::types::FmuState;

interface! {
    "Saves the state; an existing one is replaced."
    [fmi2GetFMUstate, fmi3GetFMUState] (state: *mut FmuState) |instance| {
        let state = place(state, "FMUstate")?;
        let key = (!state.is_null()).then(|| state.addr());
        *state = without_provenance_mut(instance.keep(key)?);
        Ok(())
    };

    "Restores a saved state."
    [fmi2SetFMUstate, fmi3SetFMUState] (state: FmuState) |instance| instance.put_back(state.addr());

    "Deletes a saved state and sets its pointer to null; null is ignored."
    [fmi2FreeFMUstate, fmi3FreeFMUState] (state: *mut FmuState) |instance| {
        let state = place(state, "FMUstate")?;
        if !state.is_null() {
            instance.forget(state.addr())?;
            *state = null_mut();
        }
        Ok(())
    };

    "Size of a serialised state in bytes."
    [fmi2SerializedFMUstateSize, fmi3SerializedFMUStateSize] (
        state: FmuState, size: *mut usize
    ) |instance| {
        *place(size, "size")? = instance.bytes(state.addr())?.len();
        Ok(())
    };

    "Serialises a saved state."
    [fmi2SerializeFMUstate, fmi3SerializeFMUState] (
        state: FmuState, serializedState: *mut u8, size: usize
    ) |instance| {
        let bytes = instance.bytes(state.addr())?;
        if size != bytes.len() {
            return Err(format!("size is {size}, expected {}", bytes.len()).into());
        }
        elements_mut(serializedState, size, "serializedState")?.copy_from_slice(&bytes);
        Ok(())
    };

    "Saves a serialised state; an existing one is replaced."
    [fmi2DeSerializeFMUstate, fmi3DeserializeFMUState] (
        serializedState: *const u8, size: usize, state: *mut FmuState
    ) |instance| {
        let state = place(state, "FMUstate")?;
        let bytes = elements(serializedState, size, "serializedState")?;
        let key = (!state.is_null()).then(|| state.addr());
        *state = without_provenance_mut(instance.keep_bytes(bytes, key)?);
        Ok(())
    };
}
