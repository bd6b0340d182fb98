//! Which registers of the core an instruction uses and which it replaces.
//!
//! What is not certain is a use: an injection is then simulated.

use std::collections::HashMap;

use capstone::arch::DetailsArchInsn as _;
use capstone::arch::arm::{
    ArchExtraMode, ArchMode, ArmCC, ArmInsn, ArmOperand, ArmOperandType, ArmReg, ArmShift,
};
use capstone::prelude::*;

/// A set of registers: R0 to R15 by their numbers, and the flags.
pub type Registers = u32;

/// The flags N, Z, C, V and Q.
pub const N: Registers = 1 << 16;
pub const Z: Registers = 1 << 17;
pub const C: Registers = 1 << 18;
pub const V: Registers = 1 << 19;
pub const Q: Registers = 1 << 20;

/// All registers and flags.
pub const ALL: Registers = (1 << 21) - 1;

/// The flags by which a condition is decided.
const CONDITION: Registers = N | Z | C | V;

const SP: Registers = 1 << 13;
const LR: Registers = 1 << 14;

/// What an instruction does with the registers. A register in both sets is used first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effects {
    /// Registers whose content it may use.
    pub uses: Registers,
    /// Registers whose former content is lost after it.
    pub replaces: Registers,
}

/// An instruction that may do anything.
const UNKNOWN: Effects = Effects {
    uses: ALL,
    replaces: 0,
};

/// A decoder that keeps what it has decoded.
#[derive(Debug, Default)]
pub struct Decoder {
    known: HashMap<u32, Effects>,
}

impl Decoder {
    /// The effects of the instruction at this address, whose bytes are read once.
    pub fn effects(&mut self, address: u32, read: impl FnOnce() -> [u8; 4]) -> Effects {
        let decode = || decode(address, read()).unwrap_or(UNKNOWN);
        *self.known.entry(address).or_insert_with(decode)
    }
}

fn decode(address: u32, bytes: [u8; 4]) -> Option<Effects> {
    // Another one each time: it may not move to another thread, as a board does.
    let engine = Capstone::new()
        .arm()
        .mode(ArchMode::Thumb)
        .extra_mode([ArchExtraMode::MClass].into_iter())
        .detail(true)
        .build()
        .ok()?;
    let found = engine.disasm_count(&bytes, address.into(), 1).ok()?;
    let insn = found.first()?;
    let detail = engine.insn_detail(insn).ok()?;
    let arch = detail.arch_detail();
    let arm = arch.arm()?;
    let operands: Vec<ArmOperand> = arm.operands().collect();
    let id = ArmInsn::from(insn.id().0);
    let is_conditional = !matches!(arm.cc(), ArmCC::ARM_CC_AL | ArmCC::ARM_CC_INVALID);
    let mut effects = operand_effects(id, &operands)?;
    // The library does not say so of comparisons.
    let compares = matches!(
        id,
        ArmInsn::ARM_INS_CMP | ArmInsn::ARM_INS_CMN | ArmInsn::ARM_INS_TST | ArmInsn::ARM_INS_TEQ
    );
    if arm.update_flags() || compares {
        effects.replaces |= replaced_flags(id);
    }
    if is_conditional {
        effects.uses |= CONDITION;
        effects.replaces = 0;
    }
    Some(effects)
}

/// The effects by the operands; `None` for an instruction that is not listed.
fn operand_effects(id: ArmInsn, operands: &[ArmOperand]) -> Option<Effects> {
    use ArmInsn::*;
    let from = |first: usize| all(operands.get(first..).unwrap_or_default());
    let (results, implicit): (usize, Effects) = match id {
        // A result of the other operands; with two operands the first is one of them.
        ARM_INS_ADD | ARM_INS_ADDW | ARM_INS_SUB | ARM_INS_SUBW | ARM_INS_RSB | ARM_INS_AND
        | ARM_INS_ORR | ARM_INS_ORN | ARM_INS_EOR | ARM_INS_BIC | ARM_INS_LSL | ARM_INS_LSR
        | ARM_INS_ASR | ARM_INS_ROR | ARM_INS_MUL | ARM_INS_SDIV | ARM_INS_UDIV => {
            (usize::from(operands.len() > 2), of(0, 0))
        }
        ARM_INS_ADC | ARM_INS_SBC => (usize::from(operands.len() > 2), of(C, 0)),
        ARM_INS_MLA | ARM_INS_MLS | ARM_INS_UBFX | ARM_INS_SBFX => (1, of(0, 0)),
        ARM_INS_MOV | ARM_INS_MOVW | ARM_INS_MVN | ARM_INS_UXTB | ARM_INS_UXTH | ARM_INS_SXTB
        | ARM_INS_SXTH | ARM_INS_CLZ | ARM_INS_RBIT | ARM_INS_REV | ARM_INS_REV16 | ARM_INS_ADR => {
            (1, of(0, 0))
        }
        ARM_INS_LDR | ARM_INS_LDRB | ARM_INS_LDRH | ARM_INS_LDRSB | ARM_INS_LDRSH => (1, of(0, 0)),
        ARM_INS_LDRD | ARM_INS_UMULL | ARM_INS_SMULL => (2, of(0, 0)),
        ARM_INS_POP => (operands.len(), of(SP, 0)),
        ARM_INS_PUSH | ARM_INS_VPUSH | ARM_INS_VPOP => (0, of(SP, 0)),
        ARM_INS_BL => (0, of(0, LR)),
        ARM_INS_BLX => (0, of(0, LR)),
        ARM_INS_IT => (0, of(CONDITION, 0)),
        // The base, then the registers of the list.
        ARM_INS_LDM | ARM_INS_LDMDB => {
            let (base, listed) = (all(operands.get(..1)?), from(1));
            return Some(of(base, listed & !base));
        }
        // Everything that they name is used; they replace flags at most.
        ARM_INS_STR | ARM_INS_STRB | ARM_INS_STRH | ARM_INS_STRD | ARM_INS_STM | ARM_INS_STMDB
        | ARM_INS_CMP | ARM_INS_CMN | ARM_INS_TST | ARM_INS_TEQ | ARM_INS_B | ARM_INS_BX
        | ARM_INS_CBZ | ARM_INS_CBNZ | ARM_INS_TBB | ARM_INS_TBH | ARM_INS_NOP | ARM_INS_DMB
        | ARM_INS_DSB | ARM_INS_ISB | ARM_INS_MOVT | ARM_INS_BFI | ARM_INS_BFC | ARM_INS_UMLAL
        | ARM_INS_SMLAL | ARM_INS_VLDR | ARM_INS_VSTR => (0, of(0, 0)),
        _ => return None,
    };
    let replaced = all(operands.get(..results)?);
    Some(of(
        from(results) | implicit.uses,
        replaced | implicit.replaces,
    ))
}

/// The flags that an instruction replaces which sets flags. A shift keeps C if it shifts by zero.
fn replaced_flags(id: ArmInsn) -> Registers {
    use ArmInsn::*;
    match id {
        ARM_INS_CMP | ARM_INS_CMN | ARM_INS_ADD | ARM_INS_SUB | ARM_INS_RSB | ARM_INS_ADC
        | ARM_INS_SBC => CONDITION,
        ARM_INS_TST | ARM_INS_TEQ | ARM_INS_MOV | ARM_INS_MVN | ARM_INS_AND | ARM_INS_ORR
        | ARM_INS_EOR | ARM_INS_BIC | ARM_INS_LSL | ARM_INS_LSR | ARM_INS_ASR | ARM_INS_MUL => {
            N | Z
        }
        _ => 0,
    }
}

fn of(uses: Registers, replaces: Registers) -> Effects {
    Effects { uses, replaces }
}

/// All registers that operands name.
fn all(operands: &[ArmOperand]) -> Registers {
    operands.iter().map(named).fold(0, |set, more| set | more)
}

fn named(operand: &ArmOperand) -> Registers {
    let by_shift = match operand.shift {
        ArmShift::AsrReg(register)
        | ArmShift::LslReg(register)
        | ArmShift::LsrReg(register)
        | ArmShift::RorReg(register) => number(register),
        ArmShift::Rrx(_) | ArmShift::RrxReg(_) => ALL,
        _ => 0,
    };
    by_shift
        | match &operand.op_type {
            ArmOperandType::Reg(register) => number(*register),
            ArmOperandType::Mem(memory) => number(memory.base()) | number(memory.index()),
            ArmOperandType::SysReg(_) => ALL,
            _ => 0,
        }
}

/// The register as a set; none for a floating-point register or none.
fn number(register: RegId) -> Registers {
    let id = u32::from(register.0);
    match id {
        ArmReg::ARM_REG_R0..=ArmReg::ARM_REG_R12 => 1 << (id - ArmReg::ARM_REG_R0),
        ArmReg::ARM_REG_SP => SP,
        ArmReg::ARM_REG_LR => LR,
        ArmReg::ARM_REG_PC => 1 << 15,
        ArmReg::ARM_REG_D0..=ArmReg::ARM_REG_D31 | ArmReg::ARM_REG_S0..=ArmReg::ARM_REG_S31 => 0,
        0 => 0,
        _ => ALL,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn effects(halves: [u16; 2]) -> Effects {
        let [first, second] = halves.map(u16::to_le_bytes);
        let bytes = [first[0], first[1], second[0], second[1]];
        Decoder::default().effects(0x0800_8000, || bytes)
    }

    fn set(numbers: &[u32]) -> Registers {
        numbers.iter().map(|number| 1 << number).sum()
    }

    // Encodings of DDI 0403E, chapter A7.7.
    #[test]
    fn a_register_is_used_or_replaced_as_the_manual_says() {
        let cases = [
            (
                "adds r0, r1, r2",
                [0x1888, 0],
                set(&[1, 2]),
                set(&[0]) | CONDITION,
            ),
            ("add r0, r9", [0x4448, 0], set(&[0, 9]), 0),
            ("adds r3, #1", [0x3301, 0], set(&[3]), CONDITION),
            ("movs r4, #0", [0x2400, 0], 0, set(&[4]) | N | Z),
            ("mov r8, r1", [0x4688, 0], set(&[1]), set(&[8])),
            (
                "muls r0, r1, r0",
                [0x4348, 0],
                set(&[0, 1]),
                set(&[0]) | N | Z,
            ),
            ("lsls r0, r1", [0x4088, 0], set(&[0, 1]), N | Z),
            ("adcs r0, r1", [0x4148, 0], set(&[0, 1]) | C, CONDITION),
            ("cmp r2, #0", [0x2a00, 0], set(&[2]), CONDITION),
            ("beq", [0xd000, 0], CONDITION, 0),
            ("ite eq", [0xbf0c, 0], CONDITION, 0),
            ("ldr r1, [r4, r0]", [0x5821, 0], set(&[0, 4]), set(&[1])),
            ("ldr.w r0, [r0], #4", [0xf850, 0x0b04], set(&[0]), set(&[0])),
            ("str r1, [r4]", [0x6021, 0], set(&[1, 4]), 0),
            (
                "ldrd r0, r1, [r2, #8]",
                [0xe9d2, 0x0102],
                set(&[2]),
                set(&[0, 1]),
            ),
            (
                "strd r0, r1, [r2, #8]",
                [0xe9c2, 0x0102],
                set(&[0, 1, 2]),
                0,
            ),
            (
                "ldmia r1!, {r1, r4}",
                [0xe891, 0x0012],
                set(&[1]),
                set(&[4]),
            ),
            ("push {r4, lr}", [0xb510, 0], set(&[4]) | LR | SP, 0),
            ("pop {r4, pc}", [0xbd10, 0], SP, set(&[4, 15])),
            ("bl", [0xf000, 0xf800], 0, LR),
            ("blx r3", [0x4798, 0], set(&[3]), LR),
            (
                "umull r0, r1, r2, r3",
                [0xfba2, 0x0103],
                set(&[2, 3]),
                set(&[0, 1]),
            ),
            (
                "umlal r0, r1, r2, r3",
                [0xfbe2, 0x0103],
                set(&[0, 1, 2, 3]),
                0,
            ),
            ("bfi r0, r1, #0, #4", [0xf361, 0x0003], set(&[0, 1]), 0),
            ("movt r0, #1", [0xf2c0, 0x0001], set(&[0]), 0),
            (
                "eor.w r3, r2, r3, ror #1",
                [0xea82, 0x0373],
                set(&[2, 3]),
                set(&[3]),
            ),
            ("add.w r0, r1, r2, rrx", [0xeb01, 0x0032], ALL, set(&[0])),
            ("mrs r0, apsr", [0xf3ef, 0x8000], ALL, 0),
            ("svc #0", [0xdf00, 0], ALL, 0),
            ("strex r0, r1, [r2]", [0xe842, 0x1000], ALL, 0),
        ];
        for (name, halves, uses, replaces) in cases {
            assert_eq!(effects(halves), Effects { uses, replaces }, "{name}");
        }
    }
}
