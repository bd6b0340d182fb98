//! The application around the rig of `model-core`, which stands in for everything that the board's pins see.

use model_core::plant::rig::{self, Sampled};

use crate::application::{Bridge, BusState, Samples, Scan};

/// What the application is given of what was sampled, on a board that is otherwise undisturbed.
///
/// ```
/// use firmware::native::samples;
/// use model_core::plant::rig::{Rig, RigOptions, TickedRig};
///
/// let rig = Rig::try_new(&RigOptions::default()).unwrap();
/// let ticked = TickedRig::new(rig, &mut |_, _| {});
/// // Nothing has been converted before the first control period.
/// assert_eq!(samples(&ticked.sampled()).scan, None);
/// ```
pub fn samples(sampled: &Sampled) -> Samples {
    Samples {
        encoder: Some(sampled.sensed.encoder.word()),
        current: sampled.current,
        scan: sampled.window.map(|window| Scan {
            leg_a: window.legs.a,
            leg_b: window.legs.b,
            supply: window.supply,
            temperature: window.temperature,
        }),
        servo_pulse_us: None,
        bridge_tripped: false,
        missed_periods: 0,
        bus: BusState::Active,
    }
}

/// What the rig's bridge does of what was decided.
pub fn bridge(decided: Bridge) -> rig::Bridge {
    match decided {
        Bridge::Coast => rig::Bridge::Coast,
        Bridge::Brake => rig::Bridge::Brake,
        Bridge::Driven(compare) => rig::Bridge::driven(compare.get()),
    }
}
