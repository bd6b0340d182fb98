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

use crate::actuator::{
    ACTUATOR_LONGEST_STEP_TICKS, Actuator, Load, Started, actuator_drive_load_to, level,
};
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
    // SAFETY: the caller's pointers, as the header requires them.
    code(unsafe { save(actuator, state, size) })
}

/// Saves a state.
///
/// # Safety
/// As the header requires of the pointers.
#[inline(always)]
unsafe fn save(actuator: *const Actuator, state: *mut State, size: usize) -> Result<(), Code> {
    // SAFETY: the contract of this function; the memories were filled with that of their delay.
    unsafe {
        let (started, line) = memory::look_with_tail(actuator, |now| now.delay.len())?;
        if size < memory::size_with_tail::<State>(line.len()) {
            return Err(Code::Size);
        }
        let Ok(saved) = memory::change(state) else {
            return save_first(started, line, state, size);
        };
        // What is there is written over, part by part.
        started.core.save_state(&mut saved.core);
        saved.delay = started.delay;
        if !line.is_empty() {
            let (_, passed) = memory::change_with_tail(state, |saved| saved.delay.len())?;
            passed.copy_from_slice(line);
        }
        Ok(())
    }
}

/// Saves a state in memory that does not hold one.
///
/// # Safety
/// As [`save`].
#[cold]
unsafe fn save_first(
    started: &Started,
    line: &[f64],
    state: *mut State,
    size: usize,
) -> Result<(), Code> {
    let make = || {
        let (core, delay) = (started.core.state(), started.delay);
        Ok::<_, Code>((Saved { core, delay }, line.len()))
    };
    // SAFETY: the contract of this function; the memory was filled with that of the delay.
    unsafe {
        memory::fill_with_tail(state, size, make)?;
        let (_, passed) = memory::change_with_tail(state, |saved| saved.delay.len())?;
        passed.copy_from_slice(line);
    }
    Ok(())
}

/// Continues from a saved state of this actuator, or of another one that was started with the same
/// settings: all that follows is the same to the last bit. Less time is needed than for a copy of
/// the struct.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_restore(actuator: *mut Actuator, state: *const State) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    code(unsafe { restore(actuator, state) })
}

/// As `actuator_restore`, then as `actuator_drive_load_to`: the whole step of a simulation whose
/// load does not act on the actuator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_drive_from(
    actuator: *mut Actuator,
    state: *const State,
    input: i32,
    value: f64,
    time_s: f64,
    load: *mut Load,
) -> Code {
    if let Err(code) = memory::check(load) {
        return code;
    }
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        if let Ok(now) = advance(actuator, state, input, value, time_s) {
            return code(memory::put(load, now));
        }
        match restore(actuator, state) {
            Ok(()) => actuator_drive_load_to(actuator, input, value, time_s, load),
            Err(code) => code,
        }
    }
}

/// Continues from a state and advances, in the most frequent case; an error in all others.
///
/// # Safety
/// As the header requires of the pointers.
#[inline(always)]
unsafe fn advance(
    actuator: *mut Actuator,
    state: *const State,
    input: i32,
    value: f64,
    time_s: f64,
) -> Result<Load, Code> {
    // SAFETY: the contract of this function.
    let (started, saved) = unsafe { (memory::change(actuator)?, memory::look(state)?) };
    if !(started.delay.is_empty() && saved.delay.is_empty() && time_s >= 0.0) {
        return Err(Code::State);
    }
    let (level, end) = (level(input)?, ticks(time_s));
    if end.saturating_sub(saved.core.tick()) > ACTUATOR_LONGEST_STEP_TICKS {
        return Err(Code::Time);
    }
    let motion = started.core.advance_from(&saved.core, level, value, end);
    motion.map(Load::unloaded).ok_or(Code::State)
}

/// Continues from a state.
///
/// # Safety
/// As the header requires of the pointers.
#[inline(always)]
unsafe fn restore(actuator: *mut Actuator, state: *const State) -> Result<(), Code> {
    // SAFETY: the contract of this function; both memories were filled with that of their delay,
    // and are different objects.
    unsafe {
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
    }
}
