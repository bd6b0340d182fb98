//! What surrounds each control step: missed ticks, its time, and the watchdog.

use cortex_m::peripheral::{DCB, DWT};
use firmware::supervisor::{Part, Supervisor};
use stm32f4xx_hal::pac::IWDG;

use crate::{
    actuator::{heard, ticks::Ticks},
    board::watchdog::Watchdog,
};

/// Watches over the control step, and over everybody else.
pub struct Vigil {
    supervisor: Supervisor,
    watchdog: Watchdog,
    ticks: Ticks,
}

impl Vigil {
    /// Starts the watchdog and the cycle counter.
    pub fn start(watchdog: IWDG, debug: DCB, trace: DWT) -> Self {
        Self {
            supervisor: Supervisor::new(),
            watchdog: Watchdog::start(watchdog),
            ticks: Ticks::new(debug, trace),
        }
    }

    /// The control step of this tick begins: how many ticks went without one.
    pub fn begin(&mut self, tick: u32) -> u8 {
        self.ticks.begin(tick)
    }

    /// It ended: feeds the watchdog if every part is alive. In how many periods one was late.
    pub fn end(&mut self) -> u32 {
        heard::from(Part::Control);
        heard::tell(&mut self.supervisor);
        if self.supervisor.period() {
            self.watchdog.feed();
        }
        self.ticks.end();
        self.supervisor.starved()
    }
}
