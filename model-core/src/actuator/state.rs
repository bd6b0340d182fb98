//! What changes while an actuator runs, without its parameters and what derives from them.
//!
//! A snapshot of this part is a third of the whole actuator, and so is the time of a copy. It is
//! for a caller that keeps the parameters elsewhere and saves or restores the state in each step.

use super::closed_loop::LoopState;
use super::input::InputLevel;
use super::stepped_core::{ActuatorCore, Model};
use crate::plant::{drivetrain::stepped::SteppedState, first_order::MotorState};

/// The state of an [`ActuatorCore`], without the values in its delay.
#[derive(Debug, Clone, PartialEq)]
pub struct CoreState {
    model: ModelState,
    level: InputLevel,
    sampled: f64,
    arrived: f64,
    tick: u64,
}

/// That of its model.
#[derive(Debug, Clone, PartialEq)]
enum ModelState {
    BlackBox1(f64),
    BlackBox2([f64; 2]),
    GreyBox([f64; 3]),
    FirstOrder(LoopState, MotorState),
    Drivetrain(LoopState, SteppedState),
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
    #[inline]
    pub fn state(&self) -> CoreState {
        CoreState {
            model: match &self.model {
                Model::BlackBox1(model) => ModelState::BlackBox1(model.angle_deg()),
                Model::BlackBox2(model) => ModelState::BlackBox2(model.state()),
                Model::GreyBox(model) => ModelState::GreyBox(model.state()),
                Model::FirstOrder(board) => {
                    ModelState::FirstOrder(board.state(), board.plant.state())
                }
                Model::Drivetrain(board) => {
                    ModelState::Drivetrain(board.state(), board.plant.state())
                }
            },
            level: self.level,
            sampled: self.sampled,
            arrived: self.arrived,
            tick: self.tick,
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
            (Model::BlackBox1(model), ModelState::BlackBox1(angle_deg)) => model.place(*angle_deg),
            (Model::BlackBox2(model), ModelState::BlackBox2(state)) => model.set_state(*state),
            (Model::GreyBox(model), ModelState::GreyBox(state)) => model.set_state(*state),
            (Model::FirstOrder(board), ModelState::FirstOrder(of_loop, plant)) => {
                board.set_state(of_loop);
                board.plant.set_state(plant);
            }
            (Model::Drivetrain(board), ModelState::Drivetrain(of_loop, plant)) => {
                board.set_state(of_loop);
                board.plant.set_state(plant);
            }
            _ => return Err(OtherModel),
        }
        self.level = state.level;
        self.sampled = state.sampled;
        self.arrived = state.arrived;
        self.tick = state.tick;
        Ok(())
    }
}
