//! An actuator that is stepped by its caller.
#![allow(
    unsafe_code,
    reason = "functions that C calls by name, with its pointers"
)]
#![allow(
    clippy::missing_safety_doc,
    reason = "the header states the requirements of all pointers once, at its top"
)]

use core::ffi::c_void;

use model_core::actuator::{ActuatorCore, CommandError, InputLevel};
use model_core::models::delay::DelayCursor;
use model_core::plant::PlantState;
use model_core::time::{TICKS_PER_SECOND, ticks};

use crate::error::{Code, Error, Why, code};
use crate::memory::{self, Holds};
use crate::settings::Settings;

/// Version of this interface: it changes with the layout or the meaning of anything in the header.
pub const ACTUATOR_ABI_VERSION: u32 = 2;

/// Ticks in one second: a tick is 50 us.
pub const ACTUATOR_TICKS_PER_SECOND: u64 = 20_000;

const _: () = assert!(ACTUATOR_TICKS_PER_SECOND == TICKS_PER_SECOND);

/// The longest single step, ticks: an hour, which a PC computes in two minutes at most. A longer
/// step is refused, since it is most likely a wrong unit or an uninitialised time.
pub const ACTUATOR_LONGEST_STEP_TICKS: u64 = 72_000_000;

/// The ticks between two calls of an `actuator_watch`: 0.1 s of the simulation, which a PC computes
/// in 4 ms at most.
pub const ACTUATOR_WATCH_TICKS: u64 = 2_000;

/// Words of 8 bytes in `struct actuator`.
pub const ACTUATOR_WORDS: usize = 800;

/// Size of `struct actuator`, bytes: sufficient for delays of up to 20 ms.
pub const ACTUATOR_SIZE: usize = 6_400;

/// Alignment of `struct actuator` and `struct actuator_settings`, bytes, sufficient on every
/// target.
pub const ACTUATOR_ALIGNMENT: usize = 8;

const _: () = assert!(ACTUATOR_SIZE == size_of::<Actuator>());
const _: () = assert!(ACTUATOR_SIZE >= memory::size_with_tail::<Actuator>(400));
const _: () = assert!(ACTUATOR_ALIGNMENT >= align_of::<Actuator>());

/// An actuator with all of its state. Opaque. It contains no pointers: a copy by assignment or
/// memcpy is a snapshot, and copying it back restores it.
///
/// An actuator with a longer delay is in a larger piece of memory, of which this struct is the
/// start: `actuator_size` returns the bytes that it needs, and a snapshot is a copy of them all.
#[repr(C)]
pub struct Actuator {
    /// Private to the library.
    pub opaque: [u64; ACTUATOR_WORDS],
}

/// The value in that memory; behind it are the commands in transit.
pub struct Started {
    pub(crate) core: ActuatorCore,
    pub(crate) delay: DelayCursor,
}

impl Holds for Actuator {
    type Value = Started;
    const MARK: u64 = u64::from_le_bytes(*b"ACTUATO2");
}

/// The quantity that an actuator is commanded in.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Input {
    /// Angle of the output shaft, deg: both loops are closed.
    Position = 0,
    /// Rate of the output shaft, deg/s: the rate loop alone is closed.
    Rate = 1,
    /// Duty of the bridge, %: no loop is closed.
    Duty = 2,
    /// Voltage at the motor's terminals, V; of the bench only.
    Voltage = 3,
}

/// The level of a number of `enum actuator_input`.
#[inline(always)]
pub(crate) fn level(input: i32) -> Result<InputLevel, Code> {
    const LEVELS: [InputLevel; 4] = {
        let mut levels = [InputLevel::Position; 4];
        levels[Input::Rate as usize] = InputLevel::Rate;
        levels[Input::Duty as usize] = InputLevel::Duty;
        levels[Input::Voltage as usize] = InputLevel::Voltage;
        levels
    };
    let known = usize::try_from(input).ok();
    known
        .and_then(|input| LEVELS.get(input).copied())
        .ok_or(Code::Input)
}

impl From<CommandError> for Code {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::Value => Self::Command,
            CommandError::Level(_) => Self::Input,
        }
    }
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

/// Bytes that an actuator with these settings needs, at most `ACTUATOR_SIZE` for delays of up to
/// 20 ms; 0 if the settings are not initialised.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_size(settings: *const Settings) -> usize {
    // SAFETY: the caller's pointer, as the header requires it.
    let settings = unsafe { memory::look(settings) };
    settings.map_or(0, |settings| {
        let delay = ticks(settings.setup.delay_s) as usize;
        memory::size_with_tail::<Actuator>(delay)
    })
}

/// Initialises an actuator with these settings, at rest at 0 deg and time 0. Previous content is
/// overwritten; on failure the actuator is not ready. The settings are not referenced afterwards.
///
/// `size` is that of the memory at `actuator`, bytes: at least `actuator_size(settings)`, for which
/// `sizeof *actuator` is sufficient with a delay of up to 20 ms. Every call needs up to 16 KiB of
/// stack.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_start(
    actuator: *mut Actuator,
    size: usize,
    settings: *const Settings,
    why: *mut Why,
) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let make = || {
            let (core, delay) = ActuatorCore::try_new(memory::look(settings)?)?;
            Ok::<_, Error>((Started { core, delay }, delay.len()))
        };
        memory::explain(memory::fill_with_tail(actuator, size, make), why)
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
    unsafe { actuator_drive(actuator, Input::Position as i32, command_deg, ticks) }
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
    unsafe { actuator_drive_to(actuator, Input::Position as i32, command_deg, time_s) }
}

/// Advances by a number of ticks of 50 us with a constant value of an input, one of
/// `enum actuator_input`, in its unit.
///
/// Sampling and delay of the test set-up apply to every input. A change of the input takes effect
/// immediately: its first value is also its past.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_drive(
    actuator: *mut Actuator,
    input: i32,
    value: f64,
    ticks: u64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    code(unsafe { drive(actuator, input, value, |_| Ok(ticks)) }.map(drop))
}

/// As `actuator_drive`, to the tick nearest to `time_s` after the start, s.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_drive_to(
    actuator: *mut Actuator,
    input: i32,
    value: f64,
    time_s: f64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    code(unsafe { drive(actuator, input, value, |now| ticks_to(time_s, now)) }.map(drop))
}

/// As `actuator_drive_to`, then as `actuator_read_load`: the step of a simulation that moves its
/// joint as the load has moved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_drive_load_to(
    actuator: *mut Actuator,
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
        match drive(actuator, input, value, |now| ticks_to(time_s, now)) {
            Ok(core) => code(memory::put(load, core.into())),
            Err(code) => code,
        }
    }
}

/// Ticks from now to that nearest to `time_s`.
fn ticks_to(time_s: f64, now: u64) -> Result<u64, Code> {
    // Written so that NaN and negative times fail.
    if time_s >= 0.0 {
        ticks(time_s).checked_sub(now).ok_or(Code::Time)
    } else {
        Err(Code::Time)
    }
}

/// Is called during a long step with the caller's `data`, the ticks that are done and the ticks of
/// the whole step; returns 0 to end the step, any other number to continue.
///
/// It may call every function of the library, for this actuator those that read it, or copy the
/// actuator. It must return: no C++ exception and no longjmp may leave it.
pub type Watch = Option<unsafe extern "C" fn(data: *mut c_void, done: u64, total: u64) -> i32>;

/// As `actuator_drive`, and calls `watch` (unless it is null) after every `ACTUATOR_WATCH_TICKS`
/// ticks and at the end, so that the caller can show the progress of a long step and interrupt it.
///
/// If `watch` returns 0 before the end, the result is `ACTUATOR_ERROR_INTERRUPTED`: the actuator is
/// at the tick that was reached (`actuator_read`) and can be advanced further. The numbers are
/// those of `actuator_drive`, to the last bit.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_drive_watched(
    actuator: *mut Actuator,
    input: i32,
    value: f64,
    ticks: u64,
    watch: Watch,
    data: *mut c_void,
) -> Code {
    // The step is accepted or refused as a whole.
    if ticks > ACTUATOR_LONGEST_STEP_TICKS {
        return Code::Time;
    }
    let mut done = 0;
    loop {
        let part = (ticks - done).min(ACTUATOR_WATCH_TICKS);
        // SAFETY: the caller's pointer, as the header requires it; no reference to the actuator
        // exists while `watch` runs.
        let result = unsafe { drive(actuator, input, value, |_| Ok(part)) };
        if let Err(code) = result {
            return code;
        }
        done += part;
        // SAFETY: the caller's function with the caller's data.
        let goes_on = watch.is_none_or(|watch| unsafe { watch(data, done, ticks) } != 0);
        if done == ticks {
            return Code::None;
        }
        if !goes_on {
            return Code::Interrupted;
        }
    }
}

/// Advances by the number of ticks that `step` returns for the present one; returns the actuator.
///
/// # Safety
/// As the header requires of the pointer.
#[inline(always)]
unsafe fn drive<'a>(
    actuator: *mut Actuator,
    input: i32,
    value: f64,
    step: impl FnOnce(u64) -> Result<u64, Code>,
) -> Result<&'a ActuatorCore, Code> {
    // SAFETY: the contract of this function; the memory was filled with that of the delay.
    let (started, line) =
        unsafe { memory::change_with_tail(actuator, |started| started.delay.len())? };
    let ticks = step(started.core.tick())?;
    if ticks > ACTUATOR_LONGEST_STEP_TICKS {
        return Err(Code::Time);
    }
    let delay = (&mut started.delay, line);
    started
        .core
        .advance_with(delay, level(input)?, value, ticks)?;
    Ok(&started.core)
}

/// Applies a torque to the load, Nm, from the next tick on, in addition to the parameter.
/// Only the bench has a load; the other models accept and ignore any finite torque.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_set_load_nm(actuator: *mut Actuator, torque_nm: f64) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| Ok(actuator.core.set_load_torque_nm(torque_nm)?)))
}

/// Adds an inertia to the load, kg m^2, up to 1e3, from the next tick on, in addition to the
/// parameter. Only the bench has a load.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_set_load_inertia(
    actuator: *mut Actuator,
    inertia_kg_m2: f64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| Ok(actuator.core.set_load_inertia_kg_m2(inertia_kg_m2)?)))
}

/// Moves the load by an angle, deg, and an impulse, Nm s: what another simulation has found to act
/// on it beyond the torque that was set. Only the bench has a load.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_push_load(
    actuator: *mut Actuator,
    angle_deg: f64,
    impulse_nms: f64,
) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| Ok(actuator.core.push_load(angle_deg, impulse_nms)?)))
}

/// Places the shaft at an angle, deg, before the first tick; later it has no effect. The board's
/// encoder then measures it within half a turn.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_place(actuator: *mut Actuator, angle_deg: f64) -> Code {
    // SAFETY: the caller's pointer, as the header requires it.
    let actuator = unsafe { memory::change(actuator) };
    code(actuator.and_then(|actuator| Ok(actuator.core.place(angle_deg)?)))
}

/// Angle and rate of the load: of the last body of the bench, which moves against the output within
/// the flexibility of the shaft, and of the output of the other models.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Angle, deg.
    pub angle_deg: f64,
    /// Rate, deg/s.
    pub rate_deg_s: f64,
    /// Torque of the shaft on the load, Nm; of the bench only.
    pub shaft_torque_nm: f64,
}

impl Load {
    /// That of an actuator without a load.
    #[inline(always)]
    pub(crate) fn unloaded(motion: PlantState) -> Self {
        Self {
            angle_deg: motion.angle_deg,
            rate_deg_s: motion.rate_deg_s,
            shaft_torque_nm: 0.0,
        }
    }
}

impl From<&ActuatorCore> for Load {
    #[inline(always)]
    fn from(actuator: &ActuatorCore) -> Self {
        Self {
            shaft_torque_nm: actuator.shaft_torque_nm(),
            ..Self::unloaded(actuator.load())
        }
    }
}

/// Reads the motion of the load.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_read_load(actuator: *const Actuator, load: *mut Load) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let read = || memory::put(load, (&memory::look(actuator)?.core).into());
        code(read())
    }
}

/// Reads the outputs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn actuator_read(actuator: *const Actuator, reading: *mut Reading) -> Code {
    // SAFETY: the caller's pointers, as the header requires them.
    unsafe {
        let read = || memory::put(reading, (&memory::look(actuator)?.core).into());
        code(read())
    }
}

impl From<&ActuatorCore> for Reading {
    fn from(actuator: &ActuatorCore) -> Self {
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
