//! Gains that change during a run.

use super::settings::Settings;
use super::stepped_core::{ActuatorCore, Model, demand};
use crate::control::cascade::Coefficients;
use crate::models::grey_box::GreyBoxParameters;
use crate::parameter::ParameterError;

impl ActuatorCore {
    /// Changes the parameters of the controller to those of the settings without a jump of the
    /// duty: those of the board's control step, as a write to its object dictionary does, or those
    /// of the grey box. Black boxes have no controller and remain as they are.
    ///
    /// # Errors
    /// That of the first parameter that is out of its range or inconsistent with another one;
    /// nothing is changed then.
    pub fn retune(&mut self, settings: &Settings) -> Result<(), ParameterError> {
        let demand = demand(self.level(), self.now.arrived);
        match &mut self.model {
            Model::FirstOrder(board) => board.retune(Coefficients::try_new(&settings.control)?),
            Model::Drivetrain(board) => board.retune(Coefficients::try_new(&settings.control)?),
            Model::GreyBox(model) => {
                let present = *model.parameters();
                let wanted = settings.grey_box;
                let parameters = GreyBoxParameters {
                    // The motor remains.
                    motor_gain_up: present.motor_gain_up,
                    motor_gain_down: present.motor_gain_down,
                    motor_time_constant_s: present.motor_time_constant_s,
                    rate_limit_up_deg_s: present.rate_limit_up_deg_s,
                    rate_limit_down_deg_s: present.rate_limit_down_deg_s,
                    position_limit_deg: present.position_limit_deg,
                    ..wanted
                };
                model.retune(parameters, demand)?;
            }
            Model::BlackBox1(_) | Model::BlackBox2(_) => {}
        }
        Ok(())
    }
}
