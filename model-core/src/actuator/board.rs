//! The parts of the board: its loop around a plant, and its analogue front ends.

use super::closed_loop::ClosedLoop;
use super::settings::Settings;
use crate::control::cascade::Coefficients;
use crate::parameter::ParameterError;
use crate::plant::Plant;
use crate::sensors::{adc::FrontEnd, encoder::Encoder, noise::Noise};

/// Streams of the noise generator: one for each sensor, so that they are independent.
const ENCODER_STREAM: u64 = 0;
const CURRENT_STREAM: u64 = 1;
const BACK_EMF_STREAM: u64 = 2;

impl Settings {
    /// The board's loop with a plant.
    ///
    /// # Errors
    /// That of the first parameter of control step or encoder that is out of its range.
    pub fn around<P: Plant>(&self, plant: P) -> Result<ClosedLoop<P>, ParameterError> {
        self.timer.check()?;
        self.encoder.check()?;
        let coefficients = Coefficients::try_new(&self.control)?;
        let encoder = Encoder::new(self.encoder, Noise::new(self.seed, ENCODER_STREAM));
        Ok(ClosedLoop::new(coefficients, self.timer, encoder, plant))
    }

    /// The analogue front ends of the drivetrain: those of the current and of the back-EMF, with
    /// their noise.
    pub fn front_ends(&self) -> [(FrontEnd, Noise); 2] {
        [
            (
                (&self.current_sense).into(),
                Noise::new(self.seed, CURRENT_STREAM),
            ),
            (
                (&self.back_emf_sense).into(),
                Noise::new(self.seed, BACK_EMF_STREAM),
            ),
        ]
    }
}
