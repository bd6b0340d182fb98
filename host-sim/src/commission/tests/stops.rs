//! The stops of the shaft, where no range is given.

use model_core::plant::board::{BoardPlantOptions, Defects};

use super::bench::{LIMITS, client_of, client_within};
use crate::commission::{Limits, measure};

#[test]
fn without_a_range_the_stops_are_found_and_the_range_lies_within_them() {
    const FIND: Limits = Limits {
        range_mdeg: None,
        ..LIMITS
    };
    for (seed, stop_deg) in [(0, 30.0), (1, 75.0), (2, 120.0)] {
        let mut options = BoardPlantOptions::another_servo(seed);
        options.drivetrain.gear_train.hard_stop_deg = stop_deg;
        let mut client = client_within(&options, Defects::default(), stop_deg);
        let found = measure(&mut client, &FIND).expect("a good bench");
        let (low, high) = found.range_mdeg;
        // The margin of 3 deg, the eccentricity of up to 0.7 deg, and what the gears yield.
        for (limit, sign) in [(low, -1.0), (high, 1.0)] {
            let within_deg = stop_deg - f64::from(limit) * 1e-3 * sign;
            assert!(
                (2.0..4.0).contains(&within_deg),
                "bench {seed}: {limit} mdeg"
            );
        }
    }
    let mut options = BoardPlantOptions::another_servo(3);
    options.drivetrain.gear_train.hard_stop_deg = 30_000.0;
    let error = measure(
        &mut client_within(&options, Defects::default(), 400.0),
        &FIND,
    );
    let error = error.expect_err("no stop").to_string();
    assert!(error.contains("no stop within 360 deg"), "{error}");
}

#[test]
fn a_shaft_that_sticks_is_not_at_its_stop() {
    const FIND: Limits = Limits {
        range_mdeg: None,
        ..LIMITS
    };
    let mut options = BoardPlantOptions::another_servo(1);
    options.drivetrain.gear_train.hard_stop_deg = 75.0;
    let mut client = client_of(&options, Defects::default(), 75.0, Some(40.0));
    let error = measure(&mut client, &FIND).expect_err("no stop at 40 deg");
    let error = error.to_string();
    assert!(error.contains("it sticks"), "{error}");
}
