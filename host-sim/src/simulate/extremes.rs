//! Campaigns: many runs on all cores, each evaluated by the extremes of its motion.

use model_core::actuator::closed_loop::ClosedLoop;
use model_core::plant::{PERIOD, Plant, PlantState, first_order::FirstOrder};
use rayon::prelude::*;

use super::{Rows, Simulation, board};
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

/// Ticks that are evaluated in parallel: two SSE2 vectors or one AVX vector.
const LANES: usize = 4;

/// The least and the greatest values, lane by lane.
#[derive(Debug, Clone, Copy)]
struct Ends {
    least: [f64; LANES],
    greatest: [f64; LANES],
}

impl Default for Ends {
    fn default() -> Self {
        Self {
            least: [f64::INFINITY; LANES],
            greatest: [f64::NEG_INFINITY; LANES],
        }
    }
}

impl Ends {
    /// Includes values, preferably a multiple of the lanes.
    #[inline(always)]
    fn see(&mut self, values: &[f64]) {
        let (whole, rest) = values.as_chunks::<LANES>();
        for lanes in whole {
            self.see_lanes(lanes);
        }
        for value in rest {
            self.see_lanes(&[*value; LANES]);
        }
    }

    #[inline(always)]
    fn see_lanes(&mut self, values: &[f64; LANES]) {
        for (lane, value) in values.iter().enumerate() {
            // `f64::min` and `max` are slower because they handle NaN.
            self.least[lane] = if *value < self.least[lane] {
                *value
            } else {
                self.least[lane]
            };
            self.greatest[lane] = if *value > self.greatest[lane] {
                *value
            } else {
                self.greatest[lane]
            };
        }
    }

    fn least(&self) -> f64 {
        self.least.into_iter().fold(f64::INFINITY, f64::min)
    }

    fn greatest(&self) -> f64 {
        self.greatest.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Evaluates a run tick by tick.
#[derive(Debug, Clone, Copy, Default)]
struct Watch {
    angle_deg: Ends,
    rate_deg_s: Ends,
    last: PlantState,
}

impl Watch {
    #[inline(always)]
    fn see(&mut self, state: PlantState) {
        self.angle_deg.see(&[state.angle_deg]);
        self.rate_deg_s.see(&[state.rate_deg_s]);
        self.last = state;
    }

    fn extremes(&self) -> Extremes {
        Extremes {
            least_angle_deg: self.angle_deg.least(),
            greatest_angle_deg: self.angle_deg.greatest(),
            least_rate_deg_s: self.rate_deg_s.least(),
            greatest_rate_deg_s: self.rate_deg_s.greatest(),
            last: self.last,
        }
    }
}

impl Rows for Watch {
    fn row(&mut self, values: &[f64]) -> Result<(), Error> {
        // The common columns: t, command, command_delayed, angle_deg, rate_deg_s.
        self.see(PlantState {
            angle_deg: values[3],
            rate_deg_s: values[4],
        });
        Ok(())
    }
}

/// A run with the widest vectors of the processor. No operation is fused: the results are the same
/// on every processor.
struct Watching<'a>(&'a Simulation);

impl pulp::NullaryFnOnce for Watching<'_> {
    type Output = Result<Extremes, Error>;

    #[inline(always)]
    fn call(self) -> Self::Output {
        self.0.watch()
    }
}

impl Simulation {
    /// Runs, and evaluates each tick of a row. The motor is stepped from row to row, by 1 ms at
    /// every 20th tick; its equations are solved exactly for any step.
    ///
    /// # Errors
    /// As [`Simulation::run`].
    pub fn extremes(&self) -> Result<Extremes, Error> {
        pulp::Arch::new().dispatch(Watching(self))
    }

    #[inline(always)]
    fn watch(&self) -> Result<Extremes, Error> {
        let mut watch = Watch::default();
        match (self.settings.model, self.settings.plant) {
            (ModelKind::Board, PlantKind::FirstOrder) => {
                let board = board::around_first_order(&self.settings)?;
                if self.every == 1 {
                    self.watch_every_tick(board, &mut watch);
                } else {
                    board::drive(board, self, &self.path(), |board, _, within| {
                        watch.see(board.plant.at(within));
                        Ok(())
                    })?;
                }
            }
            _ => self.run(&mut watch)?,
        }
        Ok(watch.extremes())
    }

    #[inline(always)]
    fn watch_every_tick(&self, mut board: ClosedLoop<FirstOrder>, watch: &mut Watch) {
        let path = self.path();
        let mut left = self.ticks;
        while left > 0 {
            board.start_period(|tick| path.command.board(path.source(tick)));
            let ticks = board.plant.ticks();
            let wanted = left.min(PERIOD as u64) as usize;
            if wanted == PERIOD {
                // A constant length, so that the compiler vectorises the loop.
                watch.angle_deg.see(&ticks.angle_deg);
                watch.rate_deg_s.see(&ticks.rate_deg_s);
            } else {
                watch.angle_deg.see(&ticks.angle_deg[..wanted]);
                watch.rate_deg_s.see(&ticks.rate_deg_s[..wanted]);
            }
            watch.last = board.plant.at(wanted - 1);
            left -= wanted as u64;
        }
    }
}

/// Runs all simulations, on all cores.
pub fn campaign(simulations: &[Simulation]) -> Vec<Result<Extremes, Error>> {
    simulations.par_iter().map(Simulation::extremes).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        scenario::{Scenario, Setting},
        settings::ModelKind,
        trace::Trace,
    };
    use model_core::named::Named;

    fn simulation(model: ModelKind, every: u64, set: &[(&str, f64)]) -> Simulation {
        let scenario = Scenario {
            model: Some(model),
            input: Some("variable-step".into()),
            // Not a whole number of PWM periods.
            duration_s: Some(5.00015),
            every: Some(every),
            set: set
                .iter()
                .map(|(name, value)| Setting::new(*name, *value))
                .collect(),
            ..Default::default()
        };
        scenario.resolve().unwrap()
    }

    fn of_trace(trace: &Trace) -> Extremes {
        let column = |name| trace.column(name).unwrap();
        let ends = |values: &[f64]| {
            let least = values.iter().copied().fold(f64::INFINITY, f64::min);
            (
                least,
                values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            )
        };
        let (angle, rate) = (column("angle_deg"), column("rate_deg_s"));
        Extremes {
            least_angle_deg: ends(angle).0,
            greatest_angle_deg: ends(angle).1,
            least_rate_deg_s: ends(rate).0,
            greatest_rate_deg_s: ends(rate).1,
            last: PlantState {
                angle_deg: *angle.last().unwrap(),
                rate_deg_s: *rate.last().unwrap(),
            },
        }
    }

    #[test]
    fn the_extremes_are_those_of_the_recorded_trace_to_the_last_bit() {
        // Free motion, hard stops, rate limits.
        for set in [
            &[][..],
            &[("position_limit_deg", 50.0)],
            &[("rate_limit_up_deg_s", 100.0)],
        ] {
            for every in [1, 20, 7, 33] {
                let simulation = simulation(ModelKind::Board, every, set);
                let trace = simulation.record().unwrap();
                assert_eq!(
                    simulation.extremes().unwrap(),
                    of_trace(&trace),
                    "every {every}"
                );
            }
        }
    }

    #[test]
    fn every_model_can_be_in_a_campaign() {
        let simulations: Vec<_> = ModelKind::ALL
            .iter()
            .map(|model| simulation(*model, 20, &[]))
            .collect();
        for (simulation, extremes) in simulations.iter().zip(campaign(&simulations)) {
            assert_eq!(extremes.unwrap(), of_trace(&simulation.record().unwrap()));
        }
    }
}
