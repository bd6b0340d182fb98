//! Activate bit timing: the whole network changes its bit rate at once.

use crate::application::{Application, BitRate};
use crate::instant::later;

/// A change of the bit rate under way: silence, the change, silence of the same length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Activation {
    bit_rate: Option<BitRate>,
    delay_us: u64,
    until_us: u64,
}

impl Activation {
    pub fn new(bit_rate: BitRate, delay_ms: u16, now_us: u64) -> Self {
        let delay_us = u64::from(delay_ms) * 1000;
        Self {
            bit_rate: Some(bit_rate),
            delay_us,
            until_us: later(now_us, delay_us),
        }
    }

    /// Changes the bit rate when it is time. Whether frames may be sent again.
    pub fn over(&mut self, app: &mut impl Application, now_us: u64) -> bool {
        if now_us < self.until_us {
            return false;
        }
        let Some(bit_rate) = self.bit_rate.take() else {
            return true;
        };
        app.set_bit_rate(bit_rate);
        self.until_us = later(now_us, self.delay_us);
        self.delay_us == 0
    }
}
