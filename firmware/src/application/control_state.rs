//! State of the loop, for the comparison of two computations of a control step.

use model_core::{
    control::cascade::{CascadeState, CascadeStep},
    plant::pwm_timer::{Modulator, PwmCompare},
};

use super::Application;
use crate::velocity::VelocityTracker;

/// State of the loop after a control step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ControlState {
    control: CascadeState,
    velocity: VelocityTracker,
    last_step: CascadeStep,
    modulator: Modulator,
    compare: PwmCompare,
}

impl Application {
    /// The state of the loop.
    pub(crate) fn control_state(&self) -> ControlState {
        ControlState {
            control: self.control,
            velocity: self.velocity,
            last_step: self.last_step,
            modulator: self.modulator,
            compare: self.compare,
        }
    }
}
