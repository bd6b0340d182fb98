//! What the analysis needs of an instruction of the Cortex-M4F.

use capstone::arch::DetailsArchInsn as _;
use capstone::arch::arm::{ArmCC, ArmInsn, ArmOperandType, ArmReg};
use capstone::{Capstone, Insn};

use crate::time::LINE_BYTES;

/// Where the processor continues.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Flow {
    /// At the next instruction.
    Next,
    /// At an address, in this function or as a tail call of another one.
    Jump(u64),
    /// At an address or at the next instruction.
    Branch(u64),
    /// In another function, then at the next instruction.
    Call(u64),
    /// Behind the call of the function, or at the next instruction if it is conditional.
    Return { is_conditional: bool },
    /// At one of the targets of the table that follows; the size of its entries is in bytes.
    Table { entry: u64 },
    /// Nowhere: an instruction that is never executed.
    Never,
}

impl Flow {
    /// Whether the next instruction can be executed after it.
    pub fn continues(&self) -> bool {
        match self {
            Self::Next | Self::Branch(_) | Self::Call(_) => true,
            Self::Return { is_conditional } => *is_conditional,
            Self::Jump(_) | Self::Table { .. } | Self::Never => false,
        }
    }
}

/// An instruction.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instruction {
    pub address: u64,
    pub size: u64,
    pub flow: Flow,
    /// Bytes by which it moves the stack pointer down.
    pub stack: u64,
    /// Maximum cycles without wait states (Cortex-M4 Technical Reference Manual, tables 3-1 and
    /// 7-1).
    pub cycles: u64,
    /// Lines of the flash that are read for it, in sixteenths, at the most: its share of a line,
    /// the lines at both ends of the code up to the next branch, and its loads.
    pub lines_16: u64,
    /// Instructions after it that it makes conditional: an IT block, which begins with it.
    pub begins_block: u64,
    /// The registers of [`ARGUMENTS`] that it may write, and the constant if it is one.
    pub assigned: Vec<(u8, Option<u64>)>,
}

/// Registers of arguments, and their numbers. A call may change them.
const ARGUMENTS: [(u8, u32); 2] = [(1, ArmReg::ARM_REG_R1), (2, ArmReg::ARM_REG_R2)];

/// Cycles to refill the pipeline after a branch: 1 to 3 (section 3.3.1).
const REFILL: u64 = 3;
/// Greatest size by which an alignment moves the stack pointer, bytes.
const ALIGNMENT: u64 = 16;

/// Code of N bytes that begins at an even address lies in (N + 29)/16 lines at the most.
const ENDS: u64 = 2 * LINE_BYTES - 3;

impl Instruction {
    /// Decodes an instruction, of an IT block or not; the error names what the analysis does not
    /// cover.
    pub fn decode(engine: &Capstone, insn: &Insn<'_>, in_block: bool) -> Result<Self, String> {
        let detail = engine
            .insn_detail(insn)
            .map_err(|error| error.to_string())?;
        let detail = detail.arch_detail();
        let detail = detail.arm().ok_or("not an instruction of Arm")?;
        let operands: Vec<_> = detail.operands().map(|operand| operand.op_type).collect();
        let decoded = Decoded {
            id: ArmInsn::from(insn.id().0),
            is_conditional: in_block
                || !matches!(detail.cc(), ArmCC::ARM_CC_AL | ArmCC::ARM_CC_INVALID),
            writes_back: detail.writeback(),
            operands,
        };
        let flow = decoded.flow()?;
        let ends = if flow == Flow::Next { 0 } else { ENDS };
        Ok(Self {
            address: insn.address(),
            size: insn.bytes().len() as u64,
            stack: decoded.stack()?,
            cycles: decoded.cycles(&flow),
            lines_16: insn.bytes().len() as u64 + ends + LINE_BYTES * decoded.loads(),
            begins_block: decoded.begins_block(insn.bytes()),
            assigned: decoded.assigned(&flow),
            flow,
        })
    }

    /// Whether it may write a register of an argument, and the constant if it is one.
    pub fn assigned(&self, register: u8) -> Option<Option<u64>> {
        let assigned = self.assigned.iter().find(|(number, _)| *number == register);
        assigned.map(|(_, constant)| *constant)
    }
}

struct Decoded {
    id: ArmInsn,
    is_conditional: bool,
    writes_back: bool,
    operands: Vec<ArmOperandType>,
}

const SP: u32 = ArmReg::ARM_REG_SP;
const PC: u32 = ArmReg::ARM_REG_PC;
const LR: u32 = ArmReg::ARM_REG_LR;

impl Decoded {
    fn register(&self, at: usize) -> Option<u32> {
        match self.operands.get(at) {
            Some(ArmOperandType::Reg(register)) => Some(u32::from(register.0)),
            _ => None,
        }
    }

    fn immediate(&self, at: usize) -> Option<i64> {
        match self.operands.get(at) {
            Some(ArmOperandType::Imm(value)) => Some(i64::from(*value)),
            _ => None,
        }
    }

    fn target(&self) -> Result<u64, String> {
        self.operands
            .iter()
            .rev()
            .find_map(|operand| match operand {
                ArmOperandType::Imm(value) => Some(u64::from(*value as u32)),
                _ => None,
            })
            .ok_or_else(|| "a branch to an address in a register".into())
    }

    /// Number of registers in a list, with those of a base register in front.
    fn listed(&self) -> u64 {
        self.operands.len() as u64
    }

    fn writes(&self, register: u32) -> bool {
        (0..self.operands.len()).any(|at| self.register(at) == Some(register))
    }

    /// Whether this register has the address of its memory.
    fn has_base(&self, register: u32) -> bool {
        self.operands.iter().any(|operand| match operand {
            ArmOperandType::Mem(memory) => u32::from(memory.base().0) == register,
            _ => false,
        })
    }

    fn flow(&self) -> Result<Flow, String> {
        use ArmInsn::*;
        Ok(match self.id {
            ARM_INS_BL => Flow::Call(self.target()?),
            ARM_INS_B if self.is_conditional => Flow::Branch(self.target()?),
            ARM_INS_B => Flow::Jump(self.target()?),
            ARM_INS_CBZ | ARM_INS_CBNZ => Flow::Branch(self.target()?),
            ARM_INS_BX if self.register(0) == Some(LR) => self.returns(),
            ARM_INS_BX | ARM_INS_BLX => return Err("a call by pointer".into()),
            ARM_INS_TBB => Flow::Table { entry: 1 },
            ARM_INS_TBH => Flow::Table { entry: 2 },
            // The disassembler names `udf #254` a trap.
            ARM_INS_UDF | ARM_INS_TRAP if !self.is_conditional => Flow::Never,
            ARM_INS_POP | ARM_INS_LDM if self.writes(PC) => self.returns(),
            ARM_INS_LDR if self.register(0) == Some(PC) => self.loads_pc()?,
            ARM_INS_MOV | ARM_INS_ADD if self.register(0) == Some(PC) => {
                return Err("a jump to an address in a register".into());
            }
            _ => Flow::Next,
        })
    }

    fn returns(&self) -> Flow {
        Flow::Return {
            is_conditional: self.is_conditional,
        }
    }

    fn loads_pc(&self) -> Result<Flow, String> {
        match self.operands.get(1) {
            Some(ArmOperandType::Mem(memory)) if u32::from(memory.base().0) == SP => {
                Ok(self.returns())
            }
            _ => Err("a jump to an address in memory".into()),
        }
    }

    fn stack(&self) -> Result<u64, String> {
        use ArmInsn::*;
        let is_sp = self.register(0) == Some(SP);
        Ok(match self.id {
            ARM_INS_PUSH => 4 * self.listed(),
            ARM_INS_STMDB if is_sp && self.writes_back => 4 * (self.listed() - 1),
            ARM_INS_VPUSH => 8 * self.listed(),
            ARM_INS_VSTMDB if is_sp => 8 * (self.listed() - 1),
            ARM_INS_STR | ARM_INS_STRD if self.writes_back => match self.operands.last() {
                Some(ArmOperandType::Mem(memory)) if u32::from(memory.base().0) == SP => {
                    u64::from((-memory.disp()).max(0) as u32)
                }
                _ => 0,
            },
            ARM_INS_SUB if is_sp => {
                let last = self.operands.len() - 1;
                let size = self
                    .immediate(last)
                    .ok_or("a stack frame of variable size")?;
                size.unsigned_abs()
            }
            // A pointer that was computed from the stack pointer, which `bfc` has aligned, or from
            // the frame pointer, which gives stack back.
            ARM_INS_MOV if is_sp => ALIGNMENT,
            _ => 0,
        })
    }

    fn cycles(&self, flow: &Flow) -> u64 {
        use ArmInsn::*;
        let own = match self.id {
            // 2 for a single load, 1 + N for N registers.
            ARM_INS_POP | ARM_INS_PUSH | ARM_INS_LDM | ARM_INS_STM | ARM_INS_STMDB
            | ARM_INS_LDMDB => 1 + self.listed(),
            ARM_INS_VPUSH | ARM_INS_VPOP | ARM_INS_VLDMIA | ARM_INS_VSTMIA | ARM_INS_VSTMDB
            | ARM_INS_VLDMDB => 1 + 2 * self.listed(),
            ARM_INS_LDR | ARM_INS_LDRB | ARM_INS_LDRH | ARM_INS_LDRSB | ARM_INS_LDRSH
            | ARM_INS_STR | ARM_INS_STRB | ARM_INS_STRH | ARM_INS_VLDR | ARM_INS_VSTR => 3,
            ARM_INS_LDRD | ARM_INS_STRD | ARM_INS_TBB | ARM_INS_TBH => 3,
            ARM_INS_UDIV | ARM_INS_SDIV => 12,
            ARM_INS_VDIV | ARM_INS_VSQRT => 14,
            ARM_INS_VMLA | ARM_INS_VMLS | ARM_INS_VFMA | ARM_INS_VFMS | ARM_INS_VFNMS
            | ARM_INS_VFNMA | ARM_INS_VNMLA | ARM_INS_VNMLS => 3,
            ARM_INS_VMOV => 2,
            // Barriers wait for the write buffer.
            ARM_INS_DSB | ARM_INS_DMB | ARM_INS_ISB => 4,
            _ => 1,
        };
        own + if *flow == Flow::Next { 0 } else { REFILL }
    }

    /// Words that it loads, not of the stack.
    fn loads(&self) -> u64 {
        use ArmInsn::*;
        match self.id {
            _ if self.has_base(SP) => 0,
            ARM_INS_LDM | ARM_INS_LDMDB => self.listed() - 1,
            ARM_INS_LDR | ARM_INS_LDRB | ARM_INS_LDRH | ARM_INS_LDRSB | ARM_INS_LDRSH
            | ARM_INS_LDREX | ARM_INS_LDREXB | ARM_INS_VLDR | ARM_INS_TBB | ARM_INS_TBH => 1,
            ARM_INS_LDRD => 2,
            ARM_INS_VLDMIA => 2 * self.listed(),
            _ => 0,
        }
    }

    /// The last bit that is set ends the mask of an IT (DDI 0403E, A7.7.38).
    fn begins_block(&self, bytes: &[u8]) -> u64 {
        match (self.id, bytes) {
            (ArmInsn::ARM_INS_IT, [mask, ..]) => 4 - u64::from(mask.trailing_zeros().min(4)),
            _ => 0,
        }
    }

    /// A register that is an operand may be written.
    fn assigned(&self, flow: &Flow) -> Vec<(u8, Option<u64>)> {
        use ArmInsn::*;
        let is_constant = !self.is_conditional && matches!(self.id, ARM_INS_MOV | ARM_INS_MOVW);
        let constant = self.immediate(1).filter(|_| is_constant);
        let constant = constant.and_then(|value| u64::try_from(value).ok());
        let may_write = |register| {
            matches!(flow, Flow::Call(_))
                || self.writes(register)
                || self.writes_back && self.has_base(register)
        };
        let assigned = ARGUMENTS
            .into_iter()
            .filter(|(_, register)| may_write(*register));
        assigned.map(|(number, _)| (number, constant)).collect()
    }
}
