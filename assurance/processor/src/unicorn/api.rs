//! The functions of `libunicorn` that are used, as its header `unicorn.h` (2.1) declares them.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::path::Path;

use libloading::Library;

use super::UnicornError;

/// An instance.
pub type Handle = *mut c_void;

type Open = unsafe extern "C" fn(c_int, c_int, *mut Handle) -> c_int;
type Close = unsafe extern "C" fn(Handle) -> c_int;
type Text = unsafe extern "C" fn(c_int) -> *const c_char;
type Version = unsafe extern "C" fn(*mut u32, *mut u32) -> u32;
type Control = unsafe extern "C" fn(Handle, u32, ...) -> c_int;
type MapMemory = unsafe extern "C" fn(Handle, u64, u64, u32, *mut c_void) -> c_int;
type MapRegisters =
    unsafe extern "C" fn(Handle, u64, u64, OnRead, *mut c_void, OnWrite, *mut c_void) -> c_int;
type AddHook = unsafe extern "C" fn(
    Handle,
    *mut usize,
    c_int,
    *mut c_void,
    *mut c_void,
    u64,
    u64,
    ...
) -> c_int;
type Start = unsafe extern "C" fn(Handle, u64, u64, u64, usize) -> c_int;
type Stop = unsafe extern "C" fn(Handle) -> c_int;
type Registers = unsafe extern "C" fn(Handle, *mut c_int, *mut *mut c_void, c_int) -> c_int;

/// Called before each instruction: its address and size, and the context of the hook.
pub type OnCode = extern "C" fn(Handle, u64, u32, *mut c_void);
/// Called at each exception: its number in QEMU.
pub type OnException = extern "C" fn(Handle, u32, *mut c_void);
/// Called before each access to memory: type, address, size, value.
pub type OnMemory = extern "C" fn(Handle, c_int, u64, c_int, i64, *mut c_void);
/// Called for each read of a register: its offset and size; returns the value.
pub type OnRead = extern "C" fn(Handle, u64, u32, *mut c_void) -> u64;
/// Called for each write of a register: its offset, size and value.
pub type OnWrite = extern "C" fn(Handle, u64, u32, u64, *mut c_void);

/// The functions; their library stays loaded as long as they exist.
#[derive(Debug)]
pub struct Api {
    pub open: Open,
    pub close: Close,
    pub control: Control,
    pub map_memory: MapMemory,
    pub map_registers: MapRegisters,
    pub add_hook: AddHook,
    pub start: Start,
    pub stop: Stop,
    pub read_registers: Registers,
    pub write_registers: Registers,
    text: Text,
    version: Version,
    _library: Library,
}

/// Major version whose header these declarations follow.
const MAJOR: u32 = 2;

impl Api {
    /// Loads the library.
    ///
    /// # Errors
    /// The file is no such library, or one of another major version.
    #[allow(
        unsafe_code,
        reason = "loads a library in C, with the types of its header"
    )]
    pub fn load(path: &Path) -> Result<Self, UnicornError> {
        let refused = |source| UnicornError::Library {
            path: path.into(),
            source,
        };
        // SAFETY: the library's initialisation has no preconditions.
        let library = unsafe { Library::new(path) }.map_err(refused)?;
        /// A function of the library, by its name in C.
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type of the field is that of the header.
                *unsafe { library.get($name) }.map_err(refused)?
            };
        }
        let api = Self {
            open: function!(b"uc_open\0"),
            close: function!(b"uc_close\0"),
            control: function!(b"uc_ctl\0"),
            map_memory: function!(b"uc_mem_map_ptr\0"),
            map_registers: function!(b"uc_mmio_map\0"),
            add_hook: function!(b"uc_hook_add\0"),
            start: function!(b"uc_emu_start\0"),
            stop: function!(b"uc_emu_stop\0"),
            read_registers: function!(b"uc_reg_read_batch\0"),
            write_registers: function!(b"uc_reg_write_batch\0"),
            text: function!(b"uc_strerror\0"),
            version: function!(b"uc_version\0"),
            _library: library,
        };
        match api.version() {
            (MAJOR, _) => Ok(api),
            (major, minor) => Err(UnicornError::Version { major, minor }),
        }
    }

    /// Major and minor version of the library.
    #[allow(unsafe_code, reason = "calls a function in C")]
    pub fn version(&self) -> (u32, u32) {
        let (mut major, mut minor) = (0, 0);
        // SAFETY: both pointers are valid for a write.
        unsafe { (self.version)(&raw mut major, &raw mut minor) };
        (major, minor)
    }

    /// The result of a call.
    ///
    /// # Errors
    /// The call failed.
    #[allow(unsafe_code, reason = "calls a function in C")]
    pub fn check(&self, call: &'static str, code: c_int) -> Result<(), UnicornError> {
        if code == 0 {
            return Ok(());
        }
        // SAFETY: the function returns a static string for every number.
        let message = unsafe { CStr::from_ptr((self.text)(code)) };
        Err(UnicornError::Call {
            call,
            message: message.to_string_lossy().into_owned(),
        })
    }
}
