//! A large stack for what is done once, before the control loop runs.
//!
//! A device with its object dictionary is built on the stack and then moved to where it stays: that takes several times
//! its size, once. The core-coupled memory, 64 KiB that nothing else uses, lends it. Everything after that runs on the
//! stack of `memory.x`.

use core::{arch::asm, mem::ManuallyDrop};

unsafe extern "C" {
    /// The end of the core-coupled memory (`memory.x`).
    static _boot_stack_start: u32;
}

/// Calls a function on that stack.
///
/// # Safety
/// Interrupts are masked, as they are in `init`, and the function does not call this again: there is one such stack.
pub unsafe fn call<F: FnOnce()>(task: F) {
    let mut task = ManuallyDrop::new(task);
    // SAFETY: the stack pointer comes back before anybody else could see it, from a register that the function called
    // preserves. That stack is memory that nobody else uses, and the task outlives the call.
    unsafe {
        asm!(
            "mov r4, sp",
            "mov sp, {top}",
            "blx {run}",
            "mov sp, r4",
            top = in(reg) &raw const _boot_stack_start,
            run = in(reg) run::<F> as extern "C" fn(*mut ManuallyDrop<F>),
            inout("r0") &raw mut task => _,
            out("r4") _,
            // What a function need not preserve (AAPCS32, section 6.1).
            out("r1") _, out("r2") _, out("r3") _, out("r12") _, out("lr") _,
            out("d0") _, out("d1") _, out("d2") _, out("d3") _,
            out("d4") _, out("d5") _, out("d6") _, out("d7") _,
        );
    }
}

extern "C" fn run<F: FnOnce()>(task: *mut ManuallyDrop<F>) {
    // SAFETY: `call` calls this once, with a task of its own.
    let task = unsafe { ManuallyDrop::take(&mut *task) };
    task();
}
