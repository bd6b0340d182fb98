//! The application around the plant of `model-core`, which stands in for everything that the
//! board's pins see.

use model_core::plant::board::{self as plant, Sampled};

use crate::application::{Bridge, BusState, Samples, Scan};

/// What the application is given of what was sampled, on a board that is otherwise undisturbed.
///
/// ```
/// use firmware::native::samples;
/// use model_core::plant::board::{BoardPlant, BoardPlantOptions, SampledBoardPlant};
///
/// let plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
/// let ticked = SampledBoardPlant::new(plant, &mut |_, _| {});
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

/// What the plant's bridge does of what was decided.
pub fn bridge(decided: Bridge) -> plant::Bridge {
    match decided {
        Bridge::Coast => plant::Bridge::Coast,
        Bridge::Brake => plant::Bridge::Brake,
        Bridge::Driven(compare) => plant::Bridge::driven(compare.get()),
    }
}
