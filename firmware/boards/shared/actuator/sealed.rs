//! Memory that must not change between two uses.

use core::arch::asm;

/// A value that a checksum protects while it is not in use.
pub struct Sealed<T: 'static> {
    content: &'static mut T,
    /// The checksum since the end of the last use; none during a use.
    checksum: Option<u32>,
}

impl<T> Sealed<T> {
    /// A value in use.
    pub fn new(content: &'static mut T) -> Self {
        Self {
            content,
            checksum: None,
        }
    }

    /// Starts a use; returns whether the value is as it was at the end of the last use. If it is
    /// not, it must not be used.
    pub fn unseal(&mut self) -> bool {
        let sealed = self.checksum.take();
        sealed.is_none_or(|checksum| checksum == checksum_of(self.content))
    }

    /// The value, during a use.
    pub fn get(&mut self) -> &mut T {
        self.content
    }

    /// Ends a use.
    pub fn seal(&mut self) {
        self.checksum = Some(checksum_of(self.content));
    }
}

/// Checksum of all bytes of a value, also of those between its fields: each word is added without
/// carry to the sum rotated by one bit. A change within one word always changes it; a change of
/// several words is missed with a probability of 2^-32.
fn checksum_of<T>(value: &T) -> u32 {
    const { assert!(size_of::<T>().is_multiple_of(4) && align_of::<T>() >= 4) }
    let words = size_of::<T>() / 4;
    let start = core::ptr::from_ref(value);
    let mut checksum: u32 = !0;
    // SAFETY: reads the memory of the value alone. In assembly, since the bytes between its fields
    // have no value for the compiler; eight words at once, since it runs six times in a control
    // period.
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
