//! The second emulator: [Unicorn](https://www.unicorn-engine.org), the translator of QEMU as a
//! library, here as a Cortex-M4.
//!
//! It has no interrupt controller, no clock and no peripherals: its [`Host`] answers what an
//! instruction reads outside of plain memory, and takes and returns from exceptions.

mod api;
mod memory;

use std::ffi::{c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::Arc;

use api::{Api, Handle, OnCode, OnException, OnMemory};
pub use memory::Memory;

/// Why the second emulator cannot be used, or has stopped.
#[derive(Debug, thiserror::Error)]
pub enum UnicornError {
    /// The library cannot be loaded.
    #[error("{}: {source}", path.display())]
    Library {
        /// The library.
        path: PathBuf,
        /// Why.
        source: libloading::Error,
    },
    /// The library has another interface.
    #[error("libunicorn {major}.{minor}, where 2.x is expected")]
    Version {
        /// Its major version.
        major: u32,
        /// Its minor version.
        minor: u32,
    },
    /// A call failed.
    #[error("{call}: {message}")]
    Call {
        /// The call.
        call: &'static str,
        /// Why.
        message: String,
    },
}

/// What the emulator calls while it runs.
pub trait Host {
    /// Called before each instruction, with its address; returns whether it executes. If not, the
    /// emulator stops.
    fn instruction(&mut self, address: u32) -> bool;

    /// A read of a register outside of plain memory.
    fn read(&mut self, address: u32, bytes: u32) -> u32;

    /// A write to a register outside of plain memory.
    fn write(&mut self, address: u32, bytes: u32, value: u32);

    /// Called before an access to a watched range of plain memory. The value of a write.
    fn access(&mut self, address: u32, bytes: u32, write: Option<u32>);

    /// The program returns from an exception.
    fn exception_return(&mut self);
}

/// A register, by its number in `unicorn/arm.h`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Register(c_int);

impl Register {
    /// R0 to R15.
    pub const fn core(number: u8) -> Self {
        match number {
            13 => Self(12),
            14 => Self(10),
            15 => Self(11),
            _ => Self(66 + number as c_int),
        }
    }

    /// S0 to S31.
    pub const fn single(number: u8) -> Self {
        Self(79 + number as c_int)
    }

    /// Floating-point status and control.
    pub const FPSCR: Self = Self(6);
    /// Interrupt masks and CONTROL.
    pub const CONTROL: Self = Self(117);
    /// The three program status registers.
    pub const XPSR: Self = Self(120);
    /// PRIMASK.
    pub const PRIMASK: Self = Self(123);
    /// BASEPRI.
    pub const BASEPRI: Self = Self(124);
    /// FAULTMASK.
    pub const FAULTMASK: Self = Self(126);
}

/// What a hook needs.
struct Context<H> {
    host: H,
    stop: unsafe extern "C" fn(Handle) -> c_int,
}

/// An emulator with its host.
pub struct Unicorn<H> {
    handle: Handle,
    context: *mut Context<H>,
    memory: Arc<Memory>,
    api: Api,
}

impl<H> std::fmt::Debug for Unicorn<H> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Unicorn").finish_non_exhaustive()
    }
}

#[allow(unsafe_code, reason = "the library has no thread of its own")]
// SAFETY: the instance, its context and its memory are owned and used by one thread at a time.
unsafe impl<H: Send> Send for Unicorn<H> {}

/// Architecture ARM, Thumb code of the M profile, Cortex-M4.
const ARM: c_int = 1;
const THUMB_M: c_int = 1 << 4 | 1 << 5;
const CORTEX_M4: c_int = 9;

/// `UC_CTL_WRITE(UC_CTL_CPU_MODEL, 1)`.
const SET_MODEL: u32 = 7 | 1 << 26 | 1 << 30;

/// `UC_CTL_WRITE(UC_CTL_TB_FLUSH, 0)`.
const FLUSH_CODE: u32 = 10 | 1 << 30;

const HOOK_EXCEPTION: c_int = 1;
const HOOK_CODE: c_int = 1 << 2;
const HOOK_MEMORY: c_int = 1 << 10 | 1 << 11;
const MEMORY_WRITE: c_int = 17;
const ALL_RIGHTS: u32 = 7;

/// QEMU's number of a return from an exception (`EXCP_EXCEPTION_EXIT`).
const EXCEPTION_RETURN: u32 = 8;

#[allow(
    unsafe_code,
    reason = "calls the library; each block states why it is sound"
)]
impl<H: Host> Unicorn<H> {
    /// An emulator without memory.
    ///
    /// # Errors
    /// The library cannot be used.
    pub fn open(library: &Path, host: H) -> Result<Self, UnicornError> {
        let api = Api::load(library)?;
        let mut handle = ptr::null_mut();
        // SAFETY: `handle` is valid for a write.
        api.check("uc_open", unsafe {
            (api.open)(ARM, THUMB_M, &raw mut handle)
        })?;
        let stop = api.stop;
        let unicorn = Self {
            handle,
            context: Box::into_raw(Box::new(Context { host, stop })),
            memory: Arc::default(),
            api,
        };
        // SAFETY: the call takes one number of type int.
        let code = unsafe { (unicorn.api.control)(handle, SET_MODEL, CORTEX_M4) };
        unicorn.api.check("uc_ctl", code)?;
        let code: OnCode = on_code::<H>;
        unicorn.hook(HOOK_CODE, code as *mut c_void, (1, 0))?;
        let exception: OnException = on_exception::<H>;
        unicorn.hook(HOOK_EXCEPTION, exception as *mut c_void, (1, 0))?;
        Ok(unicorn)
    }

    /// Version of the library.
    pub fn version(&self) -> (u32, u32) {
        self.api.version()
    }

    /// Discards all translated code.
    ///
    /// # Errors
    /// The library refuses it.
    pub fn forget_code(&mut self) -> Result<(), UnicornError> {
        // SAFETY: the call takes no further arguments.
        let code = unsafe { (self.api.control)(self.handle, FLUSH_CODE) };
        self.api.check("uc_ctl", code)
    }

    /// Adds a hook for a range of addresses; for all if its end is below its begin.
    fn hook(
        &self,
        kind: c_int,
        function: *mut c_void,
        (begin, end): (u64, u64),
    ) -> Result<(), UnicornError> {
        let mut hook = 0;
        // SAFETY: the function has the type that the header gives for this kind, and the context
        // lives until the instance is closed.
        let code = unsafe {
            (self.api.add_hook)(
                self.handle,
                &raw mut hook,
                kind,
                function,
                self.context.cast(),
                begin,
                end,
            )
        };
        self.api.check("uc_hook_add", code)
    }

    /// Maps plain memory: start addresses and lengths.
    ///
    /// # Errors
    /// Two regions overlap, or an address is not that of a page.
    pub fn map_memory(&mut self, regions: &[(u32, usize)]) -> Result<(), UnicornError> {
        let mut memory = Memory::default();
        for &(start, length) in regions {
            let bytes = memory.add(start, length);
            // SAFETY: the block lives until the instance is closed, and does not move.
            let code = unsafe {
                (self.api.map_memory)(
                    self.handle,
                    start.into(),
                    length as u64,
                    ALL_RIGHTS,
                    bytes.as_ptr().cast(),
                )
            };
            self.api.check("uc_mem_map_ptr", code)?;
        }
        self.memory = Arc::new(memory);
        Ok(())
    }

    /// Maps a region whose accesses the host answers.
    ///
    /// # Errors
    /// It overlaps another, or an address is not that of a page.
    pub fn map_registers(&self, start: u32, length: u32) -> Result<(), UnicornError> {
        let base = Box::new(Registers {
            start,
            context: self.context,
        });
        // Lives as long as the process: there are a few in a run.
        let user: *mut c_void = Box::into_raw(base).cast();
        // SAFETY: both functions have the types of the header.
        let code = unsafe {
            (self.api.map_registers)(
                self.handle,
                start.into(),
                length.into(),
                on_read::<H>,
                user,
                on_write::<H>,
                user,
            )
        };
        self.api.check("uc_mmio_map", code)
    }

    /// Calls the host before each access to this range of plain memory. No instruction in the block
    /// of an IT instruction may access it: the library restores the state of the block before the
    /// call, and does not clear it afterwards, so that the next instructions set no flags.
    ///
    /// # Errors
    /// The library refuses it.
    pub fn watch_memory(&self, begin: u32, end: u32) -> Result<(), UnicornError> {
        let memory: OnMemory = on_memory::<H>;
        let range = (begin.into(), u64::from(end) - 1);
        self.hook(HOOK_MEMORY, memory as *mut c_void, range)
    }

    /// The plain memory.
    pub fn memory(&self) -> &Arc<Memory> {
        &self.memory
    }

    /// The host.
    pub fn host(&mut self) -> &mut H {
        // SAFETY: the context is owned, and no hook runs.
        unsafe { &mut (*self.context).host }
    }

    /// Runs from this address until the host stops it, or it reaches the address of the end.
    ///
    /// # Errors
    /// An instruction that the processor does not have, or an access to nothing.
    pub fn run(&mut self, address: u32, end: Option<u32>) -> Result<(), UnicornError> {
        let end = u64::from(end.unwrap_or(0));
        // SAFETY: the instance is open; the lowest bit selects Thumb code.
        let code = unsafe { (self.api.start)(self.handle, u64::from(address | 1), end, 0, 0) };
        self.api.check("uc_emu_start", code)
    }

    /// Reads registers.
    ///
    /// # Panics
    /// If the library does not know one of them.
    pub fn read<const N: usize>(&self, registers: [Register; N]) -> [u32; N] {
        // Some registers are written as 64 bits.
        let mut values = [0_u64; N];
        let mut numbers = registers.map(|register| register.0);
        let first = values.as_mut_ptr();
        let mut pointers: [*mut c_void; N] =
            std::array::from_fn(|index| first.wrapping_add(index).cast());
        // SAFETY: every pointer is valid for a write of eight bytes.
        let code = unsafe {
            let (numbers, pointers) = (numbers.as_mut_ptr(), pointers.as_mut_ptr());
            (self.api.read_registers)(self.handle, numbers, pointers, N as c_int)
        };
        assert_eq!(code, 0, "reads registers");
        values.map(|value| value as u32)
    }

    /// Writes registers.
    ///
    /// # Panics
    /// If the library does not know one of them.
    pub fn write<const N: usize>(&mut self, registers: [(Register, u32); N]) {
        let mut values = registers.map(|(_, value)| u64::from(value));
        let mut numbers = registers.map(|(register, _)| register.0);
        let first = values.as_mut_ptr();
        let mut pointers: [*mut c_void; N] =
            std::array::from_fn(|index| first.wrapping_add(index).cast());
        // SAFETY: every pointer is valid for a read of eight bytes.
        let code = unsafe {
            let (numbers, pointers) = (numbers.as_mut_ptr(), pointers.as_mut_ptr());
            (self.api.write_registers)(self.handle, numbers, pointers, N as c_int)
        };
        assert_eq!(code, 0, "writes registers");
    }
}

impl<H> Drop for Unicorn<H> {
    #[allow(unsafe_code, reason = "closes the instance")]
    fn drop(&mut self) {
        // SAFETY: the instance is open and the context is that of `open`; nothing uses them any
        // more. The memory is dropped afterwards.
        unsafe {
            (self.api.close)(self.handle);
            drop(Box::from_raw(self.context));
        }
    }
}

/// What the functions of a region of registers need.
struct Registers<H> {
    start: u32,
    context: *mut Context<H>,
}

#[allow(
    unsafe_code,
    reason = "called by the library with the context of the hook"
)]
extern "C" fn on_code<H: Host>(handle: Handle, address: u64, _: u32, context: *mut c_void) {
    // SAFETY: the context of the hook; the emulator runs, so that nothing else uses it.
    let context = unsafe { &mut *context.cast::<Context<H>>() };
    if !context.host.instruction(address as u32) {
        // SAFETY: the instance is open.
        unsafe { (context.stop)(handle) };
    }
}

#[allow(
    unsafe_code,
    reason = "called by the library with the context of the hook"
)]
extern "C" fn on_exception<H: Host>(handle: Handle, number: u32, context: *mut c_void) {
    // SAFETY: as in `on_code`.
    let context = unsafe { &mut *context.cast::<Context<H>>() };
    if number == EXCEPTION_RETURN {
        context.host.exception_return();
    }
    // SAFETY: the instance is open.
    unsafe { (context.stop)(handle) };
}

#[allow(
    unsafe_code,
    reason = "called by the library with the context of the hook"
)]
extern "C" fn on_memory<H: Host>(
    _: Handle,
    kind: c_int,
    address: u64,
    size: c_int,
    value: i64,
    context: *mut c_void,
) {
    // SAFETY: as in `on_code`.
    let context = unsafe { &mut *context.cast::<Context<H>>() };
    let write = (kind == MEMORY_WRITE).then_some(value as u32);
    context.host.access(address as u32, size as u32, write);
}

#[allow(
    unsafe_code,
    reason = "called by the library with the context of the region"
)]
extern "C" fn on_read<H: Host>(_: Handle, offset: u64, size: u32, user: *mut c_void) -> u64 {
    // SAFETY: the context of the region, which is not dropped; the emulator runs.
    let (registers, context) = unsafe {
        let registers = &*user.cast::<Registers<H>>();
        (registers, &mut *registers.context)
    };
    let address = registers.start + offset as u32;
    context.host.read(address, size).into()
}

#[allow(
    unsafe_code,
    reason = "called by the library with the context of the region"
)]
extern "C" fn on_write<H: Host>(_: Handle, offset: u64, size: u32, value: u64, user: *mut c_void) {
    // SAFETY: as in `on_read`.
    let (registers, context) = unsafe {
        let registers = &*user.cast::<Registers<H>>();
        (registers, &mut *registers.context)
    };
    let address = registers.start + offset as u32;
    context.host.write(address, size, value as u32);
}
