//! Commands by integer tick: the excitations of the control core, or a sequence from a file.

pub mod file;

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
}
