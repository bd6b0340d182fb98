//! Bits of controlword 6040h and statusword 6041h.

use super::Cia402State;

/// Bits of the controlword.
pub mod controlword {
    /// Switch on.
    pub const SWITCH_ON: u16 = 1 << 0;
    /// Enable voltage.
    pub const ENABLE_VOLTAGE: u16 = 1 << 1;
    /// Quick stop; active low.
    pub const QUICK_STOP: u16 = 1 << 2;
    /// Enable operation.
    pub const ENABLE_OPERATION: u16 = 1 << 3;
    /// Profile position: new set-point; rising edge.
    pub const NEW_SET_POINT: u16 = 1 << 4;
    /// Homing: starts at the rising edge, and is interrupted by the falling one.
    pub const START_HOMING: u16 = 1 << 4;
    /// Interpolated position: interpolates between the points of the buffer.
    pub const INTERPOLATE: u16 = 1 << 4;
    /// Profile position: change set immediately, instead of after the active set-point.
    pub const CHANGE_SET_IMMEDIATELY: u16 = 1 << 5;
    /// Profile position: target is relative to the previous one.
    pub const RELATIVE: u16 = 1 << 6;
    /// Fault reset; rising edge.
    pub const FAULT_RESET: u16 = 1 << 7;
    /// Halt.
    pub const HALT: u16 = 1 << 8;
}

/// Bits of the statusword.
pub mod statusword {
    /// Ready to switch on.
    pub const READY_TO_SWITCH_ON: u16 = 1 << 0;
    /// Switched on.
    pub const SWITCHED_ON: u16 = 1 << 1;
    /// Operation enabled.
    pub const OPERATION_ENABLED: u16 = 1 << 2;
    /// Fault.
    pub const FAULT: u16 = 1 << 3;
    /// Voltage enabled.
    pub const VOLTAGE_ENABLED: u16 = 1 << 4;
    /// Quick stop; active low.
    pub const QUICK_STOP: u16 = 1 << 5;
    /// Switch on disabled.
    pub const SWITCH_ON_DISABLED: u16 = 1 << 6;
    /// Warning.
    pub const WARNING: u16 = 1 << 7;
    /// Remote: the controlword is processed.
    pub const REMOTE: u16 = 1 << 9;
    /// Target reached.
    pub const TARGET_REACHED: u16 = 1 << 10;
    /// Internal limit active, for example the software position limit changed the target.
    pub const INTERNAL_LIMIT: u16 = 1 << 11;
    /// Mode-specific: set-point acknowledge, speed, homing attained, interpolation active, or drive
    /// follows the command value.
    pub const MODE_12: u16 = 1 << 12;
    /// Following error.
    pub const FOLLOWING_ERROR: u16 = 1 << 13;
    /// Homing error.
    pub const HOMING_ERROR: u16 = 1 << 13;
}

/// Device control command of the lower bits of the controlword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// `x110`.
    Shutdown,
    /// `0111`: switch on, or disable operation.
    SwitchOn,
    /// `xx0x`.
    DisableVoltage,
    /// `x01x`.
    QuickStop,
    /// `1111`.
    EnableOperation,
}

impl Command {
    /// The command of a controlword.
    ///
    /// ```
    /// use canopen::cia402::Command;
    /// assert_eq!(Command::from_controlword(0x0006), Command::Shutdown);
    /// assert_eq!(Command::from_controlword(0x000F), Command::EnableOperation);
    /// ```
    #[must_use]
    pub const fn from_controlword(word: u16) -> Self {
        if word & controlword::ENABLE_VOLTAGE == 0 {
            Self::DisableVoltage
        } else if word & controlword::QUICK_STOP == 0 {
            Self::QuickStop
        } else if word & controlword::SWITCH_ON == 0 {
            Self::Shutdown
        } else if word & controlword::ENABLE_OPERATION == 0 {
            Self::SwitchOn
        } else {
            Self::EnableOperation
        }
    }
}

impl Cia402State {
    /// The state bits of the statusword.
    #[must_use]
    pub const fn statusword(self) -> u16 {
        use statusword::{
            FAULT, OPERATION_ENABLED, QUICK_STOP, READY_TO_SWITCH_ON, SWITCH_ON_DISABLED,
            SWITCHED_ON,
        };
        match self {
            Self::NotReadyToSwitchOn => 0,
            Self::SwitchOnDisabled => SWITCH_ON_DISABLED,
            Self::ReadyToSwitchOn => QUICK_STOP | READY_TO_SWITCH_ON,
            Self::SwitchedOn => QUICK_STOP | SWITCHED_ON | READY_TO_SWITCH_ON,
            Self::OperationEnabled => {
                QUICK_STOP | OPERATION_ENABLED | SWITCHED_ON | READY_TO_SWITCH_ON
            }
            Self::QuickStopActive => OPERATION_ENABLED | SWITCHED_ON | READY_TO_SWITCH_ON,
            Self::FaultReactionActive => {
                FAULT | OPERATION_ENABLED | SWITCHED_ON | READY_TO_SWITCH_ON
            }
            Self::Fault => FAULT,
        }
    }
}
