//! An actuator restored from serialised bytes continues bit-exactly.
#![cfg(feature = "serde")]

use model_core::actuator::{Actuator, ModelKind, PlantKind, Settings};
use model_core::models::delay::DelayLine;
use model_core::named::Named;
use proptest::prelude::*;

fn any_settings() -> impl Strategy<Value = Settings> {
    let models = proptest::sample::select(ModelKind::ALL);
    let plants = proptest::sample::select(PlantKind::ALL);
    (models, plants, 0.0..0.1).prop_map(|(model, plant, delay_s)| {
        let mut settings = Settings::new(model, plant);
        settings.setup.delay_s = delay_s;
        // Noise advances its stream, whose state must be saved too.
        settings.encoder.encoder_noise_deg = 0.1;
        settings
    })
}

fn through_bytes(actuator: &Actuator) -> Actuator {
    let bytes = postcard::to_stdvec(actuator).unwrap();
    postcard::from_bytes(&bytes).unwrap()
}

proptest! {
    // Each case simulates up to 100 ms twice.
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_restored_actuator_continues_bit_exactly(
        settings in any_settings(),
        before in 0_u64..1500,
        after in 1_u64..500,
    ) {
        let mut original = Actuator::try_new(&settings).unwrap();
        original.advance(-40.0, before).unwrap();
        let mut restored = through_bytes(&original);
        for actuator in [&mut original, &mut restored] {
            actuator.advance(25.0, after).unwrap();
        }
        prop_assert_eq!(original.reading(), restored.reading());
        prop_assert_eq!(original.tick(), restored.tick());
    }

    #[test]
    fn arbitrary_bytes_never_panic(
        bytes in proptest::collection::vec(any::<u8>(), 0..400),
    ) {
        let _ = postcard::from_bytes::<Actuator>(&bytes);
    }
}

#[test]
fn a_delay_beyond_the_line_and_an_index_beyond_the_delay_are_refused() {
    let line = |delay: u64, oldest: u64| {
        let bytes = postcard::to_stdvec(&(3_u64, delay, false, oldest)).unwrap();
        postcard::from_bytes::<DelayLine<[f64; 4]>>(&bytes)
    };
    assert!(line(4, 3).is_ok());
    assert!(line(5, 0).is_err());
    assert!(line(4, 4).is_err());
}

#[test]
fn a_parameter_outside_its_range_is_refused() {
    let settings = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    let actuator = Actuator::try_new(&settings).unwrap();
    let mut bytes = postcard::to_stdvec(&actuator).unwrap();
    // The tag of the model is one byte, followed by the pole.
    bytes[1..9].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(postcard::from_bytes::<Actuator>(&bytes).is_err());
}

#[cfg(feature = "alloc")]
mod on_the_heap {
    use super::*;

    type OnHeap = Actuator<Vec<f64>>;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(16))]

        #[test]
        fn it_moves_and_is_written_like_the_one_without(
            settings in any_settings(), ticks in 0_u64..2500,
        ) {
            let mut without = Actuator::try_new(&settings).unwrap();
            let mut with = OnHeap::try_with_ring(&settings).unwrap();
            without.advance(-40.0, ticks).unwrap();
            with.advance(-40.0, ticks).unwrap();
            prop_assert_eq!(with.reading(), without.reading());
            let bytes = postcard::to_stdvec(&without).unwrap();
            prop_assert_eq!(&postcard::to_stdvec(&with).unwrap(), &bytes);
            let mut restored: OnHeap = postcard::from_bytes(&bytes).unwrap();
            without.advance(25.0, 500).unwrap();
            restored.advance(25.0, 500).unwrap();
            prop_assert_eq!(restored.reading(), without.reading());
        }
    }

    #[test]
    fn a_delay_above_the_longest_takes_no_memory() {
        let bytes = postcard::to_stdvec(&(3_u64, u64::MAX, false, 0_u64)).unwrap();
        assert!(postcard::from_bytes::<DelayLine<Vec<f64>>>(&bytes).is_err());
    }

    #[test]
    fn it_takes_a_few_kilobytes() {
        // The ring of the default delay has 350 values, 2.8 KB.
        assert!(size_of::<OnHeap>() < 4096, "{}", size_of::<OnHeap>());
    }
}
