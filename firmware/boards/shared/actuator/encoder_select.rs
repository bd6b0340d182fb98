//! The chip select of the encoder.

use core::convert::Infallible;

use embedded_hal::digital::{ErrorType, OutputPin};

use super::pins::ENCODER_SELECT;
use crate::chip::pac::GPIOA;

/// CSn of the encoder, a pin of port A.
pub struct SelectPin(GPIOA);

impl SelectPin {
    /// The pin, high.
    pub fn new(port: GPIOA) -> Self {
        let mut pin = Self(port);
        let _ = pin.set_high();
        pin
    }
}

impl ErrorType for SelectPin {
    type Error = Infallible;
}

impl OutputPin for SelectPin {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        // SAFETY: one bit resets one pin.
        (self.0.bsrr()).write(|w| unsafe { w.bits(1 << (ENCODER_SELECT + 16)) });
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        // SAFETY: one bit sets one pin.
        (self.0.bsrr()).write(|w| unsafe { w.bits(1 << ENCODER_SELECT) });
        Ok(())
    }
}
