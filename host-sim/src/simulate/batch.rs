//! Many actuators that are stepped together, each with its own command.
//!
//! Boards are computed side by side in vectors where they can be
//! ([`LoopLanes`](model_core::actuator::lanes::LoopLanes)), all others one by one; both on all
//! cores and bit for bit as an [`Actuator`] each.

mod group;

use model_core::{
    actuator::{Actuator, Settings},
    parameter::ParameterError,
    plant::{drivetrain::lanes::DrivetrainLanes, first_order::lanes::MotorLanes},
    time::CONTROL_PERIOD_TICKS,
};
use rayon::prelude::*;

use self::group::Group;

/// Actuators that are computed side by side.
const ABREAST: usize = 32;

/// The state of an actuator at the end of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BatchState {
    /// Angle of the output shaft, deg.
    pub angle_deg: f64,
    /// Its rate, deg/s.
    pub rate_deg_s: f64,
    /// Measured angle, deg.
    pub angle_meas_deg: f64,
    /// Measured rate, deg/s.
    pub rate_meas_deg_s: f64,
}

/// Actuators with their own commands.
pub struct Batch {
    /// Ticks of a step.
    ticks: u64,
    /// One after the other: those of group `i` are [`ABREAST`] `i` and the following.
    groups: Vec<Actuators>,
    count: usize,
}

/// Up to [`ABREAST`] actuators.
enum Actuators {
    Motors(Box<Group<MotorLanes<ABREAST>>>),
    Benches(Box<Group<DrivetrainLanes<ABREAST>>>),
    Single(Vec<Single>),
}

/// Fewer benches are no faster beside empty lanes than alone.
const LEAST_BENCHES: usize = ABREAST / 4 + 1;

/// An actuator that is computed alone.
struct Single(Box<Actuator<Vec<f64>>>);

impl Single {
    fn try_new(settings: &Settings) -> Result<Self, ParameterError> {
        Actuator::try_with_ring(settings).map(|actuator| Self(Box::new(actuator)))
    }

    /// Passes these ticks with a command, deg; in place of one that is not finite the last one
    /// holds.
    fn step(&mut self, ticks: u64, command: f64) -> BatchState {
        let Self(actuator) = self;
        if actuator.advance(command, ticks).is_err() {
            let last = actuator.reading().command_deg;
            let _ = actuator.advance(last, ticks);
        }
        let now = actuator.reading();
        BatchState {
            angle_deg: now.angle_deg,
            rate_deg_s: now.rate_deg_s,
            angle_meas_deg: now.angle_meas_deg,
            rate_meas_deg_s: now.rate_meas_deg_s,
        }
    }
}

/// The parameters of an actuator are refused.
#[derive(Debug, Clone, PartialEq)]
pub struct Refused {
    /// Its index.
    pub index: usize,
    /// The reason.
    pub error: Box<ParameterError>,
}

impl Refused {
    /// The refusal of the actuator with this index.
    fn at(index: usize) -> impl Fn(ParameterError) -> Self {
        move |error| Self {
            index,
            error: Box::new(error),
        }
    }

    /// The same with an index that counts from the first of a group.
    fn in_group(self, group: usize) -> Self {
        Self {
            index: group * ABREAST + self.index,
            ..self
        }
    }
}

impl Batch {
    /// Actuators at rest at zero, which are stepped by this number of ticks at a time.
    ///
    /// # Errors
    /// [`Refused`].
    ///
    /// ```
    /// use host_sim::settings::{ModelKind, PlantKind, Settings};
    /// use host_sim::simulate::batch::{Batch, BatchState};
    ///
    /// let settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    /// let mut batch = Batch::try_new(&[settings; 3], 400).unwrap();
    /// let mut states = [BatchState::default(); 3];
    /// for _ in 0..100 {
    ///     batch.step(&[10.0, 20.0, -30.0], &mut states);
    /// }
    /// assert!((states[2].angle_deg + 30.0).abs() < 0.1);
    /// ```
    pub fn try_new(settings: &[Settings], ticks: u64) -> Result<Self, Refused> {
        let chunks: Vec<_> = settings.chunks(ABREAST).enumerate().collect();
        let groups = chunks.into_par_iter().map(|(index, settings)| {
            let group = Actuators::try_new(settings, ticks);
            group.map_err(|refused| refused.in_group(index))
        });
        Ok(Self {
            ticks,
            groups: groups.collect::<Result<_, _>>()?,
            count: settings.len(),
        })
    }

    /// Number of actuators.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether the batch contains no actuator.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Steps all actuators with their commands, deg, and writes their states. Both have one element
    /// an actuator. In place of a command that is not finite the last one holds.
    pub fn step(&mut self, commands: &[f64], states: &mut [BatchState]) {
        let ticks = self.ticks;
        let chunks = commands
            .par_chunks(ABREAST)
            .zip(states.par_chunks_mut(ABREAST));
        self.groups
            .par_iter_mut()
            .zip(chunks)
            .for_each(|(group, (commands, states))| group.step(ticks, commands, states));
    }

    /// Replaces some actuators, by index in increasing order, with others at rest at zero.
    ///
    /// # Errors
    /// [`Refused`]; the actuators of the groups before are then replaced.
    pub fn replace(&mut self, fresh: &[(usize, Settings)]) -> Result<(), Refused> {
        for some in fresh.chunk_by(|a, b| a.0 / ABREAST == b.0 / ABREAST) {
            let first = some.first().map_or(0, |(index, _)| index / ABREAST);
            if let Some(group) = self.groups.get_mut(first) {
                let lanes: Vec<_> = some.iter().map(|(i, s)| (i % ABREAST, *s)).collect();
                let done = group.replace(&lanes);
                done.map_err(|refused| refused.in_group(first))?;
            }
        }
        Ok(())
    }
}

impl Actuators {
    fn try_new(settings: &[Settings], ticks: u64) -> Result<Self, Refused> {
        if ticks.is_multiple_of(CONTROL_PERIOD_TICKS) {
            if let Some(group) = Group::try_new(settings, 1)? {
                return Ok(Self::Motors(Box::new(group)));
            }
            if let Some(group) = Group::try_new(settings, LEAST_BENCHES)? {
                return Ok(Self::Benches(Box::new(group)));
            }
        }
        let one = |(lane, settings)| Single::try_new(settings).map_err(Refused::at(lane));
        let all = settings.iter().enumerate().map(one);
        Ok(Self::Single(all.collect::<Result<_, _>>()?))
    }

    fn step(&mut self, ticks: u64, commands: &[f64], states: &mut [BatchState]) {
        let periods = ticks / CONTROL_PERIOD_TICKS;
        match self {
            Self::Motors(group) => group.step(periods, commands, states),
            Self::Benches(group) => group.step(periods, commands, states),
            Self::Single(actuators) => {
                for ((actuator, command), state) in actuators.iter_mut().zip(commands).zip(states) {
                    *state = actuator.step(ticks, *command);
                }
            }
        }
    }

    fn replace(&mut self, fresh: &[(usize, Settings)]) -> Result<(), Refused> {
        match self {
            Self::Motors(group) => group.replace(fresh),
            Self::Benches(group) => group.replace(fresh),
            Self::Single(actuators) => {
                for (lane, settings) in fresh {
                    if let Some(place) = actuators.get_mut(*lane) {
                        *place = Single::try_new(settings).map_err(Refused::at(*lane))?;
                    }
                }
                Ok(())
            }
        }
    }
}

#[cfg(test)]
mod tests;
