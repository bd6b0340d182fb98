//! The compiler's helpers for blocks of memory, small: those that come with Rust are unrolled into
//! 2.8 KB. Words at odd addresses are no trouble to this processor (PM0214, section 3.3.5).

use core::{arch::naked_asm, ffi::c_void};

/// Copies `n` bytes from `source` upwards.
///
/// # Safety
/// As `memcpy` of C; `target` may lie below `source` in the same block.
#[unsafe(no_mangle)]
#[unsafe(naked)]
pub unsafe extern "C" fn memcpy(
    target: *mut c_void,
    source: *const c_void,
    n: usize,
) -> *mut c_void {
    naked_asm!(
        ".globl __aeabi_memcpy, __aeabi_memcpy4, __aeabi_memcpy8",
        ".thumb_set __aeabi_memcpy, memcpy",
        "mov ip, r0",
        "subs r2, #4",
        "blo 2f",
        "1: ldr r3, [r1], #4",
        "str r3, [ip], #4",
        "subs r2, #4",
        "bhs 1b",
        "2: adds r2, #4",
        "beq 4f",
        "3: ldrb r3, [r1], #1",
        "strb r3, [ip], #1",
        "subs r2, #1",
        "bne 3b",
        "4: bx lr",
        // Where both are aligned, four words at once: the control step hands its outputs on so.
        ".thumb_func",
        "__aeabi_memcpy4: .thumb_set __aeabi_memcpy8, __aeabi_memcpy4",
        "push {{r4, r5}}",
        "b 6f",
        "5: ldm r1!, {{r3, r4, r5, ip}}",
        "stm r0!, {{r3, r4, r5, ip}}",
        "6: subs r2, #16",
        "bhs 5b",
        "adds r2, #16",
        "pop {{r4, r5}}",
        "b memcpy",
    )
}

/// Copies `n` bytes within a block that may overlap.
///
/// # Safety
/// As `memmove` of C.
#[unsafe(no_mangle)]
#[unsafe(naked)]
pub unsafe extern "C" fn memmove(
    target: *mut c_void,
    source: *const c_void,
    n: usize,
) -> *mut c_void {
    naked_asm!(
        ".globl __aeabi_memmove, __aeabi_memmove4, __aeabi_memmove8",
        ".thumb_set __aeabi_memmove, memmove",
        ".thumb_set __aeabi_memmove4, memmove",
        ".thumb_set __aeabi_memmove8, memmove",
        // Upwards, unless the target begins within the source.
        "subs r3, r0, r1",
        "cmp r3, r2",
        "bhs memcpy",
        "adds r1, r1, r2",
        "add ip, r0, r2",
        "cbz r2, 2f",
        "1: ldrb r3, [r1, #-1]!",
        "strb r3, [ip, #-1]!",
        "subs r2, #1",
        "bne 1b",
        "2: bx lr",
    )
}

/// Fills `n` bytes.
///
/// # Safety
/// As `memset` of C.
#[unsafe(no_mangle)]
#[unsafe(naked)]
pub unsafe extern "C" fn memset(target: *mut c_void, byte: i32, n: usize) -> *mut c_void {
    naked_asm!(
        ".globl __aeabi_memclr, __aeabi_memclr4, __aeabi_memclr8",
        ".globl __aeabi_memset, __aeabi_memset4, __aeabi_memset8",
        "b 1f",
        // Their arguments are (target, n) and (target, n, byte).
        ".thumb_func",
        "__aeabi_memclr: .thumb_set __aeabi_memclr4, __aeabi_memclr",
        ".thumb_set __aeabi_memclr8, __aeabi_memclr",
        "movs r2, #0",
        ".thumb_func",
        "__aeabi_memset: .thumb_set __aeabi_memset4, __aeabi_memset",
        ".thumb_set __aeabi_memset8, __aeabi_memset",
        "mov r3, r1",
        "mov r1, r2",
        "mov r2, r3",
        "1: uxtb r1, r1",
        "orr r1, r1, r1, lsl #8",
        "orr r1, r1, r1, lsl #16",
        "mov ip, r0",
        "subs r2, #4",
        "blo 3f",
        "2: str r1, [ip], #4",
        "subs r2, #4",
        "bhs 2b",
        "3: adds r2, #4",
        "beq 5f",
        "4: strb r1, [ip], #1",
        "subs r2, #1",
        "bne 4b",
        "5: bx lr",
    )
}

/// The order of `n` bytes: the difference of the first two that differ.
///
/// # Safety
/// As `memcmp` of C.
#[unsafe(no_mangle)]
#[unsafe(naked)]
pub unsafe extern "C" fn memcmp(a: *const c_void, b: *const c_void, n: usize) -> i32 {
    naked_asm!(
        ".globl bcmp",
        ".thumb_set bcmp, memcmp",
        "mov ip, r0",
        "movs r0, #0",
        "cbz r2, 2f",
        "1: ldrb r0, [ip], #1",
        "ldrb r3, [r1], #1",
        "subs r0, r0, r3",
        "bne 2f",
        "subs r2, #1",
        "bne 1b",
        "2: bx lr",
    )
}
