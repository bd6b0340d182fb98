//! What is known of the motor, which outlives a restart.

use super::{Application, back_emf_brake::BackEmfBrake};
use crate::protection::Learned;

/// What is known of the motor.
#[derive(Debug, Clone, Copy)]
pub(crate) struct KnownMotor {
    learned: Learned,
    brake: BackEmfBrake,
}

impl Application {
    /// What is known of the motor, which outlives a restart.
    pub(crate) fn known_motor(&self) -> KnownMotor {
        KnownMotor {
            learned: self.protection.learned(),
            brake: self.back_emf_brake,
        }
    }

    /// Continues with what was known before a restart.
    pub(crate) fn continue_with(&mut self, known: KnownMotor) {
        self.protection.continue_with(known.learned);
        self.back_emf_brake = known.brake;
    }

    /// The constants of the motor are others.
    pub(crate) fn forget_constant(&mut self) {
        self.protection.forget_constant();
    }
}
