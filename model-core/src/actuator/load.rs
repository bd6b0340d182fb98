//! Signals of the load: torque, inertia and motion that another simulation gives.

use super::input::{CommandError, LOAD_TORQUE_RANGE_NM};
use super::stepped_core::{ActuatorCore, Model, ticks_into_period};
use crate::plant::PlantState;

impl ActuatorCore {
    /// Applies a torque to the load from the next PWM period on, Nm, in addition to that of the
    /// parameters; only the drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError::Value`] for a torque beyond [`LOAD_TORQUE_RANGE_NM`], and for NaN.
    pub fn set_load_torque_nm(&mut self, torque_nm: f64) -> Result<(), CommandError> {
        if !LOAD_TORQUE_RANGE_NM.contains(&torque_nm) {
            return Err(CommandError::Value);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.set_load_torque_nm(torque_nm);
        }
        Ok(())
    }

    /// Adds an inertia to the load from the next PWM period on, kg m^2, up to 1e3, in addition to
    /// that of the parameters; only the drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError::Value`] for an inertia that is not finite or below zero.
    pub fn set_load_inertia_kg_m2(&mut self, inertia_kg_m2: f64) -> Result<(), CommandError> {
        if !(inertia_kg_m2 >= 0.0 && inertia_kg_m2.is_finite()) {
            return Err(CommandError::Value);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.set_load_inertia_kg_m2(inertia_kg_m2);
        }
        Ok(())
    }

    /// Moves the load by an angle, deg, and an impulse, Nm s, at the end of the running PWM period:
    /// what another simulation has found to act on it beyond the torque that was set. Only the
    /// drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError::Value`] for a value that is not finite.
    pub fn push_load(&mut self, angle_deg: f64, impulse_nms: f64) -> Result<(), CommandError> {
        if !(angle_deg.is_finite() && impulse_nms.is_finite()) {
            return Err(CommandError::Value);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.push_load(angle_deg, impulse_nms);
        }
        Ok(())
    }

    /// Motion of the load at this instant: of the last body of the drivetrain, which moves against
    /// the output within the flexibility of the shaft, and otherwise of the output itself.
    pub fn load(&self) -> PlantState {
        match &self.model {
            Model::Drivetrain(board) => board.plant.reading_at(ticks_into_period(self.tick())).load,
            _ => {
                let now = self.reading();
                PlantState {
                    angle_deg: now.angle_deg,
                    rate_deg_s: now.rate_deg_s,
                }
            }
        }
    }
}
