//! The parameters of the control loop, as one message.

use canopen::cia402::Parameters as AxisParameters;

use super::axis_parameters::axis_parameters;
use crate::{
    drive::StoredParameters,
    interface::Settings,
    measure::Ripple,
    parameters::{BoardParameters, FailsafeSettings, ObjectValues},
};

/// Everything that the loop uses and a front end can set.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct LoopParameters {
    /// Number of the message; another number is a new message. Wraps.
    pub number: u32,
    /// Control law, protections, command sources.
    pub board: BoardParameters,
    /// Profiles, limits and options of the axis.
    pub axis: AxisParameters,
    /// The reaction to the loss of the master.
    pub failsafe: FailsafeSettings,
    /// The ripple of the motor's current.
    pub ripple: Ripple,
}

impl LoopParameters {
    /// Those of a stored set, as message 0.
    pub fn of(stored: &StoredParameters) -> Self {
        let values = stored.values();
        Self {
            number: 0,
            board: stored.board,
            axis: axis_parameters(values, &stored.board),
            failsafe: values.failsafe,
            ripple: ripple(values),
        }
    }

    /// Those of the application.
    pub(super) fn settings(&self) -> Settings<'_> {
        Settings {
            board: &self.board,
            ripple: &self.ripple,
        }
    }

    /// Takes over the values of objects: profile, reaction to the loss of the master, and winding.
    pub(crate) fn set_values(&mut self, values: &ObjectValues) {
        self.axis = axis_parameters(values, &self.board);
        self.failsafe = values.failsafe;
    }

    /// Takes over the winding of the motor model.
    pub(crate) fn set_winding(&mut self, values: &ObjectValues) {
        self.ripple = ripple(values);
    }
}

/// The ripple of the current in the motor that these values describe.
fn ripple(values: &ObjectValues) -> Ripple {
    Ripple::of(values.model.resistance_ohm, values.model.inductance_h)
}
