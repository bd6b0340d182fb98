//! Commands by integer tick: the excitations of the control core, or a sequence from a file.

pub mod file;
mod flight_like;

pub use self::flight_like::flight_like;

use model_core::{
    control::units::{Angle, angle},
    excitation::Excitation,
};

/// A piecewise constant sequence: each value is held from its tick on.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Sequence {
    points: Vec<(u64, f64)>,
}

impl Sequence {
    /// Appends a value; one for the same tick replaces the last.
    ///
    /// # Panics
    /// If the tick is before the last one.
    pub fn push(&mut self, tick: u64, value: f64) {
        match self.points.last_mut() {
            Some(last) if last.0 == tick => last.1 = value,
            last => {
                assert!(
                    last.is_none_or(|last| last.0 < tick),
                    "ticks do not decrease"
                );
                self.points.push((tick, value));
            }
        }
    }

    /// Ticks and values in order.
    pub fn points(&self) -> &[(u64, f64)] {
        &self.points
    }

    /// The tick of the last value.
    pub fn last_tick(&self) -> u64 {
        self.points.last().map_or(0, |point| point.0)
    }

    /// The first tick after this one with another value.
    fn next_tick(&self, tick: u64) -> u64 {
        // Before the second value there is the first.
        let index = self.points.partition_point(|point| point.0 <= tick).max(1);
        self.points.get(index).map_or(u64::MAX, |point| point.0)
    }

    /// The value at a tick: the last one at or before it; before the first, the first.
    fn at(&self, tick: u64) -> f64 {
        let index = self.points.partition_point(|point| point.0 <= tick);
        self.points
            .get(index.saturating_sub(1))
            .map_or(0.0, |point| point.1)
    }
}

/// The command of an actuator.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// An excitation of the control core, exact on every target.
    Excitation(Excitation<'static>),
    /// A sequence from a file.
    Sequence(Sequence),
}

impl Command {
    /// The command at a tick, deg.
    pub fn at(&self, tick: u64) -> f64 {
        match self {
            Self::Excitation(excitation) => excitation.command(tick).to_f64(),
            Self::Sequence(sequence) => sequence.at(tick),
        }
    }

    /// The command at a tick in the fixed-point format of the board.
    pub fn board(&self, tick: u64) -> Angle {
        match self {
            Self::Excitation(excitation) => excitation.command(tick),
            Self::Sequence(sequence) => angle(sequence.at(tick)),
        }
    }

    /// A tick after this one, up to which the command is certainly the same.
    fn held_until(&self, tick: u64) -> u64 {
        match self {
            Self::Excitation(Excitation::VariableStep(levels)) => {
                let dwell = levels.dwell_ticks.get();
                (tick / dwell + 1).saturating_mul(dwell)
            }
            Self::Excitation(_) => tick.saturating_add(1),
            Self::Sequence(sequence) => sequence.next_tick(tick),
        }
    }
}

/// The path of a command through the test set-up: sampled by the host, then delayed.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandPath<'a> {
    /// The command.
    pub command: &'a Command,
    /// Transport delay, ticks.
    pub delay_ticks: u64,
    /// Sample period of the host, ticks; 0 without sampling.
    pub host_ticks: u64,
}

impl CommandPath<'_> {
    /// The tick whose command is at the end of the delay at `tick`; at least the first.
    pub fn sent(&self, tick: u64) -> u64 {
        tick.saturating_sub(self.delay_ticks)
    }

    /// The tick whose command is at the actuator at `tick`, with sampling and delay.
    pub fn source(&self, tick: u64) -> u64 {
        let sent = self.sent(tick);
        // Without a host period every tick is a sample.
        sent - sent.checked_rem(self.host_ticks).unwrap_or(0)
    }

    /// The command at the actuator at `tick`, and a later tick, up to which it is certainly the
    /// same. Who evaluates tick after tick saves the division of each.
    pub fn held(&self, tick: u64) -> (Angle, u64) {
        let source = self.source(tick);
        let until = self.command.held_until(source);
        // The sample that is the first to see what comes then.
        let until = match self.host_ticks {
            0 => until,
            period => until.div_ceil(period).saturating_mul(period),
        };
        (
            self.command.board(source),
            until.saturating_add(self.delay_ticks),
        )
    }
}

#[cfg(test)]
mod tests {
    use model_core::excitation::variable_step::VariableStep;
    use proptest::prelude::*;

    use super::*;

    fn command() -> impl Strategy<Value = Command> {
        let stairs = (1_u64..500).prop_map(|dwell| {
            let stairs = VariableStep::try_new(&Default::default()).expect("the defaults");
            let dwell_ticks = dwell.try_into().expect("at least 1");
            Command::Excitation(Excitation::VariableStep(VariableStep {
                dwell_ticks,
                ..stairs
            }))
        });
        let points = proptest::collection::btree_map(0_u64..3000, -90.0..90.0, 0..20);
        let sequence = points.prop_map(|points| {
            let mut sequence = Sequence::default();
            for (tick, value) in points {
                sequence.push(tick, value);
            }
            Command::Sequence(sequence)
        });
        prop_oneof![stairs, sequence]
    }

    proptest! {
        #[test]
        fn a_held_command_is_that_of_each_tick(
            command in command(),
            delay_ticks in 0_u64..400,
            host_ticks in 0_u64..450,
        ) {
            let path = CommandPath { command: &command, delay_ticks, host_ticks };
            let (mut value, mut until) = path.held(0);
            for tick in 0..4000 {
                if tick >= until {
                    (value, until) = path.held(tick);
                    prop_assert!(until > tick);
                }
                prop_assert_eq!(value, command.board(path.source(tick)));
            }
        }
    }
}
