//! Writes that are refused, and their error numbers.

use crate::memory::{Memory, Refusal};
use crate::table::{Field, Register};
use crate::tables::x;

/// Expired bus watchdog.
const EXPIRED: i32 = -1;

/// Error number of a status packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Error {
    /// The instruction failed.
    Result = 1,
    /// Not an instruction, or an action without a registered write.
    Instruction = 2,
    /// A value out of its range.
    DataRange = 4,
    /// A part of a register.
    DataLength = 5,
    /// A value beyond the limit in another register.
    DataLimit = 6,
    /// No register, or one that may not be written now.
    Access = 7,
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Access => Self::Access,
            Refusal::Length => Self::DataLength,
            Refusal::Range => Self::DataRange,
            Refusal::Limit => Self::DataLimit,
        }
    }
}

/// Whether a register may have this value now.
pub(super) fn allows(memory: &Memory, register: &Register, value: i32) -> Result<(), Refusal> {
    let is_goal = [
        x::GOAL_PWM,
        x::GOAL_CURRENT,
        x::GOAL_VELOCITY,
        x::GOAL_POSITION,
    ]
    .contains(&register.field);
    let has_expired = memory.get(x::BUS_WATCHDOG) == EXPIRED;
    let within = |bound: Field| value.abs() <= memory.get(bound);
    let is_allowed = match register.field {
        _ if register.is_eeprom && memory.get(x::TORQUE_ENABLE) != 0 => {
            return Err(Refusal::Access);
        }
        _ if is_goal && has_expired => return Err(Refusal::Range),
        x::BUS_WATCHDOG if value < 0 || has_expired && value != 0 => return Err(Refusal::Range),
        x::OPERATING_MODE if !matches!(value, 0 | 1 | 3 | 4 | 5 | 16) => {
            return Err(Refusal::Range);
        }
        // Only a restart ends a shutdown.
        x::TORQUE_ENABLE
            if value != 0
                && memory.get(x::HARDWARE_ERROR_STATUS) & memory.get(x::SHUTDOWN) != 0 =>
        {
            return Err(Refusal::Access);
        }
        x::GOAL_PWM => within(x::PWM_LIMIT),
        x::GOAL_CURRENT => within(x::CURRENT_LIMIT),
        x::GOAL_VELOCITY => within(x::VELOCITY_LIMIT),
        x::GOAL_POSITION if memory.get(x::OPERATING_MODE) == 3 => {
            (memory.get(x::MIN_POSITION_LIMIT)..=memory.get(x::MAX_POSITION_LIMIT)).contains(&value)
        }
        _ => true,
    };
    if is_allowed {
        Ok(())
    } else {
        Err(Refusal::Limit)
    }
}
