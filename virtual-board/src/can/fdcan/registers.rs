//! Offsets and bits of the registers (RM0433, chapter 56).

/// Offsets, bytes.
pub mod offset {
    pub const CREL: u64 = 0x00;
    pub const TEST: u64 = 0x10;
    pub const CCCR: u64 = 0x18;
    pub const NBTP: u64 = 0x1c;
    pub const ECR: u64 = 0x40;
    pub const PSR: u64 = 0x44;
    pub const IR: u64 = 0x50;
    pub const IE: u64 = 0x54;
    pub const ILS: u64 = 0x58;
    pub const ILE: u64 = 0x5c;
    pub const GFC: u64 = 0x80;
    pub const SIDFC: u64 = 0x84;
    pub const XIDFC: u64 = 0x88;
    pub const RXF0C: u64 = 0xa0;
    pub const RXF0S: u64 = 0xa4;
    pub const RXF0A: u64 = 0xa8;
    pub const RXESC: u64 = 0xbc;
    pub const TXBC: u64 = 0xc0;
    pub const TXESC: u64 = 0xc8;
    pub const TXBRP: u64 = 0xcc;
    pub const TXBAR: u64 = 0xd0;
    pub const TXBCR: u64 = 0xd4;
    pub const TXBTO: u64 = 0xd8;
    pub const TXBCF: u64 = 0xdc;
    pub const TXBTIE: u64 = 0xe0;
    pub const TXBCIE: u64 = 0xe4;
}

/// Bits of `CCCR`.
pub mod cccr {
    pub const INIT: u32 = 1;
    pub const CCE: u32 = 1 << 1;
    pub const MON: u32 = 1 << 5;
    pub const DAR: u32 = 1 << 6;
    pub const TEST: u32 = 1 << 7;
    pub const PXHD: u32 = 1 << 12;
    /// What the model has: the rest is CAN FD, time stamps, and clock stop.
    pub const MODELLED: u32 = INIT | CCE | MON | DAR | TEST | PXHD;
}

/// `TEST.LBCK`.
pub const LBCK: u32 = 1 << 4;

/// Flags of `IR`.
pub mod ir {
    pub const RF0N: u32 = 1;
    pub const RF0F: u32 = 1 << 2;
    pub const RF0L: u32 = 1 << 3;
    pub const TC: u32 = 1 << 9;
    pub const TCF: u32 = 1 << 10;
    pub const EP: u32 = 1 << 23;
    pub const EW: u32 = 1 << 24;
    pub const BO: u32 = 1 << 25;
    pub const PEA: u32 = 1 << 27;
}

/// `PSR.LEC`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LastError {
    None = 0,
    Stuff = 1,
    Form = 2,
    Acknowledge = 3,
    BitRecessive = 4,
    BitDominant = 5,
    NoChange = 7,
}

/// Release of the core.
pub const RELEASE: u32 = 0x3214_1218;
