//! What changes while an actuator runs, without its parameters and what derives from them.
//!
//! This part has a third of the bytes of an actuator. It is for a caller that keeps the parameters
//! elsewhere, and saves and restores the state in each step.

use super::closed_loop::LoopState;
use super::input::{COMMAND_RANGE, InputLevel};
use super::stepped_core::{ActuatorCore, Model, Signals, pass_edges, ticks_into_period};
use crate::plant::{
    Plant, PlantState, drivetrain::stepped::SteppedState, first_order::FirstOrderState,
};
use crate::sensors::noise::Noise;

/// The state of an [`ActuatorCore`], without the values in its delay.
#[derive(Debug, Clone, PartialEq)]
pub struct CoreState {
    now: Signals,
    model: ModelState,
}

/// That of its model.
#[derive(Debug, Clone, PartialEq)]
enum ModelState {
    BlackBox1(f64),
    BlackBox2([f64; 2]),
    GreyBox([f64; 3]),
    FirstOrder {
        board: (LoopState, Noise),
        plant: FirstOrderState,
    },
    Drivetrain {
        board: (LoopState, Noise),
        plant: SteppedState,
    },
}

impl CoreState {
    /// Number of ticks so far.
    pub fn tick(&self) -> u64 {
        self.now.tick
    }
}

/// A state is that of another model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OtherModel;

impl ActuatorCore {
    /// The present state.
    ///
    /// ```
    /// use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
    ///
    /// let mut settings = Settings::new(ModelKind::Board, PlantKind::FirstOrder);
    /// settings.setup.delay_s = 0.0;
    /// let mut actuator = Actuator::try_new(&settings).unwrap();
    /// actuator.advance(90.0, 123).unwrap();
    /// let (state, now) = (actuator.state(), actuator.reading());
    /// actuator.advance(-10.0, 4567).unwrap();
    /// actuator.set_state(&state).unwrap();
    /// assert_eq!(actuator.reading(), now);
    /// ```
    pub fn state(&self) -> CoreState {
        let owned = |(now, noise): (&LoopState, &Noise)| (*now, noise.clone());
        let model = match &self.model {
            Model::BlackBox1(model) => ModelState::BlackBox1(model.angle_deg()),
            Model::BlackBox2(model) => ModelState::BlackBox2(model.state()),
            Model::GreyBox(model) => ModelState::GreyBox(model.state()),
            Model::FirstOrder(board) => ModelState::FirstOrder {
                board: owned(board.state()),
                plant: board.plant.state(),
            },
            Model::Drivetrain(board) => ModelState::Drivetrain {
                board: owned(board.state()),
                plant: board.plant.state(),
            },
        };
        let now = self.now;
        CoreState { now, model }
    }

    /// The same in place of another state, which takes less time if that is of the same model.
    #[inline]
    pub fn save_state(&self, state: &mut CoreState) {
        match (&self.model, &mut state.model) {
            (Model::FirstOrder(from), ModelState::FirstOrder { board, plant }) => {
                let (now, noise) = from.state();
                board.0 = *now;
                board.1.clone_from(noise);
                *plant = from.plant.state();
            }
            (Model::Drivetrain(from), ModelState::Drivetrain { board, plant }) => {
                let (now, noise) = from.state();
                board.0 = *now;
                board.1.clone_from(noise);
                *plant = from.plant.state();
            }
            _ => {
                *state = self.state();
                return;
            }
        }
        state.now = self.now;
    }

    /// As [`Self::set_state`] and [`Self::advance_with`] without a delay to a later tick with a
    /// command in the present quantity, then as [`Self::load`]. `None` without an effect for a
    /// model other than the board with the first-order motor, or if something else must be done:
    /// for the most frequent case there is nothing to decide in between.
    #[inline(always)]
    pub fn advance_from(
        &mut self,
        state: &CoreState,
        level: InputLevel,
        value: f64,
        end: u64,
    ) -> Option<PlantState> {
        let is_plain = level == state.now.level
            && end > state.now.tick
            && self.host_ticks == 0
            && COMMAND_RANGE.contains(&value);
        match (&mut self.model, &state.model) {
            (Model::FirstOrder(to), ModelState::FirstOrder { board, plant }) if is_plain => {
                to.set_state((&board.0, &board.1));
                to.plant.set_state(plant);
                pass_edges(to, state.now.tick..end, level, value);
                self.now = state.now;
                (self.now.arrived, self.now.tick) = (value, end);
                Some(to.plant.at(ticks_into_period(end)))
            }
            _ => None,
        }
    }

    /// Continues from a state of this actuator or of another one with the same settings, exactly as
    /// from its copy.
    ///
    /// # Errors
    /// [`OtherModel`] if it has another model or plant; nothing is changed then.
    #[inline]
    pub fn set_state(&mut self, state: &CoreState) -> Result<(), OtherModel> {
        match (&mut self.model, &state.model) {
            (Model::FirstOrder(to), ModelState::FirstOrder { board, plant }) => {
                to.set_state((&board.0, &board.1));
                to.plant.set_state(plant);
            }
            (Model::Drivetrain(to), ModelState::Drivetrain { board, plant }) => {
                to.set_state((&board.0, &board.1));
                to.plant.set_state(plant);
            }
            (Model::BlackBox1(model), ModelState::BlackBox1(angle_deg)) => model.place(*angle_deg),
            (Model::BlackBox2(model), ModelState::BlackBox2(state)) => model.set_state(*state),
            (Model::GreyBox(model), ModelState::GreyBox(state)) => model.set_state(*state),
            _ => return Err(OtherModel),
        }
        self.now = state.now;
        Ok(())
    }
}
