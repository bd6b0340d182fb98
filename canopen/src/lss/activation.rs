//! Activate bit timing: the whole network changes its bit rate at once.

use crate::application::{Application, BitRate};
use crate::timer::Timer;

/// A change of the bit rate under way: silence, the change, silence of the same length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    bit_rate: Option<BitRate>,
    delay: Timer,
    rest: Timer,
}

impl Activation {
    pub fn new(bit_rate: BitRate, delay_ms: u16) -> Self {
        let delay = Timer::ms(delay_ms);
        Self {
            bit_rate: Some(bit_rate),
            delay,
            rest: delay,
        }
    }

    pub fn pass(&mut self, elapsed: Timer) {
        self.rest.pass(elapsed);
    }

    /// Changes the bit rate when it is time. Whether frames may be sent again.
    pub fn over(&mut self, app: &mut impl Application) -> bool {
        if !self.rest.is_over() {
            return false;
        }
        let Some(bit_rate) = self.bit_rate.take() else {
            return true;
        };
        app.set_bit_rate(bit_rate);
        self.rest = self.delay;
        self.rest.is_over()
    }
}
