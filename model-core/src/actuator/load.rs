//! Signals of the load: torque, inertia and motion that another simulation gives.

use super::input::{CommandError, LOAD_TORQUE_RANGE_NM};
use super::stepped_core::{ActuatorCore, Model, ticks_into_period};
use crate::plant::{Plant, PlantState};

impl ActuatorCore {
    /// Applies a torque to the load from the next tick on, Nm, in addition to that of the
    /// parameters; only the drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError::Value`] for a torque beyond [`LOAD_TORQUE_RANGE_NM`], and for NaN.
    pub fn set_load_torque_nm(&mut self, torque_nm: f64) -> Result<(), CommandError> {
        if !LOAD_TORQUE_RANGE_NM.contains(&torque_nm) {
            return Err(CommandError::Value);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.set_recorded_torque_nm(torque_nm);
        }
        Ok(())
    }

    /// Adds an inertia to the load from the next tick on, kg m^2, up to 1e3, in addition to
    /// that of the parameters; only the drivetrain has a load.
    ///
    /// # Errors
    /// [`CommandError::Value`] for an inertia that is not finite or below zero.
    pub fn set_load_inertia_kg_m2(&mut self, inertia_kg_m2: f64) -> Result<(), CommandError> {
        if !(inertia_kg_m2 >= 0.0 && inertia_kg_m2.is_finite()) {
            return Err(CommandError::Value);
        }
        if let Model::Drivetrain(board) = &mut self.model {
            board.plant.set_added_inertia_kg_m2(inertia_kg_m2);
        }
        Ok(())
    }

    /// Moves the load by an angle, deg, and an impulse, Nm s: what another simulation has found to
    /// act on it beyond the torque that was set. Only the
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

    /// Places the shaft at an angle, deg, before the first tick: later it has no effect. The
    /// board's encoder then measures it within half a turn.
    ///
    /// # Errors
    /// [`CommandError::Value`] for an angle that is not finite.
    pub fn place(&mut self, angle_deg: f64) -> Result<(), CommandError> {
        if !angle_deg.is_finite() {
            return Err(CommandError::Value);
        }
        if self.tick() > 0 {
            return Ok(());
        }
        match &mut self.model {
            Model::BlackBox1(model) => model.place(angle_deg),
            Model::BlackBox2(model) => model.place(angle_deg),
            Model::GreyBox(model) => model.place(angle_deg),
            Model::FirstOrder(board) => board.plant.place(angle_deg),
            Model::Drivetrain(board) => board.plant.place(angle_deg),
        }
        Ok(())
    }

    /// Torque of the drivetrain's shaft on the load at this instant, Nm; 0 without a load.
    #[inline]
    pub fn shaft_torque_nm(&self) -> f64 {
        match &self.model {
            Model::Drivetrain(board) => board.plant.shaft_torque_nm(),
            _ => 0.0,
        }
    }

    /// Motion of the load at this instant: of the last body of the drivetrain, which moves against
    /// the output within the flexibility of the shaft, and otherwise of the output itself.
    #[inline]
    pub fn load(&self) -> PlantState {
        match &self.model {
            Model::Drivetrain(board) => board.plant.load(),
            Model::FirstOrder(board) => board.plant.at(ticks_into_period(self.tick())),
            Model::BlackBox1(_) | Model::BlackBox2(_) | Model::GreyBox(_) => {
                let now = self.reading();
                PlantState {
                    angle_deg: now.angle_deg,
                    rate_deg_s: now.rate_deg_s,
                }
            }
        }
    }
}
