//! An actuator that is stepped by its caller.
#![allow(
    unsafe_code,
    reason = "functions that C calls by name, with its pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the header states the requirements of all pointers once, at its top"
)]

use model_core::actuator::Actuator as Core;
use model_core::time::{TICKS_PER_SECOND, ticks};

use crate::error::{Code, Error, Why, code, explain};
use crate::memory::{self, Holds};
use crate::settings::Settings;

/// Version of this interface: it changes with the layout or the meaning of anything in the header.
pub const ACTUATOR_ABI_VERSION: u32 = 1;

/// Ticks in one second: a tick is 50 us.
pub const ACTUATOR_TICKS_PER_SECOND: u64 = 20_000;

const _: () = assert!(ACTUATOR_TICKS_PER_SECOND == TICKS_PER_SECOND);

/// The longest single step, ticks: an hour, which a PC computes in two minutes at most. A longer
/// step is refused, since it is most likely a wrong unit or an uninitialised time.
pub const ACTUATOR_LONGEST_STEP_TICKS: u64 = 72_000_000;

/// Words of 8 bytes in `struct actuator`: 20,000 of them are the delay line of up to 1 s.
pub const ACTUATOR_WORDS: usize = 20_480;

/// Size of `struct actuator`, bytes.
pub const ACTUATOR_SIZE: usize = 163_840;

/// Alignment of `struct actuator` and `struct actuator_settings`, bytes, sufficient on every
/// target.
pub const ACTUATOR_ALIGNMENT: usize = 8;

const _: () = assert!(ACTUATOR_SIZE == size_of::<Actuator>());
const _: () = assert!(ACTUATOR_ALIGNMENT >= align_of::<Actuator>());

/// An actuator with all of its state. Opaque. It contains no pointers: a copy by assignment or
/// memcpy is a snapshot, and copying it back restores it.
#[repr(C)]
pub struct Actuator {
    /// Private to the library.
    pub opaque: [u64; ACTUATOR_WORDS],
}

impl Holds for Actuator {
    type Value = Core;
    const MARK: u64 = u64::from_le_bytes(*b"ACTUATO1");
}

/// The outputs of an actuator. A quantity that the model does not have is zero; one that it does
/// not measure is the true value.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Ticks of 50 us since the start.
    pub tick: u64,
    /// The command after the transport delay, deg.
    pub command_deg: f64,
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// Duty of the bridge, %.
    pub duty_pct: f64,
    /// Measured angle, deg.
    pub angle_meas_deg: f64,
    /// Measured rate, deg/s.
    pub rate_meas_deg_s: f64,
    /// Motor current, A; of the bench only.
    pub current_a: f64,
    /// Back-EMF, V; of the bench only.
    pub back_emf_v: f64,
}

/// `ACTUATOR_ABI_VERSION` of the library: compare it with that of the header.
#[unsafe(no_mangle)]
pub extern "C" fn actuator_abi_version() -> u32 {
    ACTUATOR_ABI_VERSION
}

/// `ACTUATOR_SIZE` of the library, bytes.
#[unsafe(no_mangle)]
pub extern "C" fn actuator_size() -> usize {
    ACTUATOR_SIZE
}

/// Initialises an actuator with these settings, at rest at 0 deg and time 0. Previous content is
/// overwritten; on failure the actuator is not ready. The settings are not referenced afterwards.
///
/// `size` is `sizeof *actuator`. The call needs 500 KiB of stack; the others need 16 KiB.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_start(
    actuator: *mut Actuator,
    size: usize,
    settings: *const Settings,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let make = || Ok::<_, Error>(Core::try_new(memory::look(settings)?)?);
        explain(memory::fill(actuator, size, make), why)
    }
}

/// Advances by a number of ticks of 50 us with a constant command, deg.
///
/// The first command is also the past of the delay line: only later ones are delayed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_advance(
    actuator: *mut Actuator,
    command_deg: f64,
    ticks: u64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| advance(actuator, command_deg, ticks)))
}

/// Advances to the tick nearest to `time_s` after the start, s, with a constant command, deg.
///
/// For simulations whose step is not a whole number of ticks, such as 1/120 s: the absolute time
/// prevents a drift between the two.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_advance_to(
    actuator: *mut Actuator,
    command_deg: f64,
    time_s: f64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| {
        // Written so that NaN and negative times fail.
        let time_s = if time_s >= 0.0 {
            time_s
        } else {
            return Err(Code::Time);
        };
        let step = ticks(time_s).checked_sub(actuator.tick());
        advance(actuator, command_deg, step.ok_or(Code::Time)?)
    }))
}

fn advance(actuator: &mut Core, command_deg: f64, ticks: u64) -> Result<(), Code> {
    if ticks > ACTUATOR_LONGEST_STEP_TICKS {
        return Err(Code::Time);
    }
    let result = actuator.advance(command_deg, ticks);
    result.map_err(|_| Code::Command)
}

/// Applies a torque to the load, Nm, from the next PWM period on, in addition to the parameter.
/// Only the bench has a load; the other models accept and ignore any finite torque.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_set_load_nm(actuator: *mut Actuator, torque_nm: f64) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| {
        let result = actuator.set_load_torque_nm(torque_nm);
        result.map_err(|_| Code::Command)
    }))
}

/// Reads the outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_read(actuator: *const Actuator, reading: *mut Reading) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let read = || memory::put(reading, memory::look(actuator)?.into());
        code(read())
    }
}

impl From<&Core> for Reading {
    fn from(actuator: &Core) -> Self {
        let now = actuator.reading();
        Self {
            tick: actuator.tick(),
            command_deg: now.command_deg,
            angle_deg: now.angle_deg,
            rate_deg_s: now.rate_deg_s,
            duty_pct: now.duty_pct,
            angle_meas_deg: now.angle_meas_deg,
            rate_meas_deg_s: now.rate_meas_deg_s,
            current_a: now.current_a,
            back_emf_v: now.back_emf_v,
        }
    }
}
