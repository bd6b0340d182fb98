//! Campaigns: many runs on all cores, each evaluated by the extremes of its motion.

use std::{array, marker::PhantomData};

use model_core::{
    actuator::lanes::{LoopLanes, Seen},
    plant::{
        PlantState,
        drivetrain::lanes::{DrivetrainLanes, Likeness},
        first_order::lanes::MotorLanes,
        lanes::PlantLanes,
    },
    time::{CONTROL_PERIOD_TICKS, UPDATE_PERIOD_TICKS},
};
use rayon::prelude::*;

use super::{Rows, Simulation, board, progress::CHECK_TICKS};
use crate::{
    error::Error,
    settings::{ModelKind, PlantKind},
};

/// The extremes of the motion of a run, over the evaluated ticks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extremes {
    /// Least angle, deg.
    pub least_angle_deg: f64,
    /// Greatest angle, deg.
    pub greatest_angle_deg: f64,
    /// Least rate, deg/s.
    pub least_rate_deg_s: f64,
    /// Greatest rate, deg/s.
    pub greatest_rate_deg_s: f64,
    /// The last state.
    pub last: PlantState,
}

/// Evaluates a run row by row.
#[derive(Debug, Clone, Copy)]
struct Watch(Extremes);

impl Default for Watch {
    fn default() -> Self {
        Self(Extremes {
            least_angle_deg: f64::INFINITY,
            greatest_angle_deg: f64::NEG_INFINITY,
            least_rate_deg_s: f64::INFINITY,
            greatest_rate_deg_s: f64::NEG_INFINITY,
            last: PlantState::default(),
        })
    }
}

impl Watch {
    #[inline(always)]
    fn see(&mut self, state: PlantState) {
        let ends = &mut self.0;
        ends.least_angle_deg = ends.least_angle_deg.min(state.angle_deg);
        ends.greatest_angle_deg = ends.greatest_angle_deg.max(state.angle_deg);
        ends.least_rate_deg_s = ends.least_rate_deg_s.min(state.rate_deg_s);
        ends.greatest_rate_deg_s = ends.greatest_rate_deg_s.max(state.rate_deg_s);
        ends.last = state;
    }
}

impl Rows for Watch {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        // The common columns: time_s, command_deg, command_delayed_deg, angle_deg, rate_deg_s.
        self.see(PlantState {
            angle_deg: values[3],
            rate_deg_s: values[4],
        });
        Ok(())
    }
}

/// Boards that are computed side by side: as many as keep all vectors of a processor busy, and few
/// enough for the nearest cache.
const ABREAST: usize = 32;

/// Runs with the widest vectors of the processor. No operation is fused: the results are the same
/// on every processor.
struct Abreast<'a, P, const N: usize> {
    runs: [&'a Simulation; N],
    plants: PhantomData<P>,
}

impl<'a, P, const N: usize> Abreast<'a, P, N> {
    fn new(runs: [&'a Simulation; N]) -> Self {
        let plants = PhantomData;
        Self { runs, plants }
    }
}

impl<P: PlantLanes<N>, const N: usize> pulp::NullaryFnOnce for Abreast<'_, P, N> {
    type Output = Result<Option<[Extremes; N]>, Error>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let settings = self.runs.map(|run| &run.settings);
        let Some(mut boards) = LoopLanes::<P, N>::try_new(settings)? else {
            return Ok(None);
        };
        let Some(run) = self.runs.first() else {
            return Ok(None);
        };
        let see = match run.every {
            1 => Seen::All,
            UPDATE_PERIOD_TICKS => Seen::Edges,
            _ => return Ok(None),
        };
        let path = run.path();
        let (mut tick, (mut command, mut until)) = (0, path.held(0));
        while tick < run.ticks {
            if tick.is_multiple_of(CHECK_TICKS) {
                self.runs.iter().try_for_each(|run| run.check(tick))?;
            }
            if tick >= until {
                (command, until) = path.held(tick);
            }
            let ticks = (run.ticks - tick).min(CONTROL_PERIOD_TICKS);
            boards.pass(command, ticks as usize, see);
            tick += CONTROL_PERIOD_TICKS;
        }
        Ok(Some(array::from_fn(|lane| {
            let (least, greatest) = (boards.seen.least.of(lane), boards.seen.greatest.of(lane));
            Extremes {
                least_angle_deg: least.angle_deg,
                greatest_angle_deg: greatest.angle_deg,
                least_rate_deg_s: least.rate_deg_s,
                greatest_rate_deg_s: greatest.rate_deg_s,
                last: boards.last(lane),
            }
        })))
    }
}

/// Any other run, likewise.
struct Watching<'a>(&'a Simulation);

impl pulp::NullaryFnOnce for Watching<'_> {
    type Output = Result<Extremes, Error>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        let mut watch = Watch::default();
        match self.0.settings.model {
            ModelKind::Board => board::states(self.0, &self.0.path(), |state| watch.see(state))?,
            _ => self.0.run(&mut watch)?,
        }
        Ok(watch.0)
    }
}

impl Simulation {
    /// Runs, and evaluates each tick of a row. The motor is stepped from row to row, by 1 ms at
    /// every 20th tick; its equations are solved exactly for any step.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub fn extremes(&self) -> Result<Extremes, Error> {
        if let Some([extremes]) =
            pulp::Arch::new().dispatch(Abreast::<MotorLanes<1>, 1>::new([self]))?
        {
            return Ok(extremes);
        }
        pulp::Arch::new().dispatch(Watching(self))
    }

    /// Whether these runs have the same command and the same ticks.
    fn is_beside(&self, other: &Self) -> bool {
        (self.ticks, self.every) == (other.ticks, other.every) && self.path() == other.path()
    }

    /// By this order neighbours are computed side by side best: benches with the same number of
    /// steps in a tick. A first-order motor has no steps, and no bench with a load of its own is
    /// computed beside others.
    fn likeness(&self) -> Option<Likeness> {
        let settings = &self.settings;
        let is_bench = (settings.model, settings.plant)
            == (ModelKind::Board, PlantKind::Drivetrain)
            && self.load.is_none();
        is_bench.then(|| Likeness::of(settings)).flatten()
    }
}

/// Runs all simulations, on all cores. Boards with the same command run side by side.
pub fn campaign(simulations: &[Simulation]) -> Vec<Result<Extremes, Error>> {
    let likenesses = simulations.par_iter().map(Simulation::likeness);
    let mut order: Vec<_> = likenesses
        .collect::<Vec<_>>()
        .into_iter()
        .enumerate()
        .collect();
    // Stable: others remain in their order.
    order.sort_by_key(|(_, likeness)| *likeness);
    let mut results: Vec<_> = order
        .par_chunks(ABREAST)
        .flat_map_iter(|places| {
            let runs: Vec<_> = places
                .iter()
                .map(|(index, _)| &simulations[*index])
                .collect();
            let results = match abreast(&runs) {
                Some(extremes) => extremes.into_iter().map(Ok).collect::<Vec<_>>(),
                None => runs.into_iter().map(Simulation::extremes).collect(),
            };
            places.iter().map(|(index, _)| *index).zip(results)
        })
        .collect();
    results.sort_unstable_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}

/// The extremes of runs side by side; `None` where they have to run alone.
fn abreast(runs: &[&Simulation]) -> Option<Vec<Extremes>> {
    let (first, others) = runs.split_first()?;
    // Beside empty lanes fewer runs are no faster than alone.
    if runs.len() <= ABREAST / 4 || !others.iter().all(|run| run.is_beside(first)) {
        return None;
    }
    let lanes: [_; ABREAST] = array::from_fn(|lane| *runs.get(lane).unwrap_or(first));
    // An error comes again, and from the run that it is of, where they run alone.
    let extremes = match first.settings.plant {
        PlantKind::FirstOrder => side_by_side::<MotorLanes<ABREAST>>(lanes),
        PlantKind::Drivetrain if runs.iter().all(|run| run.load.is_none()) => {
            side_by_side::<DrivetrainLanes<ABREAST>>(lanes)
        }
        PlantKind::Drivetrain => return None,
    };
    Some(extremes?[..runs.len()].to_vec())
}

fn side_by_side<P: PlantLanes<ABREAST>>(
    lanes: [&Simulation; ABREAST],
) -> Option<[Extremes; ABREAST]> {
    let abreast = Abreast::<P, ABREAST>::new(lanes);
    pulp::Arch::new().dispatch(abreast).ok()?
}

#[cfg(test)]
mod tests;
