//! What the control step begins with.

use firmware::application::Samples;

use crate::actuator::{
    analog::Analog, bridge::Bridge, bus_state, encoder::Encoder, servo_pulse::ServoPulse,
};

/// What was measured since the last tick. A stage of the control step: a function that is not inlined, with a
/// name that a debugger or an emulator finds in the ELF.
#[unsafe(no_mangle)]
#[inline(never)]
pub fn gather(
    encoder: &mut Encoder,
    analog: &mut Analog,
    pulse: &mut ServoPulse,
    bridge: &mut Bridge,
) -> Samples {
    let (current, scan) = analog.take();
    Samples {
        encoder: encoder.finish(),
        current,
        scan,
        servo_pulse_us: pulse.take_us(),
        bridge_tripped: bridge.take_trip(),
        missed_periods: 0,
        bus: bus_state::take(),
    }
}
