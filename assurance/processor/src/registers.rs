//! The registers of both processors.

use virtual_board::processor::Processor;

use crate::unicorn::{Host, Register, Unicorn};

/// IT[7:0] in the program status register: bits 26:25 and 15:10 (DDI 0403E, B1.4.2).
const IT_BITS: u32 = 0x0600_fc00;

/// Number of the exception in the program status register.
const EXCEPTION_BITS: u32 = 0x1ff;

/// CONTROL.FPCA: the floating-point registers are in use.
pub const FPCA: u32 = 1 << 2;

/// ITSTATE of a program status register.
pub fn it_of(xpsr: u32) -> u8 {
    ((xpsr >> 25 & 0b11) | (xpsr >> 10 & 0x3f) << 2) as u8
}

/// The program status register with this ITSTATE.
pub fn with_it(xpsr: u32, it: u8) -> u32 {
    let it = u32::from(it);
    xpsr & !IT_BITS | (it & 0b11) << 25 | (it >> 2) << 10
}

/// Whether a condition is met with this program status (DDI 0403E, A7.3.1).
pub fn holds(condition: u8, xpsr: u32) -> bool {
    let [n, z, c, v] = [31, 30, 29, 28].map(|bit| xpsr >> bit & 1 == 1);
    let is_met = match condition >> 1 {
        0b000 => z,
        0b001 => c,
        0b010 => n,
        0b011 => v,
        0b100 => c && !z,
        0b101 => n == v,
        0b110 => n == v && !z,
        _ => return true,
    };
    is_met != (condition & 1 == 1)
}

/// The registers of a processor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    /// R0 to R15.
    pub core: [u32; 16],
    /// Program status.
    pub xpsr: u32,
    /// S0 to S31.
    pub single: [u32; 32],
    /// Floating-point status.
    pub fpscr: u32,
    /// PRIMASK, BASEPRI, FAULTMASK, CONTROL.
    pub masks: [u32; 4],
}

/// Number of the first register of each group, as GDB numbers them on the board.
const XPSR: usize = 16;
const DOUBLE: usize = 17;
const FPSCR: usize = 33;
const MASKS: usize = 36;

const CORE: [Register; 16] = {
    let mut all = [Register::core(0); 16];
    let mut number = 0;
    while number < 16 {
        all[number] = Register::core(number as u8);
        number += 1;
    }
    all
};

/// S0 to S31.
pub const SINGLE: [Register; 32] = {
    let mut all = [Register::single(0); 32];
    let mut number = 0;
    while number < 32 {
        all[number] = Register::single(number as u8);
        number += 1;
    }
    all
};

const MASK: [Register; 4] = [
    Register::PRIMASK,
    Register::BASEPRI,
    Register::FAULTMASK,
    Register::CONTROL,
];

impl Registers {
    /// Those of the emulated board.
    pub fn of_board(core: &dyn Processor) -> Self {
        let bytes = |number| core.gdb_register(number).unwrap_or_default();
        let word = |number| {
            let bytes: [u8; 4] = bytes(number).try_into().unwrap_or_default();
            u32::from_le_bytes(bytes)
        };
        let mut single = [0; 32];
        for (number, pair) in single.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let both: [u8; 8] = bytes(DOUBLE + number).try_into().unwrap_or_default();
            let both = u64::from_le_bytes(both);
            *pair = [both as u32, (both >> 32) as u32];
        }
        Self {
            core: std::array::from_fn(word),
            xpsr: word(XPSR),
            single,
            fpscr: word(FPSCR),
            masks: std::array::from_fn(|number| word(MASKS + number)),
        }
    }

    /// Those of the second emulator.
    pub fn of_second<H: Host>(second: &Unicorn<H>) -> Self {
        let [xpsr, fpscr] = second.read([Register::XPSR, Register::FPSCR]);
        let mut masks = second.read(MASK);
        // The other bits are of the security extension, which a Cortex-M4 does not have.
        masks[3] &= 0b111;
        Self {
            core: second.read(CORE),
            xpsr,
            single: second.read(SINGLE),
            fpscr,
            masks,
        }
    }

    /// Writes them into the second emulator.
    pub fn write<H: Host>(&self, second: &mut Unicorn<H>) {
        second.write(std::array::from_fn::<_, 4, _>(|n| (MASK[n], self.masks[n])));
        second.write(std::array::from_fn::<_, 32, _>(|n| {
            (SINGLE[n], self.single[n])
        }));
        let status = [
            (Register::FPSCR, self.fpscr),
            (Register::XPSR, with_it(self.xpsr, 0)),
        ];
        second.write(status);
        second.write(std::array::from_fn::<_, 16, _>(|n| (CORE[n], self.core[n])));
    }

    /// Number of the exception.
    pub fn exception(&self) -> u32 {
        self.xpsr & EXCEPTION_BITS
    }

    /// The program status register with this number of an exception.
    pub fn with_exception(xpsr: u32, number: u32) -> u32 {
        xpsr & !EXCEPTION_BITS | number
    }

    /// The first register that differs from the board's, with both values.
    pub fn difference(&self, board: &Self) -> Option<String> {
        let name = |number: usize| match number {
            0..16 => format!("r{number}"),
            16 => "xpsr".into(),
            17..49 => format!("s{}", number - 17),
            49 => "fpscr".into(),
            number => ["primask", "basepri", "faultmask", "control"][number - 50].into(),
        };
        let all = |registers: &Self| {
            let core = registers.core.into_iter().chain([registers.xpsr]);
            let float = registers.single.into_iter().chain([registers.fpscr]);
            core.chain(float).chain(registers.masks).collect::<Vec<_>>()
        };
        let (found, expected) = (all(self), all(board));
        let number = found.iter().zip(&expected).position(|(a, b)| a != b)?;
        let (found, expected) = (found[number], expected[number]);
        Some(format!(
            "{} is {found:08x}, on the board {expected:08x}",
            name(number)
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_of_a_block_is_kept_in_the_status_register() {
        for it in 0..=u8::MAX {
            assert_eq!(it_of(with_it(0xffff_ffff, it)), it);
            assert_eq!(with_it(0x6100_0048, it) & !IT_BITS, 0x6100_0048);
        }
    }
}
