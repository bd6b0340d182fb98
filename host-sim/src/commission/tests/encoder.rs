//! The error of the encoder, of benches that turn.

use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::sensors::encoder::EncoderParameters;
use model_core::sensors::noise::Noise;

use super::bench::client_within;
use super::{LIMITS, constant_by_default_ratio};
use crate::commission::runs::ECCENTRICITY_DEG;
use crate::commission::{Limits, measure, page};

/// A magnet off its axis by the whole tolerance, in any direction.
fn eccentric(seed: u64) -> BoardPlantOptions {
    let mut options = BoardPlantOptions::another_servo(seed);
    let mut chance = Noise::new(seed, 43);
    options.drivetrain.gear_train.hard_stop_deg = 30_000.0;
    let encoder = &mut options.encoder;
    encoder.misalignment_first_deg = ECCENTRICITY_DEG;
    encoder.misalignment_second_deg = 0.5;
    encoder.misalignment_second_phase_deg = chance.gaussian(1e3) % 360.0;
    options
}

fn limits_of(half_mdeg: i32) -> Limits {
    Limits {
        range_mdeg: Some((-half_mdeg, half_mdeg)),
        ..LIMITS
    }
}

/// The harmonics of the plant's encoder, which shows `y = s x + z + a sin(n x + p)` at the angle
/// `x` of the shaft: of `n s (y - z) + p`, as the cosine and the sine of `n y` without the error;
/// deg.
fn truth(options: &BoardPlantOptions) -> [f64; 4] {
    let EncoderParameters {
        magnet_zero_deg,
        magnet_direction: direction,
        misalignment_first_deg: first_deg,
        misalignment_first_phase_deg: first_phase_deg,
        misalignment_second_deg: second_deg,
        misalignment_second_phase_deg: second_phase_deg,
        ..
    } = options.encoder;
    let pair = |order: f64, amplitude: f64, phase_deg: f64| {
        let phase_deg = phase_deg - order * direction * magnet_zero_deg;
        let (sin, cos) = phase_deg.to_radians().sin_cos();
        [amplitude * sin, amplitude * direction * cos]
    };
    let ([a, b], [c, d]) = (
        pair(1.0, first_deg, first_phase_deg),
        pair(2.0, second_deg, second_phase_deg),
    );
    [a, b, c, d]
}

#[test]
fn the_error_of_a_magnet_off_its_axis_is_found_within_three_standard_errors() {
    for seed in 0..12 {
        // Half of the range, and the largest standard error: on less than a turn the error once a
        // turn is hardly different from another torque constant.
        let (half_mdeg, largest_deg) =
            [(180_000, 0.015), (150_000, 0.044), (220_000, 0.007)][seed as usize % 3];
        let mut options = eccentric(seed);
        let (zero_deg, direction) = [(0, 1), (70, 1), (-110, -1)][seed as usize / 3 % 3];
        options.encoder.magnet_zero_deg = f64::from(zero_deg);
        options.encoder.magnet_direction = f64::from(direction);
        let mut client = client_within(&options, Defects::default(), 230.0);
        for (object, value) in [("2010:3", zero_deg), ("2010:4", direction)] {
            let written = client.write(object, &value.to_string());
            written.expect("the drive is off");
        }
        // That of before has no effect.
        client.write("2014:3", "300").expect("the drive is off");
        let found = measure(&mut client, &limits_of(half_mdeg));
        let found = found.unwrap_or_else(|error| panic!("bench {seed}: {error}"));
        let harmonics = found.encoder.harmonics.expect("a range of a turn");
        for (harmonic, truth) in harmonics.all().iter().zip(truth(&options)) {
            let z = (harmonic.value - truth) / harmonic.standard_error;
            let is_right = z.abs() < 3.0 && harmonic.standard_error < largest_deg;
            assert!(is_right, "bench {seed}: {harmonic:?} for {truth}");
        }
        // The other steps have the corrected angle.
        let relative = found.torque_constant_nm_a.value / constant_by_default_ratio(&options);
        assert!((relative - 1.0).abs() < 0.0025, "bench {seed}: {relative}");
        for (object, mdeg) in found.encoder.objects() {
            assert_eq!(client.integer(object).expect("an object") as f64, mdeg);
        }
        let page = page(&found, "an origin", true).render();
        assert!(page.contains("encoder twice a turn, sine") && page.contains("2014:4"));
    }
}

#[test]
fn the_error_is_left_as_it_is_where_the_range_is_less_than_five_sixths_of_a_turn() {
    let mut client = client_within(&eccentric(0), Defects::default(), 230.0);
    client.write("2014:2", "-700").expect("the drive is off");
    let found = measure(&mut client, &limits_of(149_000)).expect("a good bench");
    assert_eq!(found.encoder.objects(), []);
    assert_eq!(found.encoder.without_error, None);
    assert_eq!(client.integer("2014:2").expect("an object"), -700);
}

#[test]
fn the_stops_are_found_with_the_corrected_angle() {
    let mut options = eccentric(0);
    options.encoder.misalignment_first_phase_deg = 90.0;
    options.encoder.misalignment_second_phase_deg = 0.0;
    let stop_deg = 165.0;
    options.drivetrain.gear_train.hard_stop_deg = stop_deg;
    let mut client = client_within(&options, Defects::default(), 166.0);
    let limits = Limits {
        range_mdeg: None,
        ..LIMITS
    };
    let found = measure(&mut client, &limits).expect("a good bench");
    assert!(found.encoder.harmonics.is_some());
    // 3 deg within the stops, from the zero of the encoder: the shaft is at -1.376 deg there.
    let ((low, high), zero_deg) = (found.range_mdeg, -1.376);
    for (found_mdeg, end_deg) in [(low, 3.0 - stop_deg), (high, stop_deg - 3.0)] {
        let off_deg = f64::from(found_mdeg) * 1e-3 - (end_deg - zero_deg);
        assert!(off_deg.abs() < 0.5, "{low} to {high} mdeg");
    }
}

#[test]
fn a_magnet_far_off_its_axis_is_reported_and_what_was_stored_stays() {
    let mut options = eccentric(0);
    options.encoder.misalignment_first_deg = 3.5;
    options.encoder.misalignment_first_phase_deg = 0.0;
    let mut client = client_within(&options, Defects::default(), 230.0);
    client.write("2014:2", "-700").expect("the drive is off");
    let found = measure(&mut client, &limits_of(180_000)).expect("a good bench");
    let why = found.encoder.without_error.as_ref().expect("a reason");
    assert!(why.ends_with("the magnet is off its axis"), "{why}");
    assert_eq!(client.integer("2014:2").expect("an object"), -700);
    let page = page(&found, "an origin", true).render();
    assert!(page.contains("The error of the encoder is not written: an error of 3"));
}
