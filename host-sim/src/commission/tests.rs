//! Benches with secret parameters: what is measured of them, refused, and written.

mod bench;
mod centre;
mod encoder;
mod other_motor;
mod saved;
mod stops;

use model_core::plant::board::{BoardPlantOptions, Defects};
use model_core::plant::drivetrain::DrivetrainParameters;

pub use self::bench::{LIMITS, client};
use super::runs::arrive;
use super::{
    Baseline, Comparison, Contradiction, Findings, Friction, Kept, Limits, Parameter, find,
    measure, page, tune, write,
};
use crate::table::Cell;

/// The torque constant by the ratio 2011h:3, which is not measured: the default.
fn constant_by_default_ratio(options: &BoardPlantOptions) -> f64 {
    let DrivetrainParameters {
        electrical,
        gear_train,
        ..
    } = options.drivetrain;
    let ratio = DrivetrainParameters::default().gear_train.gear_ratio;
    electrical.torque_constant_nm_a * gear_train.gear_ratio / ratio
}

/// The share of an eccentric magnet in the standard error would hide a wrong gain. What is left is
/// 0.2 % by the ripple of the rate, which is lowest at the scan. The charge of the converter's
/// capacitor alone makes 0.3 %.
#[test]
fn with_a_centred_magnet_the_torque_constant_is_within_a_quarter_of_a_percent() {
    for seed in 0..5 {
        let mut options = BoardPlantOptions::another_servo(seed);
        options.encoder.misalignment_first_deg = 0.0;
        let found = measure(&mut client(&options, Defects::default()), &LIMITS);
        let value = found.expect("a good bench").torque_constant_nm_a.value;
        let relative = value / constant_by_default_ratio(&options);
        assert!((relative - 1.0).abs() < 0.0025, "bench {seed}: {relative}");
    }
}

/// A uniform error at its end is 1.7 standard errors; the rest is that of the fit.
#[test]
fn with_a_magnet_at_its_tolerance_the_inertia_is_within_two_standard_errors() {
    for phase_deg in [0.0, 180.0] {
        let mut options = BoardPlantOptions::another_servo(0);
        options.encoder.misalignment_first_deg = super::runs::ECCENTRICITY_DEG;
        options.encoder.misalignment_first_phase_deg = phase_deg;
        let found = measure(&mut client(&options, Defects::default()), &LIMITS);
        let estimate = found.expect("a good bench").dynamics.inertia_kg_m2;
        let truth = options.drivetrain.gear_train.inertia_kg_m2();
        let z = (estimate.value - truth) / estimate.standard_error;
        assert!(z.abs() < 2.0, "{phase_deg} deg: {z}");
    }
}

/// The excitations are constants, which the board limits. With the usual limits the error is 3 %,
/// by resistance, gains and magnet.
#[test]
fn with_lower_limits_of_rate_and_current_the_error_of_the_inertia_stays_below_4_percent() {
    for (rate_mdeg_s, permille) in [(40_000, 1000), (15_000, 1000), (120_000, 400)] {
        for seed in 0..3 {
            let options = BoardPlantOptions::another_servo(seed);
            let limits = Limits {
                rate_mdeg_s,
                permille,
                ..LIMITS
            };
            let found = measure(&mut client(&options, Defects::default()), &limits);
            let estimate = found.expect("a good bench").dynamics.inertia_kg_m2;
            let truth = options.drivetrain.gear_train.inertia_kg_m2();
            let z = (estimate.value - truth) / estimate.standard_error;
            assert!(
                z.abs() < 3.0 && estimate.standard_error < 0.04 * truth,
                "bench {seed}, {rate_mdeg_s} mdeg/s, {permille} of 1000: {estimate:?}, {z}"
            );
        }
    }
}

#[test]
fn gains_are_verified_and_a_baseline_is_taken_within_a_lower_limit_of_the_current() {
    let mut client = client(&BoardPlantOptions::another_servo(0), Defects::default());
    let kept = Kept::of(&mut client).expect("values");
    // It counts, not the limit of the commissioning.
    client.write("6073", "600").expect("in range");
    let found = find(&mut client, &LIMITS, (&kept, true), |_| {}).expect("a good bench");
    let disagreements = found.tuning.expect("it was tuned").disagreements;
    assert!(disagreements.is_empty(), "{disagreements:?}");
    let baseline = found.baseline.expect("it was taken");
    assert_eq!(baseline.without_baseline, None);
    kept.restore(&mut client).expect("the drive is off");
    assert_eq!(client.integer("6072").expect("a limit"), 65_535);
    client.write("6073", "0").expect("in range");
    let error = measure(&mut client, &LIMITS).expect_err("no current");
    assert!(error.to_string().contains("6073h is 0"), "{error}");
}

/// Half to twice 2011h:1 is permitted.
#[test]
fn a_motor_of_another_resistance_than_its_object_is_measured() {
    for factor in [0.6, 1.6] {
        let mut options = BoardPlantOptions::default();
        let motor = &mut options.drivetrain.electrical;
        motor.winding_resistance_ohm *= factor;
        let truth = motor.winding_resistance_ohm;
        let found = measure(&mut client(&options, Defects::default()), &LIMITS);
        let found = found.expect("a good motor").resistance_ohm;
        let z = (found.value - truth) / found.standard_error;
        assert!(z.abs() < 3.0, "{truth} ohm: {found:?}");
    }
}

#[test]
fn the_shaft_moves_for_less_than_two_minutes_and_not_beyond_the_rate_that_was_set() {
    for (seed, half_deg) in [(0, 45), (1, 45), (2, 160)] {
        let mut options = BoardPlantOptions::another_servo(seed);
        options.drivetrain.gear_train.hard_stop_deg = 170.0;
        let (mut client, moved) = bench::observed_client(&options, half_deg.into());
        let limits = Limits {
            range_mdeg: Some((-1000 * half_deg, 1000 * half_deg)),
            ..LIMITS
        };
        let kept = Kept::of(&mut client).expect("values");
        find(&mut client, &limits, (&kept, true), |_| {}).expect("a good bench");
        let moved = moved.lock().expect("no other thread");
        println!("bench {seed}: {moved:?}");
        assert!(moved.moving_s < 120.0, "bench {seed}: {moved:?}");
        // In single control periods the elastic gears and the ripple of the motor add up to 6 %.
        let limit_deg_s = f64::from(limits.rate_mdeg_s) * 1e-3;
        assert!(
            moved.greatest_deg_s < 1.08 * limit_deg_s,
            "bench {seed}: {moved:?}"
        );
    }
}

#[test]
fn the_baseline_is_that_of_later_moves_and_stays_where_these_do_not_show_it() {
    const BEFORE: [(&str, i64); 2] = [("2053:9", 900), ("2053:10", 700)];
    // Within a range that is given, and smaller than a turn.
    const STEPS: [&str; 6] = [
        "checks the wiring",
        "measures the resistance",
        "measures torque constant and friction",
        "measures inertia and delay",
        "finds gains, and verifies them",
        "takes the baseline of the health",
    ];
    let (mut with_supply, mut kept_before) = (0, 0);
    for seed in 0..5 {
        let mut client = client(&BoardPlantOptions::another_servo(seed), Defects::default());
        client.write("6081", "90000").expect("in range");
        for (object, value) in BEFORE {
            client.write(object, &value.to_string()).expect("in range");
        }
        let kept = Kept::of(&mut client).expect("values");
        let mut steps = Vec::new();
        let found = find(&mut client, &LIMITS, (&kept, true), |step| {
            steps.push(step.to_owned());
        });
        let found = found.expect("a good bench");
        assert_eq!(steps, STEPS);
        kept.restore(&mut client).expect("the drive is off");
        assert_eq!(client.integer("2053:1").expect("a baseline"), 0);
        write(&mut client, &found).expect("it saves");
        client.enable(1).expect("no fault");
        for _ in 0..20 {
            for end_mdeg in [40_000, -40_000] {
                arrive(&mut client, end_mdeg).expect("within the range");
            }
        }
        let baseline = found.baseline.expect("it is taken");
        assert_eq!(baseline.without_baseline, None, "bench {seed}");
        let objects = baseline.objects();
        assert!(baseline.standard_errors[0].is_some(), "bench {seed}");
        if baseline.supply_mohm > 0 {
            let later = client.integer("2052:9").expect("a mean");
            let permille = (later - baseline.supply_mohm) * 1000 / baseline.supply_mohm;
            assert!(permille.abs() < 200, "bench {seed}: {permille}");
            with_supply += 1;
        }
        for (object, before) in BEFORE {
            if objects.iter().all(|(found, _)| *found != object) {
                assert_eq!(client.integer(object).ok(), Some(before), "{object}");
                kept_before += 1;
            }
        }
        for (object, value) in objects {
            assert_eq!(client.integer(object).ok(), Some(value as i64), "{object}");
        }
        let friction = client.integer("2052:1").expect("a mean") as f64 / 10.0;
        // The codes of the converter are 1.6 mA.
        let difference_ma = friction - baseline.friction_ma;
        assert!(
            difference_ma.abs() < 3.0,
            "bench {seed}: {difference_ma} mA"
        );
        let permille = client.integer("2052:7").expect("a change");
        assert!(permille.abs() < 10, "bench {seed}: {permille}");
    }
    assert_ne!(with_supply, 0, "a bench whose moves show the supply");
    assert_ne!(kept_before, 0, "a bench whose moves do not show all");
}

#[test]
fn the_page_shows_each_value_with_its_error_the_loop_and_what_is_not_written() {
    let mut client = client(&BoardPlantOptions::another_servo(0), Defects::default());
    let mut found = measure(&mut client, &LIMITS).expect("a good bench");
    found.tuning = Some(tune(&mut client, &found).expect("a tuning"));
    found.dynamics.contradictions.push(Contradiction {
        parameter: Parameter::Delay,
        text: "a contradiction".into(),
    });
    found.baseline = Some(Baseline {
        friction_ma: 0.1234,
        ..Baseline::default()
    });
    assert!(
        page(&found, "an origin", true)
            .render()
            .contains("Baseline of the health")
    );
    let without_baseline = Some("too few".to_owned());
    found
        .baseline
        .iter_mut()
        .for_each(|it| it.without_baseline.clone_from(&without_baseline));
    let page = page(&found, "an origin", false);
    let titles: Vec<_> = page.figures().map(|figure| figure.title.clone()).collect();
    assert_eq!(
        titles,
        [
            "Back-EMF of the runs",
            "Torque of the runs",
            "Chirp, against its fit",
            "Multisine, against the motor of the chirp",
            "From command to angle",
            "Step, against the prediction",
            "Moves with feed-forward, against the prediction",
        ]
    );
    // The motor of the chirp predicts the multisine nearly as well as the chirp.
    let rms_deg = |comparison: &Comparison| {
        let pairs = comparison
            .measured_deg
            .iter()
            .zip(&comparison.predicted_deg);
        let squares: Vec<f64> = pairs.map(|(a, b)| (a - b).powi(2)).collect();
        assert!(squares.len() > 500, "{}", squares.len());
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    let dynamics = &found.dynamics;
    let [fitted, predicted] = [&dynamics.identification, &dynamics.validation].map(rms_deg);
    println!("rms {fitted} deg of the chirp, {predicted} deg of the multisine");
    assert!(predicted < 2.0 * fitted.max(0.088), "{fitted} {predicted}");
    let text = page.render();
    for (name, unit, step, estimate) in found.estimates() {
        let value = Cell::significant(estimate.value).to_string();
        let error = Cell::significant(estimate.standard_error).to_string();
        for expected in [name, unit, step, &value, &error] {
            assert!(text.contains(expected), "{expected}");
        }
    }
    for (object, _) in found.objects() {
        assert!(text.contains(object), "{object}");
    }
    assert!(text.contains("an origin") && text.contains("a contradiction"));
    assert!(text.contains("baseline is not written: too few"));
    assert!(!text.contains("Baseline of the health"));
    assert!(text.contains("with feed-forward") && text.contains("least of all motors"));
    assert!(text.contains("Not written") && !text.contains("Written and saved"));
    // Four rates upward and downward, whose line is within 1 % of the greatest back-EMF, 2.4 V.
    let runs = &found.constant_rates;
    assert_eq!(runs.len(), 8);
    for run in runs {
        let residual_v = run.back_emf_v - run.rate_rad_s * found.back_emf_v_s.value;
        assert!(residual_v.abs() < 0.024, "{run:?}");
    }
}

#[test]
fn what_is_contradicted_or_not_known_is_not_stored() {
    let mut found = measure(
        &mut client(&BoardPlantOptions::another_servo(4), Defects::default()),
        &LIMITS,
    )
    .expect("a good bench");
    let objects = |found: &Findings| -> Vec<_> {
        found
            .objects()
            .into_iter()
            .map(|(object, _)| object)
            .collect()
    };
    let set_error = |found: &mut Findings, standard_error| {
        let Friction { upward, downward } = &mut found.friction;
        for direction in [upward, downward] {
            direction.viscous_nm_s.standard_error = standard_error;
        }
    };
    set_error(&mut found, 1.0);
    assert_eq!(objects(&found), ["2011:1", "2011:2", "2011:4", "2011:6"]);
    set_error(&mut found, 1e-5);
    assert!(objects(&found).contains(&"2011:5"));
    for parameter in [Parameter::Inertia, Parameter::Coulomb] {
        let text = String::new();
        found
            .dynamics
            .contradictions
            .push(Contradiction { parameter, text });
    }
    assert_eq!(objects(&found), ["2011:1", "2011:2", "2011:5"]);
}

/// With the Coulomb friction of the free fit the pair would be a fifth too great here.
#[test]
fn the_stored_pair_of_frictions_makes_the_torque_of_the_runs() {
    let held_nm_s = 0.01;
    for seed in 0..3 {
        let options = BoardPlantOptions::another_servo(seed);
        let mut client = client(&options, Defects::default());
        let text = f64::to_string(&held_nm_s);
        client.write("2011:5", &text).expect("in range");
        let found = measure(&mut client, &LIMITS).expect("a good bench");
        let objects = found.objects();
        let value = |name| objects.iter().find(|(object, _)| *object == name);
        assert_eq!(value("2011:5"), None, "bench {seed}");
        let (_, coulomb_nm) = *value("2011:6").expect("it is known");
        let DrivetrainParameters {
            gear_train,
            friction,
            ..
        } = options.drivetrain;
        // About the mean over time of runs of equal ways at 30 to 120 deg/s.
        let (mean_rad_s, viscous_nm_s) = (
            50.0_f64.to_radians(),
            friction.viscous_friction_nm_s_deg.to_degrees(),
        );
        let truth_nm = friction.coulomb_friction_nm
            + gear_train.bearing_friction_nm
            + viscous_nm_s * mean_rad_s;
        let Friction { upward, downward } = found.friction;
        let beside_nm = upward.coulomb_beside_nm.mean(downward.coulomb_beside_nm);
        let error = beside_nm.standard_error / truth_nm;
        let relative = (coulomb_nm + held_nm_s * mean_rad_s) / truth_nm;
        assert!(
            (relative - 1.0).abs() < 3.0 * error && error < 0.05,
            "bench {seed}: {relative} +- {error}"
        );
    }
}
