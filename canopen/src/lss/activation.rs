//! LSS "activate bit timing": all nodes of the network switch their bit rate at the same time.

use crate::application::{Application, BitRate};
use crate::timer::Timer;

/// A bit rate switch in progress: switch delay, switch, second switch delay of the same length. The
/// node transmits nothing during both.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    bit_rate: Option<BitRate>,
    delay: Timer,
    remaining: Timer,
}

impl Activation {
    pub fn new(bit_rate: BitRate, delay_ms: u16) -> Self {
        let delay = Timer::from_ms(delay_ms);
        Self {
            bit_rate: Some(bit_rate),
            delay,
            remaining: delay,
        }
    }

    pub fn advance(&mut self, elapsed: Timer) {
        self.remaining.advance(elapsed);
    }

    /// Switches the bit rate after the first delay; returns whether the second delay has elapsed,
    /// after which frames may be transmitted.
    pub fn advance_phase(&mut self, app: &mut impl Application) -> bool {
        if !self.remaining.is_expired() {
            return false;
        }
        let Some(bit_rate) = self.bit_rate.take() else {
            return true;
        };
        app.set_bit_rate(bit_rate);
        self.remaining = self.delay;
        self.remaining.is_expired()
    }
}
