//! Targets and offsets as they were written, from which the targets of each mode are made.

use canopen::cia402::Mode;

/// Targets and offsets as they were written; positions as the axis counts them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Targets {
    /// Target position, mdeg.
    pub position: i32,
    /// Added to it in the cyclic position mode, mdeg.
    pub offset: i32,
    /// Target torque, thousandths of the rated torque.
    pub torque: i16,
    /// Added to it in the cyclic torque mode, and the torque of the other cyclic modes; thousandths
    /// of the rated torque.
    pub torque_offset: i16,
}

impl Targets {
    /// The target position of a mode, mdeg; `None` in the interpolated position mode, whose points
    /// are targets when they are due.
    pub fn position_of_mode(&self, mode: Mode) -> Option<i32> {
        match mode {
            Mode::InterpolatedPosition => None,
            Mode::CyclicPosition => Some(self.position.saturating_add(self.offset)),
            _ => Some(self.position),
        }
    }

    /// The target torque of a mode, thousandths of the rated torque; of a cyclic mode without one,
    /// the offset.
    pub fn torque_of_mode(&self, mode: Mode) -> i16 {
        match mode {
            Mode::CyclicTorque => self.torque.saturating_add(self.torque_offset),
            mode if mode.is_cyclic() => self.torque_offset,
            _ => self.torque,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_offset_counts_in_the_cyclic_mode_only() {
        let targets = Targets {
            position: 100,
            offset: i32::MAX,
            ..Targets::default()
        };
        assert_eq!(targets.position_of_mode(Mode::ProfilePosition), Some(100));
        assert_eq!(
            targets.position_of_mode(Mode::CyclicPosition),
            Some(i32::MAX)
        );
        assert_eq!(targets.position_of_mode(Mode::InterpolatedPosition), None);
    }
}
