//! The memory of the control loop, which only the loop's tasks can write.
//!
//! A region of the memory protection unit makes it read-only (ARMv7-M, section B3.5), except while
//! a task of the loop has it. A write by any other task is a hard fault: the bridge is switched off
//! and the watchdog resets the processor. The region does not restrict the loop itself, nor DMA
//! controllers, none of which is set to this memory.

use core::{cell::UnsafeCell, mem::MaybeUninit};

use cortex_m::{asm, peripheral::MPU};

use super::loop_task::LoopTask;

/// Size of the region, bytes: a power of two, to which the region is aligned.
const SIZE: usize = 4096;

/// The memory.
#[repr(C, align(4096))]
struct Region(UnsafeCell<MaybeUninit<LoopTask>>);

const _: () = assert!(size_of::<Region>() == SIZE);

// SAFETY: it is accessed by the owner of the `LoopMemory` alone, of which there is one.
unsafe impl Sync for Region {}

#[unsafe(no_mangle)]
static CONTROL_LOOP: Region = Region(UnsafeCell::new(MaybeUninit::uninit()));

/// Size, and enable.
const ENABLED: u32 = (SIZE.ilog2() - 1) << 1 | 1;

/// Normal memory, write-back, and never executed.
const DATA: u32 = 1 << 28 | 0b001 << 19 | 0b11 << 16;

/// Access permissions of privileged software, as which the whole program runs.
const READ_ONLY: u32 = 0b101 << 24;
const READ_WRITE: u32 = 0b001 << 24;

/// The access to the memory.
pub struct LoopMemory(MPU);

impl LoopMemory {
    /// Places the task into its memory, and protects it. To be called once. Not inlined: the task
    /// stays out of the stack frame of the initialisation, which is the largest one.
    #[inline(never)]
    pub fn new(mpu: MPU, task: impl FnOnce() -> LoopTask) -> Self {
        // SAFETY: nothing refers to the memory yet.
        unsafe { (*CONTROL_LOOP.0.get()).write(task()) };
        let address = CONTROL_LOOP.0.get().addr() as u32;
        // SAFETY: region 0 covers the static above and nothing else; all other memory keeps the
        // permissions of the default map (PRIVDEFENA).
        unsafe {
            mpu.rnr.write(0);
            mpu.rbar.write(address);
            mpu.rasr.write(DATA | READ_ONLY | ENABLED);
            mpu.ctrl.write(1 << 2 | 1);
        }
        asm::dsb();
        asm::isb();
        Self(mpu)
    }

    /// Uses the task.
    #[inline]
    pub fn with<R>(&mut self, use_task: impl FnOnce(&mut LoopTask) -> R) -> R {
        self.permit(READ_WRITE);
        // SAFETY: `new` has initialised the memory, and `self` is borrowed mutably.
        let result = use_task(unsafe { (*CONTROL_LOOP.0.get()).assume_init_mut() });
        self.permit(READ_ONLY);
        result
    }

    #[inline]
    fn permit(&mut self, access: u32) {
        // SAFETY: as in `new`.
        unsafe { self.0.rasr.write(DATA | access | ENABLED) };
        asm::dsb();
        asm::isb();
    }
}
