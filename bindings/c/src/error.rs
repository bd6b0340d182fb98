//! What can go wrong, as a code and as a sentence.
#![allow(
    unsafe_code,
    reason = "a function that C calls by name, and one that writes to its memory"
)]

use core::ffi::{CStr, c_char};
use core::fmt::{self, Write};

use model_core::parameter::ParameterError;
use model_core::scenario::ScenarioError;

use crate::memory;
use crate::text::Text;

/// What became of a call. Only `ACTUATOR_ERROR_NONE` is 0; after any other nothing has changed,
/// unless the function says otherwise.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Code {
    /// Done.
    None = 0,
    /// A pointer is null or misaligned.
    Pointer = 1,
    /// A size is not that of this library: header and library are of different versions. Nothing
    /// was touched.
    Size = 2,
    /// The memory holds no settings or no started actuator.
    NotReady = 3,
    /// Nothing has this name or this index.
    Name = 4,
    /// A parameter is NaN, outside its range, or at odds with another one.
    Parameter = 5,
    /// A command or a torque is NaN or infinite.
    Command = 6,
    /// A time is NaN or in the past, or the step to it is longer than an hour.
    Time = 7,
}

impl Code {
    const fn sentence(self) -> &'static CStr {
        match self {
            Self::None => c"no error",
            Self::Pointer => c"a pointer is null or misaligned",
            Self::Size => c"a size is not that of this library",
            Self::NotReady => c"the settings were not initialised or the actuator was not started",
            Self::Name => c"nothing has this name or index",
            Self::Parameter => c"a parameter is out of its range or at odds with another one",
            Self::Command => c"a command or a torque is not finite",
            Self::Time => c"a time is not a number, is past, or is more than an hour away",
        }
    }

    const ALL: [Self; 8] = [
        Self::None,
        Self::Pointer,
        Self::Size,
        Self::NotReady,
        Self::Name,
        Self::Parameter,
        Self::Command,
        Self::Time,
    ];
}

/// What a code means, in English; any number may be asked for. The text is constant.
#[unsafe(no_mangle)]
pub extern "C" fn actuator_error_text(code: i32) -> *const c_char {
    let known = Code::ALL.into_iter().find(|known| *known as i32 == code);
    known.map_or(c"unknown error", Code::sentence).as_ptr()
}

/// Why a call failed, in a sentence that names the parameter and its range.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct Why {
    /// The sentence, ended by a zero; empty where nothing failed.
    pub text: [c_char; ACTUATOR_WHY_SIZE],
}

/// Room for a sentence about the longest name, its value, range and unit (at most 150 bytes: a
/// number has at most 24 characters where it is not absurd); what is longer is cut.
pub const ACTUATOR_WHY_SIZE: usize = 192;

/// Why a call failed, while it is still in the library.
pub enum Error<'a> {
    /// There is nothing more to say than the code does.
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
    fn code(&self) -> Code {
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

/// The code of a result, and its sentence where the caller wants one.
///
/// # Safety
/// `why` is null, misaligned or the caller's own.
pub unsafe fn explain(result: Result<(), Error<'_>>, why: *mut Why) -> Code {
    let mut text = Text::<ACTUATOR_WHY_SIZE>::default();
    let code = match &result {
        Ok(()) => Code::None,
        Err(error) => {
            // A text that is too long is cut: that is no failure.
            let _ = write!(text, "{error}");
            error.code()
        }
    };
    // Null is how a caller says that it wants no sentence.
    // SAFETY: passed on to the caller.
    let _ = unsafe { memory::put(why, Why { text: text.0 }) };
    code
}
