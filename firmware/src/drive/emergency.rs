//! Faults as EMCY messages.

use canopen::{Emergency, ErrorCode, register};

use crate::{
    faults::{Fault, TABLE},
    health::Warning,
};

/// The error code of a warning: it is of the manufacturer (CiA 301, table 26).
const WARNING: ErrorCode = ErrorCode(0xFF10);

/// Error codes by number, separate from the table so that the board's program has no texts.
const CODES: [u16; TABLE.len()] = {
    let mut codes = [0; TABLE.len()];
    let mut at = 0;
    while at < codes.len() {
        codes[at] = TABLE[at].error_code;
        at += 1;
    }
    codes
};

/// The error code of a fault, object 603Fh.
pub(super) fn code(fault: Fault) -> ErrorCode {
    let at = usize::from(fault.number()).wrapping_sub(1);
    ErrorCode(CODES.get(at).copied().unwrap_or(0))
}

/// The instance of a fault: its number, offset from those of nodes and PDOs with the same codes.
pub(super) fn instance(fault: Fault) -> u8 {
    0x80 | fault.number() as u8
}

/// The message of a fault: the instance has its number, the information the control period in which
/// it was latched.
pub(super) fn of(fault: Fault, tick: u32) -> Emergency {
    let code = code(fault);
    Emergency {
        code,
        register: register_of(code),
        instance: instance(fault),
        information: tick.to_le_bytes(),
    }
}

/// The message of a warning of the health; nothing acts by it.
pub(super) fn of_warning(warning: Warning) -> Emergency {
    Emergency {
        code: WARNING,
        register: register::MANUFACTURER,
        instance: 0xC0 | warning as u8,
        information: [0; 4],
    }
}

/// The bit of the error register by the class of the code (CiA 301, tables 25 and 26).
const fn register_of(code: ErrorCode) -> u8 {
    match code.0 >> 12 {
        2 => register::CURRENT,
        3 => register::VOLTAGE,
        4 => register::TEMPERATURE,
        8 if code.0 >> 8 == 0x81 => register::COMMUNICATION,
        7 | 8 => register::PROFILE,
        _ => register::GENERIC,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_has_its_code_and_the_bit_of_its_class() {
        for row in TABLE {
            assert_eq!(code(row.fault).0, row.error_code, "{:?}", row.fault);
        }
        let bits = |fault| of(fault, 0).register;
        assert_eq!(bits(Fault::OverCurrent), register::CURRENT);
        assert_eq!(bits(Fault::UnderVoltage), register::VOLTAGE);
        assert_eq!(bits(Fault::OverTemperature), register::TEMPERATURE);
        assert_eq!(bits(Fault::CommandTimeout), register::COMMUNICATION);
        assert_eq!(bits(Fault::FollowingError), register::PROFILE);
        assert_eq!(bits(Fault::LoopOverrun), register::GENERIC);
    }
}
