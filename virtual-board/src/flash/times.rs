//! Durations of operations (STM32F427 data sheet DS9405, table "Flash memory programming").

/// Durations of erase operations, ms, by parallelism: x8, x16, x32.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EraseTimes {
    /// A sector of 16 KiB.
    pub small_ms: [u64; 3],
    /// A sector of 64 KiB.
    pub medium_ms: [u64; 3],
    /// A sector of 128 KiB.
    pub large_ms: [u64; 3],
    /// A bank, or both.
    pub bank_ms: [u64; 3],
}

/// Durations of all operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FlashTimes {
    /// A byte, half-word, word or double word, ns.
    pub program_ns: u64,
    /// Erase operations.
    pub erase: EraseTimes,
}

const MS: u64 = 1_000_000;

impl FlashTimes {
    /// The data sheet's typical values.
    pub const TYPICAL: Self = Self {
        program_ns: 16_000,
        erase: EraseTimes {
            small_ms: [400, 300, 250],
            medium_ms: [1_200, 700, 550],
            large_ms: [2_000, 1_300, 1_000],
            bank_ms: [16_000, 11_000, 8_000],
        },
    };

    /// The data sheet's typical values, but for erase operations of a millisecond: a program that
    /// waits for an erase executes a hundred million instructions meanwhile.
    pub const SHORT_ERASE: Self = Self {
        program_ns: Self::TYPICAL.program_ns,
        erase: EraseTimes {
            small_ms: [1; 3],
            medium_ms: [1; 3],
            large_ms: [1; 3],
            bank_ms: [1; 3],
        },
    };

    /// Duration of the erase of a sector of this size at this parallelism, `CR.PSIZE`, ns.
    pub(super) fn sector_ns(&self, size: u64, parallelism: usize) -> u64 {
        let row = match size >> 10 {
            16 => self.erase.small_ms,
            64 => self.erase.medium_ms,
            _ => self.erase.large_ms,
        };
        row[parallelism.min(2)] * MS
    }

    pub(super) fn bank_ns(&self, parallelism: usize) -> u64 {
        self.erase.bank_ms[parallelism.min(2)] * MS
    }
}
