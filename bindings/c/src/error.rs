//! Errors as codes and as sentences.
#![allow(unsafe_code, reason = "a function that C calls by name")]

use core::ffi::{CStr, c_char};
use core::fmt;

use model_core::parameter::ParameterError;
use model_core::scenario::ScenarioError;

/// The result of a call. Only `ACTUATOR_ERROR_NONE` is 0; a call with any other changes nothing,
/// unless the function states it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// Done.
    None = 0,
    /// A pointer is null or misaligned.
    Pointer = 1,
    /// A size is not that of this library, or the memory is smaller than an actuator with this
    /// delay needs: `actuator_size` returns what it needs.
    Size = 2,
    /// The memory does not hold initialised settings or a started actuator.
    NotReady = 3,
    /// The name or the index does not exist.
    Name = 4,
    /// A parameter is NaN, out of its range, or in conflict with another one.
    Parameter = 5,
    /// A command, a torque, an inertia or a motion is NaN, or out of its range.
    Command = 6,
    /// A time is NaN or in the past, or the step to it is longer than an hour.
    Time = 7,
    /// The model does not have this input.
    Input = 8,
    /// The caller's `actuator_watch` has ended the step; the part of it that was done remains.
    Interrupted = 9,
    /// The state is that of an actuator with another model or delay.
    State = 10,
}

impl Code {
    const fn sentence(self) -> &'static CStr {
        match self {
            Self::None => c"no error",
            Self::Pointer => c"a pointer is null or misaligned",
            Self::Size => {
                c"a size is not that of this library, or less than actuator_size(settings)"
            }
            Self::NotReady => c"the settings were not initialised or the actuator was not started",
            Self::Name => c"the name or the index does not exist",
            Self::Parameter => c"a parameter is out of its range or in conflict with another one",
            Self::Command => c"a command, a torque or an inertia is not finite or out of its range",
            Self::Input => c"the model does not have this input",
            Self::Interrupted => c"the step was interrupted by the caller",
            Self::State => c"the state is that of an actuator with another model or delay",
            Self::Time => c"a time is not a number, is in the past, or is more than an hour ahead",
        }
    }

    const ALL: [Self; 11] = [
        Self::None,
        Self::Pointer,
        Self::Size,
        Self::NotReady,
        Self::Name,
        Self::Parameter,
        Self::Command,
        Self::Time,
        Self::Input,
        Self::Interrupted,
        Self::State,
    ];
}

/// The text of a code, in English; any number is accepted. The text is constant.
#[unsafe(no_mangle)]
pub extern "C" fn actuator_error_text(code: i32) -> *const c_char {
    let known = Code::ALL.into_iter().find(|known| *known as i32 == code);
    known.map_or(c"unknown error", Code::sentence).as_ptr()
}

/// The reason of a failure, as a sentence with the parameter and its range.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Why {
    /// The sentence, terminated by a zero; empty on success.
    pub text: [c_char; ACTUATOR_WHY_SIZE],
}

/// Size of a sentence with the longest name, a value, its range and unit (at most 150 bytes: a
/// number usually has at most 24 characters); longer ones are truncated.
pub const ACTUATOR_WHY_SIZE: usize = 192;

/// The reason of a failure, within the library.
pub enum Error<'a> {
    /// The code alone.
    Code(Code),
    /// A name or a value is refused.
    Scenario(ScenarioError<'a>),
}

impl From<Code> for Error<'_> {
    fn from(code: Code) -> Self {
        Self::Code(code)
    }
}

impl From<ParameterError> for Error<'_> {
    fn from(error: ParameterError) -> Self {
        Self::Scenario(error.into())
    }
}

impl<'a> From<ScenarioError<'a>> for Error<'a> {
    fn from(error: ScenarioError<'a>) -> Self {
        Self::Scenario(error)
    }
}

impl Error<'_> {
    /// Its code.
    pub fn code(&self) -> Code {
        match self {
            Self::Code(code) => *code,
            Self::Scenario(ScenarioError::Parameter(_)) => Code::Parameter,
            Self::Scenario(_) => Code::Name,
        }
    }
}

impl fmt::Display for Error<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Code(code) => f.write_str(code.sentence().to_str().unwrap_or_default()),
            Self::Scenario(error) => write!(f, "{error}"),
        }
    }
}

/// The code of a result.
pub fn code(result: Result<(), Code>) -> Code {
    result.err().unwrap_or(Code::None)
}
