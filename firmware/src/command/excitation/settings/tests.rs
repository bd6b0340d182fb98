use model_core::excitation::{
    chirp::ChirpParameters, multisine::MultisineParameters, multistep::ThreeTwoOneOneParameters,
    prbs::PrbsParameters, ramp::RampParameters, steady_sine::SineParameters,
    variable_step::VariableStepParameters,
};
use proptest::prelude::*;

use super::*;
use crate::parameters::{ObjectValue, tests::ends_of_range};

fn excitation(settings: ExcitationSettings) -> Excitation<'static> {
    settings.run().expect("possible").excitation
}

/// The greatest difference of two excitations, deg.
fn max_difference_deg(one: &Excitation<'_>, other: &Excitation<'_>) -> f64 {
    let difference = |tick| {
        let difference_deg = one.command(tick).saturating_sub(other.command(tick));
        difference_deg.to_f64().abs()
    };
    (0..500_000).step_by(77).map(difference).fold(0.0, f64::max)
}

#[test]
fn the_shapes_match_those_computed_in_double_precision() {
    let set = |shape| ExcitationSettings {
        shape,
        ..ExcitationSettings::DEFAULT
    };
    let chirp = ChirpParameters::DEFAULT;
    let steps = ThreeTwoOneOneParameters {
        amplitude_deg: 5.0,
        start_s: 0.0,
        unit_s: 0.3,
    };
    let (dwell_s, scale) = (0.3, 5.0 / 120.0);
    let stairs = VariableStepParameters { dwell_s, scale };
    let (amplitude_deg, rate_deg_s, hold_s) = (5.0, 60.0, 0.3);
    let ramp = RampParameters {
        amplitude_deg,
        rate_deg_s,
        hold_s,
    };
    let frequency_hz = 0.1;
    let sine = SineParameters {
        amplitude_deg,
        frequency_hz,
    };
    let prbs = PrbsParameters {
        chip_s: 0.3,
        ..PrbsParameters::DEFAULT
    };
    let multisine = MultisineParameters {
        amplitude_deg,
        base_hz: 0.1,
        lines: 8.0,
        ..MultisineParameters::DEFAULT
    };
    let references = [
        (
            2,
            Excitation::Multistep(Multistep::try_3211(&steps).unwrap()),
        ),
        (
            3,
            Excitation::VariableStep(VariableStep::try_new(&stairs).unwrap()),
        ),
        (4, Excitation::Ramp(Ramp::try_new(&ramp).unwrap())),
        (5, Excitation::Chirp(Chirp::try_linear(&chirp).unwrap())),
        (
            6,
            Excitation::Chirp(Chirp::try_logarithmic(&chirp).unwrap()),
        ),
        (7, Excitation::Sine(SteadySine::try_new(&sine).unwrap())),
        (8, Excitation::Prbs(Prbs::try_new(&prbs).unwrap())),
        (
            9,
            Excitation::Multisine(Multisine::try_new(&multisine).unwrap()),
        ),
    ];
    for (shape, reference) in references {
        let difference_deg = max_difference_deg(&excitation(set(shape)), &reference);
        // In mdeg the step of 1/24 deg is rounded to 0.041 deg, in up to 120 steps.
        let bound = if shape == 3 { 0.1 } else { 1e-6 };
        assert!(difference_deg < bound, "shape {shape}: {difference_deg}");
    }
}

#[test]
fn each_run_has_the_duration_of_its_excitation() {
    for shape in 0..10 {
        for repetitions in [1, 3] {
            let run = ExcitationSettings {
                shape,
                repetitions,
                ..ExcitationSettings::DEFAULT
            }
            .run()
            .unwrap();
            assert_eq!(run, Run::new(run.excitation, repetitions as u16), "{shape}");
        }
    }
}

#[test]
fn a_falling_chirp_mirrors_a_rising_one() {
    for shape in [5, 6] {
        let falling = excitation(ExcitationSettings {
            shape,
            start_mhz: 10_000,
            end_mhz: 100,
            ..ExcitationSettings::DEFAULT
        });
        let ends = ChirpParameters {
            start_hz: 10.0,
            end_hz: 0.1,
            ..ChirpParameters::DEFAULT
        };
        let reference = match shape {
            5 => Chirp::try_linear(&ends),
            _ => Chirp::try_logarithmic(&ends),
        };
        let difference_deg = max_difference_deg(&falling, &Excitation::Chirp(reference.unwrap()));
        assert!(difference_deg < 1e-6, "shape {shape}: {difference_deg}");
    }
}

proptest! {
    #[test]
    fn any_settings_are_run_or_refused(words in proptest::array::uniform10(any::<i32>()), tick: u64) {
        let mut values = ObjectValues::DEFAULT;
        for (setting, word) in SETTINGS.into_iter().zip(words) {
            values.set_word(setting, word as u32);
        }
        let is_valid = SETTINGS.iter().all(|setting| values.is_in_range(*setting));
        prop_assert_eq!(values.excitation.run().is_some(), is_valid);
        for (setting, word) in SETTINGS.into_iter().zip(words) {
            let default = ObjectValues::DEFAULT.word(setting) as i32;
            let (min, max) = ends_of_range(default, |value| {
                let mut values = ObjectValues::DEFAULT;
                values.set_word(setting, value as u32);
                values.is_in_range(setting)
            });
            let span = i64::from(max) - i64::from(min) + 1;
            let offset = i64::from(word).rem_euclid(span);
            values.set_word(setting, (i64::from(min) + offset) as u32);
        }
        let run = values.excitation.run().expect("within the ranges");
        let _ = run.excitation.command(tick);
    }
}

const SETTINGS: [ObjectValue; 10] = [
    ObjectValue::Shape,
    ObjectValue::AmplitudeMdeg,
    ObjectValue::StartMhz,
    ObjectValue::EndMhz,
    ObjectValue::DurationMs,
    ObjectValue::UnitMs,
    ObjectValue::RateDegS,
    ObjectValue::Order,
    ObjectValue::Lines,
    ObjectValue::Repetitions,
];
