//! What a control step has computed, for the comparison with a second computation of it.

use canopen::cia402::{Axis, Parameters};

use super::{Drive, motion::Motion};
use crate::{application::ControlState, parameters::BoardParameters};

/// State of axis and loop after a control step, and the parameters that it has used. Two
/// computations of a step from the same state and samples make the same one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepState {
    axis: Axis,
    axis_parameters: Parameters,
    parameters: BoardParameters,
    motion: Motion,
    control: ControlState,
}

impl Drive<'_> {
    /// The state after the last control step.
    pub fn step_state(&self) -> StepState {
        StepState {
            axis: self.control.axis,
            axis_parameters: self.control.axis_parameters,
            parameters: *self.application().parameters(),
            motion: self.motion,
            control: self.control.application.control_state(),
        }
    }
}
