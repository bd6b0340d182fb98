//! The motions that injections disturb.

use board_tests::frames::{Frame, control, start, target};

/// Control periods between two frames of the master: 50 Hz.
const COMMAND_TICKS: u64 = 5;

/// Control periods between two changes of the target: 600 ms.
const HOLD_TICKS: u64 = 150;

/// First control period with targets.
const ENABLED_TICK: u64 = 60;

/// What the master has the drive do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Cyclic synchronous position: steps between 30 deg and -30 deg.
    Position,
    /// Cyclic synchronous velocity: 40 deg/s and -40 deg/s.
    Velocity,
    /// Never enabled.
    Disabled,
}

impl Motion {
    /// All motions; position, the ordinary one, twice.
    pub const ALL: [Self; 4] = [
        Self::Position,
        Self::Velocity,
        Self::Position,
        Self::Disabled,
    ];

    /// Its position in a table of motions.
    pub fn index(self) -> usize {
        self as usize
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
            (Self::Disabled, _) => Vec::new(),
            (Self::Velocity, 52) => vec![target(0, 9)],
            (_, 54) => vec![control(0x06, 0)],
            (_, 56) => vec![control(0x07, 0)],
            (_, 58) => vec![control(0x0f, 0)],
            (_, ENABLED_TICK..) if tick.is_multiple_of(COMMAND_TICKS) => match self {
                Self::Velocity => vec![target(40_000 * sign, 9)],
                _ => vec![control(0x0f, 30_000 * sign)],
            },
            _ => Vec::new(),
        }
    }
}
