//! What a control step has computed, for the comparison with a second computation of it.

use canopen::cia402::Axis;

use super::{Drive, motion::Motion};
use crate::application::ControlState;

/// State of axis and loop after a control step. Two computations of a step from the same state and
/// samples make the same one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepState {
    axis: Axis,
    motion: Motion,
    control: ControlState,
}

impl Drive<'_> {
    /// The state after the last control step.
    pub fn step_state(&self) -> StepState {
        StepState {
            axis: self.control.axis,
            motion: self.motion,
            control: self.control.application.control_state(),
        }
    }
}
