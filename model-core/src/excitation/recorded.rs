//! A recorded sequence of commands.

use crate::control::units::Angle;
use core::fmt;

/// Commands with the ticks at which they take effect, each constant until the next one.
///
/// The first command applies from the start, the last one without end; zero if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Recorded<'a> {
    commands: &'a [(u64, Angle)],
}

/// The commands of a recording are not in the order of their ticks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OutOfOrder {
    /// Index of the first command that is earlier than its predecessor.
    pub index: usize,
}

impl fmt::Display for OutOfOrder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "command {} is earlier than its predecessor", self.index)
    }
}

impl core::error::Error for OutOfOrder {}

impl<'a> Recorded<'a> {
    /// A recording; if commands have the same tick, the last of them applies.
    ///
    /// ```
    /// use model_core::{control::units::Angle, excitation::recorded::Recorded};
    /// let commands = [(10, Angle::from_int(1)), (20, Angle::from_int(2))];
    /// let recorded = Recorded::try_new(&commands).unwrap();
    /// assert_eq!([0, 19, 20, 99].map(|i| recorded.command(i).to_int()), [1, 1, 2, 2]);
    /// ```
    ///
    /// # Errors
    /// [`OutOfOrder`] if a command is earlier than its predecessor.
    pub fn try_new(commands: &'a [(u64, Angle)]) -> Result<Self, OutOfOrder> {
        match commands.windows(2).position(|pair| pair[1].0 < pair[0].0) {
            Some(index) => Err(OutOfOrder { index: index + 1 }),
            None => Ok(Self { commands }),
        }
    }

    /// The command at a tick.
    pub fn command(&self, tick: u64) -> Angle {
        let started = self.commands.partition_point(|&(start, _)| start <= tick);
        let held = self.commands.get(started.saturating_sub(1));
        held.map_or(Angle::ZERO, |&(_, command)| command)
    }

    /// Tick of the last command.
    pub fn duration_ticks(&self) -> u64 {
        self.commands.last().map_or(0, |&(tick, _)| tick)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_out_of_order_is_refused_with_its_index() {
        let commands = [3, 5, 5, 4].map(|tick| (tick, Angle::ZERO));
        assert_eq!(Recorded::try_new(&commands), Err(OutOfOrder { index: 3 }));
        assert!(Recorded::try_new(&commands[..3]).is_ok());
    }

    #[test]
    fn the_last_of_several_commands_at_a_tick_applies() {
        let commands = [(5, Angle::from_int(1)), (5, Angle::from_int(2))];
        assert_eq!(
            Recorded::try_new(&commands).unwrap().command(5),
            Angle::from_int(2)
        );
    }

    #[test]
    fn an_empty_recording_is_zero() {
        let empty = Recorded::try_new(&[]).unwrap();
        assert_eq!(
            (empty.command(u64::MAX), empty.duration_ticks()),
            (Angle::ZERO, 0)
        );
    }
}
