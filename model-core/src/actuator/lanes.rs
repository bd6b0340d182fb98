//! Several boards at once around plants side by side, for campaigns: bit for bit the
//! [`ClosedLoop`](super::closed_loop::ClosedLoop) of each.

use crate::{
    control::{cascade::Coefficients, lanes::CascadeLanes, units::Angle},
    parameter::ParameterError,
    plant::{
        PlantState,
        lanes::{Extremes, PlantLanes},
    },
    sensors::encoder::{EncoderParameters, ideal_counts},
};

use super::{ModelKind, Settings};

/// Which ticks are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seen {
    /// Every one.
    All,
    /// The first of each PWM period.
    Edges,
}

/// `N` boards, around plants `P`.
#[derive(Debug, Clone)]
pub struct LoopLanes<P, const N: usize> {
    control: CascadeLanes<N>,
    plants: P,
    /// The extremes of what was seen.
    pub seen: Extremes<N>,
}

/// Whether the control step of these settings can be one of [`LoopLanes`]: that of the board, with
/// an ideal encoder and a duty that the timer does not round.
fn is_ideal(settings: &Settings) -> bool {
    settings.model == ModelKind::Board
        && settings.encoder == EncoderParameters::DEFAULT
        && settings.timer == super::closed_loop::TimerParameters::DEFAULT
}

impl<const N: usize, P: PlantLanes<N>> LoopLanes<P, N> {
    /// Boards at rest at zero; `None` where they cannot be computed side by side.
    ///
    /// # Errors
    /// That of the first parameter which is out of its range.
    pub fn try_new(settings: [&Settings; N]) -> Result<Option<Self>, ParameterError> {
        if !settings.iter().all(|s| is_ideal(s) && s.plant == P::KIND) {
            return Ok(None);
        }
        let mut coefficients = [Coefficients::DEFAULT; N];
        for (lane, s) in settings.iter().enumerate() {
            coefficients[lane] = Coefficients::try_new(&s.control)?;
        }
        Ok(P::try_new(settings)?.map(|plants| Self {
            control: CascadeLanes::new(&coefficients),
            plants,
            seen: Extremes::default(),
        }))
    }

    /// Advances one period; outputs the first `ticks` ticks, from 1 to 80.
    #[inline(always)]
    pub fn pass(&mut self, command: Angle, ticks: usize, see: Seen) {
        self.pass_each(&[command; N], ticks, see);
    }

    /// The same with a command for each board.
    #[inline(always)]
    pub fn pass_each(&mut self, commands: &[Angle; N], ticks: usize, see: Seen) {
        let counts = ideal_counts(&self.plants.states().angle_deg);
        let duty = self.control.control_period(&counts, commands);
        match see {
            Seen::All => self.plants.pass::<true>(&duty, ticks, &mut self.seen),
            Seen::Edges => self.plants.pass::<false>(&duty, ticks, &mut self.seen),
        }
    }

    /// The state of a board at the end of the last control period.
    pub fn state(&self, lane: usize) -> PlantState {
        self.plants.states().of(lane)
    }

    /// Its measured angle, deg, and its estimated rate, deg/s.
    pub fn measured(&self, lane: usize) -> (f64, f64) {
        let (angle, rate) = self.control.measured(lane);
        (angle.to_f64(), rate.to_f64())
    }

    /// Takes over a board with the same settings.
    pub fn keep(&mut self, other: &Self, lane: usize) {
        self.control.keep(&other.control, lane);
        self.plants.keep(&other.plants, lane);
    }

    /// The state of a board at the tick that was seen last.
    pub fn last(&self, lane: usize) -> PlantState {
        self.plants.last_seen(lane)
    }
}

#[cfg(test)]
mod tests;
