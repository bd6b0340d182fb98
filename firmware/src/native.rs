//! Native runs of the application: conversions between its inputs and outputs and those of the
//! board plant of `model-core`, which simulates everything outside the processor's pins.

use model_core::plant::board::{self as plant, Sampled};

use crate::application::{Bridge, BusState, Samples, Scan};

/// The application's inputs for these sampled values; without trips, servo pulses, missed periods
/// or bus errors.
///
/// ```
/// use firmware::native::samples;
/// use model_core::plant::board::{BoardPlant, BoardPlantOptions, SampledBoardPlant};
///
/// let plant = BoardPlant::try_new(&BoardPlantOptions::default()).unwrap();
/// let plant = SampledBoardPlant::new(plant, &mut |_, _| {});
/// // Nothing has been converted before the first control period.
/// assert_eq!(samples(&plant.sampled()).scan, None);
/// ```
pub fn samples(sampled: &Sampled) -> Samples {
    Samples {
        encoder: Some(sampled.sensed.encoder.word()),
        current: sampled.converted.map(|converted| converted.current),
        scan: sampled
            .converted
            .zip(sampled.scanned)
            .map(|(converted, scanned)| Scan {
                leg_a: scanned.legs.a,
                leg_b: scanned.legs.b,
                supply: converted.supply,
                temperature: scanned.temperature,
            }),
        holds_scan: sampled.holds_scan,
        servo_pulse_us: None,
        bridge_tripped: false,
        missed_periods: 0,
        bus: BusState::Active,
    }
}

/// The state of the plant's bridge for this command.
pub fn bridge(command: Bridge) -> plant::Bridge {
    match command {
        Bridge::Coast => plant::Bridge::Coast,
        Bridge::Brake => plant::Bridge::Brake,
        Bridge::Driven(compare) => plant::Bridge::driven(compare.get()),
    }
}
