//! The motions that injections disturb.

use board_tests::frames::{Frame, SAVE, control, mode, start, velocity, write};
use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Control periods between two frames of the master: 50 Hz.
const COMMAND_TICKS: u64 = 5;

/// Control periods between two changes of the target: 600 ms.
const HOLD_TICKS: u64 = 150;

/// First control period with targets.
const ENABLED_TICK: u64 = 60;

/// Controlwords: enabled, and enabled with the bit `halt`.
const ENABLED: u16 = 0x0f;
const HALTED: u16 = 0x10f;

/// Modes of operation: profile velocity, and cyclic synchronous velocity.
const PROFILE_VELOCITY: i8 = 3;
const CYCLIC_VELOCITY: i8 = 9;

/// What the master has the drive do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ValueEnum)]
#[serde(rename_all = "kebab-case")]
pub enum Motion {
    /// Cyclic synchronous position: steps between 30 deg and -30 deg.
    Position,
    /// Cyclic synchronous position: steps between 70 deg and -70 deg, at full duty.
    Saturated,
    /// Cyclic synchronous position: one target that is held.
    Holding,
    /// Cyclic synchronous velocity: 40 deg/s and -40 deg/s.
    Velocity,
    /// Profile velocity: 60 deg/s and -60 deg/s, and stops by the bit `halt` between them.
    Stopping,
    /// Never enabled.
    Disabled,
    /// Never enabled; stores its parameters.
    Saving,
}

impl Motion {
    /// All motions.
    pub const ALL: [Self; 7] = [
        Self::Position,
        Self::Saturated,
        Self::Holding,
        Self::Velocity,
        Self::Stopping,
        Self::Disabled,
        Self::Saving,
    ];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "steps of position",
            Self::Saturated => "at full duty",
            Self::Holding => "held position",
            Self::Velocity => "steps of velocity",
            Self::Stopping => "stops",
            Self::Disabled => "not enabled",
            Self::Saving => "storing",
        }
    }

    /// What the master sends in this control period after power-on.
    pub fn frames(self, tick: u64) -> Vec<Frame> {
        let sign = if (tick / HOLD_TICKS).is_multiple_of(2) {
            1
        } else {
            -1
        };
        match (self, tick) {
            (_, 50) => vec![start()],
            (Self::Saving, _) if tick % HOLD_TICKS == ENABLED_TICK => {
                vec![write(0x1010, 1, SAVE, 4)]
            }
            (Self::Disabled | Self::Saving, _) => Vec::new(),
            (Self::Velocity, 52) => vec![mode(0, CYCLIC_VELOCITY)],
            (Self::Stopping, 52) => vec![mode(0, PROFILE_VELOCITY)],
            (_, 54) => vec![control(0x06, 0)],
            (_, 56) => vec![control(0x07, 0)],
            (_, 58) => vec![control(ENABLED, 0)],
            (_, ENABLED_TICK..) if tick.is_multiple_of(COMMAND_TICKS) => match self {
                Self::Velocity => vec![velocity(ENABLED, 40_000 * sign)],
                Self::Stopping => {
                    let is_second_half = tick % HOLD_TICKS >= HOLD_TICKS / 2;
                    let word = if is_second_half { HALTED } else { ENABLED };
                    vec![velocity(word, 60_000 * sign)]
                }
                Self::Saturated => vec![control(ENABLED, 70_000 * sign)],
                Self::Holding => vec![control(ENABLED, 20_000)],
                _ => vec![control(ENABLED, 30_000 * sign)],
            },
            _ => Vec::new(),
        }
    }
}
