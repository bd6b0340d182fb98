//! Checksum and copy of a value's memory, several words at a time, since both run in every control
//! period.
//!
//! In assembly, since the bytes between the fields of a value have no value for the compiler, and
//! since a library's copy of any length has no bound of its own.

use core::arch::asm;

/// Size of a type in words.
const fn words_of<T>() -> usize {
    assert!(size_of::<T>().is_multiple_of(4) && align_of::<T>() >= 4);
    size_of::<T>() / 4
}

/// Checksum of all bytes of a value, also of those between its fields: each word is added without
/// carry to the sum rotated by one bit. A change within one word always changes it; a change of
/// several words is missed with a probability of 2^-32.
#[inline(always)]
pub fn checksum_of<T>(value: &T) -> u32 {
    // SAFETY: the reference makes the memory valid.
    unsafe { checksum_at(value) }
}

/// As [`checksum_of`], of memory that has the bytes of a value, but need not be one.
///
/// # Safety
/// The memory is valid for reads of one `T`.
#[inline(always)]
pub unsafe fn checksum_at<T>(start: *const T) -> u32 {
    let words = const { words_of::<T>() };
    let mut checksum: u32 = !0;
    // SAFETY: reads the memory of one `T` alone.
    unsafe {
        asm!(
            "b 2f",
            "1: ldmia r0!, {{r2-r5, r8, r10, r12, lr}}",
            "eor {sum}, r2, {sum}, ror #1",
            "eor {sum}, r3, {sum}, ror #1",
            "eor {sum}, r4, {sum}, ror #1",
            "eor {sum}, r5, {sum}, ror #1",
            "eor {sum}, r8, {sum}, ror #1",
            "eor {sum}, r10, {sum}, ror #1",
            "eor {sum}, r12, {sum}, ror #1",
            "eor {sum}, lr, {sum}, ror #1",
            "2: subs r1, r1, #8",
            "bpl 1b",
            "adds r1, r1, #8",
            "beq 4f",
            "3: ldr r2, [r0], #4",
            "eor {sum}, r2, {sum}, ror #1",
            "subs r1, r1, #1",
            "bne 3b",
            "4:",
            sum = inout(reg) checksum,
            inout("r0") start => _,
            inout("r1") words => _,
            out("r2") _, out("r3") _, out("r4") _, out("r5") _,
            out("r8") _, out("r10") _, out("r12") _, out("lr") _,
            options(readonly, nostack),
        );
    }
    checksum
}

/// Copies all bytes of a value, also those between its fields.
///
/// # Safety
/// As [`core::ptr::copy_nonoverlapping`] of one value.
#[inline(never)]
pub unsafe fn copy<T>(from: *const T, to: *mut T) {
    let words = const { words_of::<T>() };
    // SAFETY: reads one `T` and writes another one, as the caller permits.
    unsafe {
        asm!(
            "b 2f",
            "1: ldmia r0!, {{r3-r5, r8, r10, r12, lr}}",
            "stmia r1!, {{r3-r5, r8, r10, r12, lr}}",
            "2: subs r2, r2, #7",
            "bpl 1b",
            "adds r2, r2, #7",
            "beq 4f",
            "3: ldr r3, [r0], #4",
            "str r3, [r1], #4",
            "subs r2, r2, #1",
            "bne 3b",
            "4:",
            inout("r0") from => _,
            inout("r1") to => _,
            inout("r2") words => _,
            out("r3") _, out("r4") _, out("r5") _,
            out("r8") _, out("r10") _, out("r12") _, out("lr") _,
            options(nostack),
        );
    }
}
