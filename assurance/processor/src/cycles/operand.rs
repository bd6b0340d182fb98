//! Where an instruction loads its operands from (DDI 0403E, A5.2, A5.3 and A6.5).

/// Address and words of a load; `None` if it loads nothing, or only from the stack. A load that
/// updates its base before counts from the base before it.
pub fn loaded(
    address: u32,
    [first, second]: [u16; 2],
    register: &dyn Fn(u8) -> u32,
) -> Option<(u32, u32)> {
    if first >> 11 < 0b11101 {
        return narrow(address, first, register);
    }
    let base = (first & 0xf) as u8;
    let is_up = first & 0x80 != 0;
    let listed = second.count_ones();
    let (offset, is_added, words) = match first {
        // LDM counts up from its base, or down.
        _ if first & 0xffd0 == 0xe890 => (0, true, listed),
        _ if first & 0xffd0 == 0xe910 => (4 * listed, false, listed),
        // TBB and TBH: their table follows, or is at another address of the flash.
        _ if first & 0xfff0 == 0xe8d0 && second & 0xf0e0 == 0xf000 => {
            (register((second & 0xf) as u8), true, 1)
        }
        // Exclusive loads.
        _ if first & 0xfff0 == 0xe8d0 || first & 0xfff0 == 0xe850 => (0, true, 1),
        // LDRD.
        _ if first & 0xfe50 == 0xe850 => (4 * u32::from(second & 0xff), is_up, 2),
        // LDR and its kind: a literal or 12 bits, 8 bits, an index.
        _ if first & 0xfe10 == 0xf810 => {
            if is_up || base == 15 {
                (u32::from(second & 0xfff), is_up, 1)
            } else if second & 0x800 != 0 {
                let offset = u32::from(second & 0xff);
                // Without bit 10 the base is updated afterwards.
                let is_before = second & 0x400 != 0;
                (if is_before { offset } else { 0 }, second & 0x200 != 0, 1)
            } else {
                (
                    register((second & 0xf) as u8) << (second >> 4 & 0b11),
                    true,
                    1,
                )
            }
        }
        // VLDR, VLDM.
        _ if first & 0xff30 == 0xed10 => (4 * u32::from(second & 0xff), is_up, 2),
        _ if first & 0xfe10 == 0xec10 => (0, true, u32::from(second & 0xff)),
        _ => return None,
    };
    let start = match base {
        13 => return None,
        15 => (address + 4) & !3,
        base => register(base),
    };
    let from = if is_added {
        start.wrapping_add(offset)
    } else {
        start.wrapping_sub(offset)
    };
    Some((from, words))
}

fn narrow(address: u32, half: u16, register: &dyn Fn(u8) -> u32) -> Option<(u32, u32)> {
    let field = |low: u32| register((half >> low & 0b111) as u8);
    let offset = u32::from(half >> 6 & 0x1f);
    Some(match half {
        0x4800..=0x4fff => (((address + 4) & !3) + 4 * u32::from(half & 0xff), 1),
        // LDRSB, LDR, LDRH, LDRB, LDRSH with an index.
        0x5600..=0x5fff => (field(3).wrapping_add(field(6)), 1),
        0x6800..=0x6fff => (field(3).wrapping_add(4 * offset), 1),
        0x7800..=0x7fff => (field(3).wrapping_add(offset), 1),
        0x8800..=0x8fff => (field(3).wrapping_add(2 * offset), 1),
        0xc800..=0xcfff => (field(8), (half & 0xff).count_ones()),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loads_have_their_addresses_and_other_instructions_none() {
        let register = |number: u8| 0x100 * u32::from(number);
        let cases = [
            ("ldr r0, [pc, #4]", [0x4801, 0], Some((0x8008, 1))),
            ("ldr r1, [r4, r0]", [0x5821, 0], Some((0x400, 1))),
            ("str r0, [r4, r0]", [0x5020, 0], None),
            ("ldr r1, [r4, #4]", [0x6861, 0], Some((0x404, 1))),
            ("ldrh r1, [r4, #2]", [0x8861, 0], Some((0x402, 1))),
            ("str r1, [r4, #4]", [0x6061, 0], None),
            ("ldr r0, [sp, #4]", [0x9801, 0], None),
            ("ldr.w r0, [r4, #68]", [0xf8d4, 0x0044], Some((0x444, 1))),
            (
                "ldr.w r0, [r4, r3, lsl #2]",
                [0xf854, 0x0023],
                Some((0x1000, 1)),
            ),
            ("ldr.w r0, [r4, #-4]", [0xf854, 0x0c04], Some((0x3fc, 1))),
            ("ldr.w r0, [r4], #4", [0xf854, 0x0b04], Some((0x400, 1))),
            (
                "ldrb.w r2, [fp, #1661]",
                [0xf89b, 0x267d],
                Some((0x117d, 1)),
            ),
            ("pop.w {r8, r9, fp}", [0xe8bd, 0x0b00], None),
            ("ldmia.w r1!, {r4, r5}", [0xe8b1, 0x0030], Some((0x100, 2))),
            ("ldmdb r1, {r4, r5}", [0xe911, 0x0030], Some((0xf8, 2))),
            ("ldrd r0, r1, [r2, #8]", [0xe9d2, 0x0102], Some((0x208, 2))),
            ("ldrexb r1, [r2]", [0xe8d2, 0x1f4f], Some((0x200, 1))),
            ("vldr s0, [r1, #4]", [0xed91, 0x0a01], Some((0x104, 2))),
            ("adds r0, #1", [0x3001, 0], None),
        ];
        for (name, halves, expected) in cases {
            assert_eq!(loaded(0x8000, halves, &register), expected, "{name}");
        }
    }
}
