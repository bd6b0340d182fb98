//! The samples of a control period.
//!
//! What the converters and the encoder have delivered stays in their memory for the control period,
//! so that both copies of the loop read it themselves.

use drivers::bridge::Bridge as _;
use firmware::application::{BusState, Samples};

use super::{bus_status, servo_pulse::ServoPulse};
use crate::peripherals::{ActuatorBridge, Encoder, analog::Analog};

/// Everything that is sampled.
pub struct Sampling {
    pub encoder: Encoder,
    pub analog: Analog,
    servo_pulse: ServoPulse,
    events: Events,
}

/// What has happened since the last control period.
struct Events {
    bridge_tripped: bool,
    missed_periods: u8,
    holds_scan: bool,
    bus: BusState,
}

impl Sampling {
    /// Nothing was sampled yet.
    pub fn new(encoder: Encoder, analog: Analog, servo_pulse: ServoPulse) -> Self {
        Self {
            encoder,
            analog,
            servo_pulse,
            events: Events {
                bridge_tripped: false,
                missed_periods: 0,
                holds_scan: false,
                bus: BusState::Active,
            },
        }
    }

    /// Ends the sampling for a control period, after so many that did not run. `had_window`:
    /// there was a coast window in one of them or in the last one that ran.
    // Not inlined, with a fixed symbol, so that the emulator counts its instructions.
    #[unsafe(no_mangle)]
    #[inline(never)]
    pub fn finish_sampling(
        &mut self,
        bridge: &mut ActuatorBridge,
        missed_periods: u8,
        had_window: bool,
    ) {
        self.analog.finish(had_window);
        // The word is read from the memory of the transfer.
        let _ = self.encoder.finish();
        self.servo_pulse.finish();
        self.events = Events {
            bridge_tripped: bridge.take_trip(),
            missed_periods,
            holds_scan: !had_window,
            bus: bus_status::take_worst_state(),
        };
    }

    /// The samples.
    #[inline(never)]
    pub fn read(&self) -> Samples {
        let (current, scan) = self.analog.read();
        Samples {
            encoder: self.encoder.word(),
            current,
            scan,
            holds_scan: self.events.holds_scan,
            servo_pulse_us: self.servo_pulse.width_us(),
            bridge_tripped: self.events.bridge_tripped,
            missed_periods: self.events.missed_periods,
            bus: self.events.bus,
        }
    }
}
