//! Cycles of an instruction at most, without the wait states of its fetch and its operands.
//!
//! Arm 100166_0001 (Cortex-M4 technical reference manual, r0p1), table 3-1 for the integer
//! instructions and section 7.2 for the floating-point ones. A load is never taken as pipelined.
//! The refill of the pipeline after a taken branch is counted apart.

/// Cycles to refill the pipeline after a branch: P of table 3-1 is 1 to 3.
pub const REFILL: u64 = 3;

/// Cycles of a load or store of one word.
const LOAD: u64 = 2;

/// Cycles of a store with an immediate offset: the next instruction executes meanwhile
/// (section 3.3.2). What a peripheral takes longer is counted with its access.
const STORE: u64 = 1;

/// Cycles of a division: 2 to 12.
const DIVIDE: u64 = 12;

/// Cycles of a floating-point division or root.
const FLOAT_DIVIDE: u64 = 14;

/// Cycles of a floating-point multiplication with addition.
const FLOAT_ACCUMULATE: u64 = 3;

/// An instruction that uses the result of a floating-point one waits for a cycle.
const FLOAT_RESULT: u64 = 1;

/// Cycles of `MRS`, `MSR`, `CPS`.
const SPECIAL: u64 = 2;

/// Whether this instruction is one of the floating-point unit.
pub fn is_float(first: u16) -> bool {
    first & 0xec00 == 0xec00
}

/// The cycles of an instruction of one or two halfwords.
pub fn cycles(first: u16, second: u16) -> u64 {
    if first >> 11 < 0b11101 {
        narrow(first)
    } else if is_float(first) {
        float(first, second)
    } else {
        wide(first, second)
    }
}

fn narrow(half: u16) -> u64 {
    let listed = u64::from((half & 0xff).count_ones());
    match half >> 8 {
        // Stores with an immediate offset.
        0x60..=0x67 | 0x70..=0x77 | 0x80..=0x87 | 0x90..=0x97 => STORE,
        // Literals, register offsets, immediate offsets, offsets from the stack pointer.
        0x48..=0x9f => LOAD,
        // PUSH and POP: LR and PC are one more.
        0xb4 | 0xbc => 1 + listed,
        0xb5 | 0xbd => 2 + listed,
        0xb6 => SPECIAL,
        0xc0..=0xcf => 1 + listed,
        _ => 1,
    }
}

fn wide(first: u16, second: u16) -> u64 {
    match first {
        // LDM, STM.
        _ if first & 0xfe40 == 0xe800 => 1 + u64::from(second.count_ones()),
        // LDRD, STRD, exclusive ones, TBB, TBH.
        _ if first & 0xfe40 == 0xe840 => 1 + LOAD,
        // STR with an immediate offset of 12 bits, or of 8 bits.
        _ if first & 0xff90 == 0xf880 || first & 0xff90 == 0xf800 && second & 0x800 != 0 => STORE,
        _ if first & 0xfe00 == 0xf800 => LOAD,
        // SDIV, UDIV.
        _ if first & 0xffd0 == 0xfb90 => DIVIDE,
        // Barriers: data has arrived, as no store is taken as buffered; ISB refills the pipeline.
        0xf3bf => 1 + REFILL,
        // MSR, MRS.
        _ if first & 0xffe0 == 0xf380 || first & 0xffe0 == 0xf3e0 => SPECIAL,
        _ => 1,
    }
}

fn float(first: u16, second: u16) -> u64 {
    let words = u64::from(second & 0xff);
    match first {
        // Two core registers.
        _ if first & 0xffe0 == 0xec40 => 2 + FLOAT_RESULT,
        // VLDR, VSTR of two words.
        _ if first & 0xff20 == 0xed00 => 1 + LOAD,
        // VLDM, VSTM, VPUSH, VPOP.
        _ if first & 0xfe00 == 0xec00 => 1 + words,
        // Between registers, VMRS, VMSR.
        _ if second & 0x10 != 0 => 1 + FLOAT_RESULT,
        _ if first & 0xffb0 == 0xee80 => FLOAT_DIVIDE + FLOAT_RESULT,
        _ if first & 0xffbf == 0xeeb1 && second & 0xc0 == 0xc0 => FLOAT_DIVIDE + FLOAT_RESULT,
        _ if matches!(first & 0xffb0, 0xee00 | 0xee10 | 0xee90 | 0xeea0) => {
            FLOAT_ACCUMULATE + FLOAT_RESULT
        }
        _ => 1 + FLOAT_RESULT,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_class_has_the_cycles_of_the_manual() {
        let cases = [
            ("adds r0, #1", [0x3001, 0], 1),
            ("ldr r0, [sp, #36]", [0x9809, 0], 2),
            ("ldr r0, [pc, #4]", [0x4801, 0], 2),
            ("push {r4, r5, r6, r7, lr}", [0xb5f0, 0], 6),
            ("pop {r4, r5, r6, r7, pc}", [0xbdf0, 0], 6),
            ("stmia r0!, {r1, r2}", [0xc006, 0], 3),
            ("cpsid i", [0xb672, 0], 2),
            ("ldmia.w sp!, {r8, r9, fp}", [0xe8bd, 0x0b00], 4),
            ("ldrexb r1, [r0]", [0xe8d0, 0x1f4f], 3),
            ("str.w r8, [sp, #-4]!", [0xf84d, 0x8d04], 1),
            ("ldr.w r0, [r1, #16]", [0xf8d1, 0x0010], 2),
            ("strb.w r1, [r0, #64]", [0xf880, 0x1040], 1),
            ("str.w r5, [r9, r3]", [0xf849, 0x5003], 2),
            ("str r1, [r0, #4]", [0x6041, 0], 1),
            ("str r1, [r0, r2]", [0x5081, 0], 2),
            ("umull r2, r3, r0, ip", [0xfba0, 0x230c], 1),
            ("mla r0, r1, r2, r3", [0xfb01, 0x3002], 1),
            ("udiv r0, r1, r2", [0xfbb1, 0xf0f2], 12),
            ("sdiv r0, r1, r2", [0xfb91, 0xf0f2], 12),
            ("msr BASEPRI, r0", [0xf380, 0x8811], 2),
            ("mrs r8, BASEPRI", [0xf3ef, 0x8811], 2),
            ("movw r2, #41755", [0xf24a, 0x321b], 1),
            ("bl", [0xf00f, 0xfe6f], 1),
            ("vadd.f32 s0, s0, s1", [0xee30, 0x0a20], 2),
            ("vdiv.f32 s0, s0, s1", [0xee80, 0x0a20], 15),
            ("vsqrt.f32 s0, s1", [0xeeb1, 0x0ae0], 15),
            ("vmla.f32 s0, s1, s2", [0xee00, 0x0a81], 4),
            ("vmov s0, r0", [0xee00, 0x0a10], 2),
            ("vldr s0, [r0]", [0xed90, 0x0a00], 3),
            ("vpush {d8}", [0xed2d, 0x8b02], 3),
        ];
        for (name, [first, second], expected) in cases {
            assert_eq!(cycles(first, second), expected, "{name}");
        }
    }
}
