//! What a control step has computed, for the comparison with a second computation of it.

use canopen::cia402::Axis;

use super::{Drive, commands::Commands, motion::Motion};
use crate::application::ControlState;

/// Commands, and state of axis and loop, after a control step. Two computations of a step from the
/// same state and samples make the same one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepState {
    commands: Commands,
    axis: Axis,
    motion: Motion,
    control: ControlState,
}

impl Drive<'_> {
    /// The state after the last control step.
    pub fn step_state(&self) -> StepState {
        StepState {
            commands: *self.commands,
            axis: self.control.axis,
            motion: self.motion,
            control: self.control.application.control_state(),
        }
    }
}
