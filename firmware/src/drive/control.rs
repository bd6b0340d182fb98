//! Application and axis, which the control step changes.

use canopen::cia402::{Axis, Parameters};

use crate::application::Application;

/// The application, and the axis with its parameters.
#[derive(Debug)]
pub struct Control {
    pub(super) application: Application,
    pub(super) axis: Axis,
    pub(super) axis_parameters: Parameters,
}
