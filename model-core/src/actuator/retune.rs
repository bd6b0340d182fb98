//! Gains that change during a run.

use super::stepped_core::{ActuatorCore, Model};
use crate::control::{cascade::Coefficients, parameters::ControlParameters};
use crate::parameter::ParameterError;

impl ActuatorCore {
    /// Changes the parameters of the board's control step without a jump of the duty, as a write to
    /// its object dictionary does. The other models have no control step and remain as they are.
    ///
    /// # Errors
    /// That of the first parameter that is out of its range or inconsistent with another one;
    /// nothing is changed then.
    pub fn retune(&mut self, control: &ControlParameters) -> Result<(), ParameterError> {
        let coefficients = Coefficients::try_new(control)?;
        match &mut self.model {
            Model::FirstOrder(board) => board.retune(coefficients),
            Model::Drivetrain(board) => board.retune(coefficients),
            Model::BlackBox1(_) | Model::BlackBox2(_) | Model::GreyBox(_) => {}
        }
        Ok(())
    }
}
