//! The part of an actuator that changes, for callers that save and restore it in each step.
#![allow(
    unsafe_code,
    reason = "functions that C calls by name, with its pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the header states the requirements of all pointers once, at its top"
)]

use model_core::actuator::CoreState;
use model_core::models::delay::DelayCursor;
use model_core::time::ticks;

use crate::actuator::Actuator;
use crate::error::{Code, code};
use crate::memory::{self, Holds};
use crate::settings::Settings;

/// Words of 8 bytes in `struct actuator_state`.
pub const ACTUATOR_STATE_WORDS: usize = 64;

/// The state of an actuator without its parameters: a third of `struct actuator` without a delay.
/// Opaque; it contains no pointers and may be copied as bytes.
///
/// The commands in transit are behind it in a larger piece of memory, of which this struct is the
/// start: `actuator_state_size` returns the bytes of both.
#[repr(C)]
pub struct State {
    /// Private to the library.
    pub opaque: [u64; ACTUATOR_STATE_WORDS],
}

/// The value in that memory; behind it are the commands in transit.
pub struct Saved {
    core: CoreState,
    delay: DelayCursor,
}

impl Holds for State {
    type Value = Saved;
    const MARK: u64 = u64::from_le_bytes(*b"ACTSTAT1");
}

/// Bytes of the state of an actuator with these settings, at most `sizeof(struct actuator_state)`
/// without a delay; 0 if the settings are not initialised.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_state_size(settings: *const Settings) -> usize {
    // SAFETY: the caller's pointer, as the header requires it.
    let settings = unsafe { memory::look(settings) };
    settings.map_or(0, |settings| {
        memory::size_with_tail::<State>(ticks(settings.setup.delay_s) as usize)
    })
}

/// Saves the state of an actuator in memory of `size` bytes, at least those of
/// `actuator_state_size`, which is zeroed or holds a saved state.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_save(
    actuator: *const Actuator,
    state: *mut State,
    size: usize,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them; the memory of the actuator was
    // filled with that of its delay.
    let save = || unsafe {
        let (started, line) = memory::look_with_tail(actuator, |now| now.delay.len())?;
        if size < memory::size_with_tail::<State>(line.len()) {
            return Err(Code::Size);
        }
        if let Ok(saved) = memory::change(state) {
            // What is there is written over, part by part.
            started.core.save_state(&mut saved.core);
            saved.delay = started.delay;
        } else {
            let core = started.core.state();
            let (delay, tail) = (started.delay, line.len());
            let make = || Ok::<_, Code>((Saved { core, delay }, tail));
            memory::fill_with_tail(state, size, make)?;
        }
        if !line.is_empty() {
            let (_, passed) = memory::change_with_tail(state, |saved| saved.delay.len())?;
            passed.copy_from_slice(line);
        }
        Ok(())
    };
    code(save())
}

/// Continues from a saved state of this actuator, or of another one that was started with the same
/// settings: all that follows is the same to the last bit. Less time is needed than for a copy of
/// the struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_restore(actuator: *mut Actuator, state: *const State) -> Code {
    // SAFETY: the caller's pointers, as the header requires them; both memories were filled with
    // that of their delay, and are different objects.
    let restore = || unsafe {
        let (saved, passed) = memory::look_with_tail(state, |saved| saved.delay.len())?;
        let (started, line) = memory::change_with_tail(actuator, |now| now.delay.len())?;
        if line.len() != passed.len() || started.core.set_state(&saved.core).is_err() {
            return Err(Code::State);
        }
        started.delay = saved.delay;
        if !line.is_empty() {
            line.copy_from_slice(passed);
        }
        Ok(())
    };
    code(restore())
}
