//! Motors with friction, simulated by the model itself, because the simulated drivetrain has more
//! parts.

use super::*;
use crate::evaluation::unloaded;
use model_core::sensors::noise::Noise;

/// The output of a model with these parameters, as an encoder measures it.
fn answered(model: &str, mut recording: Recording, truth: &[(&str, f64)], seed: u64) -> Recording {
    let mut problem = problem(model, vec![recording.clone()]);
    for (name, value) in truth {
        problem.start(name, *value).expect("a parameter");
    }
    let value = |s: &crate::problem::Spec| {
        let known = recording.constants.get(s.parameter.name);
        known.copied().unwrap_or(s.start)
    };
    let values: Vec<f64> = problem.specs.iter().map(value).collect();
    let mut angles = vec![0.0; recording.len()];
    let run = &problem.experiments[0];
    let output = &mut |i: usize, sample: crate::Sample| angles[i] = sample.angle_deg;
    problem.model.simulate(run, &values, output);
    recording.angle_deg = angles;
    noisy(recording, seed)
}

/// A servo with friction M1.
const SERVO: [(&str, f64); 6] = [
    ("torque_constant_nm_a", 0.4),
    ("motor_inertia_kg_m2", 0.003),
    ("delay_s", 0.01),
    ("duty_per_error_pct_deg", 0.01),
    ("coulomb_friction_nm", 0.03),
    ("viscous_friction_nm_s_deg", 2e-4),
];

/// A slow double sine for a servo with a pendulum.
fn double_sine(gain: f64) -> Recording {
    let time_s: Vec<f64> = (0..400).map(|i| f64::from(i) * 0.015).collect();
    let command = |t: &f64| 60.0 * (2.1 * t).sin() * (0.37 * t).cos() + 20.0 * (5.0 * t).sin();
    let mut recording = Recording {
        name: "pendulum".into(),
        command_deg: time_s.iter().map(command).collect(),
        angle_deg: time_s.iter().map(|t| t.sin()).collect(),
        time_s,
        ..Default::default()
    };
    for (name, value) in [
        ("pendulum_mass_kg", 0.5),
        ("pendulum_length_m", 0.1),
        ("supply_v", 7.4),
        ("firmware_gain", gain),
    ] {
        recording.constants.insert(name.into(), value);
    }
    recording
}

/// The recording of a servo with friction M4 and an encoder of 12 bits.
fn pendulum(seed: u64, gain: f64) -> Recording {
    let more = [
        ("stribeck_friction_nm", 0.03),
        ("load_friction_motor", 0.1),
        ("load_stribeck_motor", 0.1),
    ];
    let truth = [&SERVO[..], &more].concat();
    answered("servo-m4", double_sine(gain), &truth, seed)
}

#[test]
fn a_richer_friction_model_fits_no_worse_and_predicts_better() {
    let options = Options {
        starts: 2,
        ..Default::default()
    };
    let left_out = Experiment::try_new(pendulum(2, 250.0)).expect("a recording");
    let errors = ["servo-m1", "servo-m3", "servo-m4"].map(|name| {
        let problem = problem(name, vec![pendulum(1, 100.0), pendulum(3, 400.0)]);
        let fit = fit(&problem, &options, &Quiet).expect("a fit");
        let prediction = predict(&problem, &fit, &left_out).expect("a prediction");
        (fit.cost, prediction.mean_absolute_error_deg())
    });
    let [one, three, four] = errors;
    assert!(four.0 <= three.0 && three.0 <= one.0, "{errors:?}");
    assert!(four.1 < 0.5 * one.1, "{errors:?}");
}

#[test]
fn a_model_that_fits_not_significantly_better_is_reduced_to_the_nested_one() {
    let recording = answered("servo-m1", double_sine(100.0), &SERVO, 4);
    let fits = ["servo-m1", "servo-m3"].map(|name| fitted(&problem(name, vec![recording.clone()])));
    let [simple, rich] = fits;
    assert_eq!(simple.no_better_than, None);
    assert_eq!(rich.no_better_than, Some("servo-m1"));
    let beyond = rich.estimate("load_friction_motor").expect("an estimate");
    assert_eq!((beyond.value, beyond.identifiable), (0.0, false));
    // Both are searched once more without the viscous friction, from points a millionth of the cost
    // apart, and friction has small minima; a significant difference is a fortieth.
    assert!(
        (rich.cost / simple.cost - 1.0).abs() < 1e-4,
        "{} {}",
        rich.cost,
        simple.cost
    );
}

#[test]
fn a_pendulum_swings_freely_while_its_motor_is_off() {
    let mut recording = pendulum(1, 100.0);
    let motor_on = recording
        .time_s
        .iter()
        .map(|t| f64::from(u8::from(*t < 3.0)));
    recording.motor_on = Some(motor_on.collect());
    let truth = [
        ("torque_constant_nm_a", 0.4),
        ("motor_inertia_kg_m2", 0.003),
        ("delay_s", 0.01),
        ("duty_per_error_pct_deg", 0.01),
        ("coulomb_friction_nm", 0.005),
        ("viscous_friction_nm_s_deg", 2e-5),
    ];
    let recording = answered("servo-m1", recording, &truth, 3);
    let fit = fitted(&problem("servo-m1", vec![recording]));
    // The whole recording is compared, because the swing determines inertia and friction.
    assert_eq!(fit.samples, 400);
    for (name, truth) in truth {
        let e = fit.estimate(name).expect("an estimate");
        let error = (e.value - truth).abs();
        assert!(error < 4.0 * e.standard_error, "{e:?}");
    }
}

#[test]
fn a_motor_is_identified_from_its_logged_duty() {
    let mut recording = pendulum(1, 100.0);
    let duty = recording
        .time_s
        .iter()
        .map(|t| 25.0 * (5.0 * t).sin() * (0.9 * t).cos() + 15.0 * (1.3 * t).sin());
    recording.duty_pct = Some(duty.collect());
    let truth = [
        ("torque_constant_nm_a", 0.5),
        ("winding_resistance_ohm", 3.0),
        ("motor_inertia_kg_m2", 0.002),
        ("delay_s", 0.004),
        ("coulomb_friction_nm", 0.05),
        ("viscous_friction_nm_s_deg", 3e-4),
    ];
    let recording = answered("motor-m1", recording, &truth, 5);
    let mut again = problem("motor-m1", vec![recording]);
    again
        .fix("winding_resistance_ohm", 3.0)
        .expect("a parameter");
    let fit = fitted(&again);
    for (name, truth) in truth
        .into_iter()
        .filter(|(name, _)| *name != "winding_resistance_ohm")
    {
        let e = fit.estimate(name).expect("an estimate");
        let error = (e.value - truth).abs();
        assert!(
            error < 4.0 * e.standard_error.max(e.standard_error_coloured),
            "{e:?}"
        );
    }
}

#[test]
fn resistance_torque_constant_and_viscous_friction_are_not_identifiable_together() {
    let mut recording = pendulum(1, 100.0);
    let duty = recording.angle_deg.iter().map(|a| a / 2.0);
    recording.duty_pct = Some(duty.collect());
    let mut problem = problem("motor-m1", vec![recording]);
    problem.free("winding_resistance_ohm").expect("a parameter");
    let fit = fitted(&problem);
    for name in ["torque_constant_nm_a", "winding_resistance_ohm"] {
        assert!(
            !fit.estimate(name).expect("an estimate").identifiable,
            "{name}"
        );
    }
}

#[test]
fn a_motor_without_logged_duty_is_refused() {
    let run = Experiment::try_new(pendulum(1, 100.0)).expect("a recording");
    let motor = models::named("motor-m1").expect("a model");
    assert!(matches!(
        Problem::try_new(motor, vec![run]),
        Err(IdentifyError::Recording { .. })
    ));
}

#[test]
fn friction_is_bounded_to_the_range_of_small_servos_by_default() {
    let name = "viscous_friction_nm_s_deg";
    let mut problem = problem("servo-m4", vec![pendulum(1, 100.0)]);
    let high = |p: &Problem| {
        let spec = p.specs.iter().find(|s| s.parameter.name == name);
        spec.expect("a parameter").high
    };
    // 1 Nm s/rad.
    assert_eq!(high(&problem), 1.0_f64.to_radians());
    problem.bound(name, 0.0, 0.1).expect("a bound");
    assert_eq!(high(&problem), 0.1);
}

#[test]
fn viscous_friction_behind_a_gear_is_found() {
    let time_s: Vec<f64> = (0..1500).map(|i| f64::from(i) * 0.004).collect();
    let duty = |t: &f64| [60.0, -40.0, 15.0][(t / 0.6) as usize % 3];
    let mut recording = Recording {
        duty_pct: Some(time_s.iter().map(duty).collect()),
        command_deg: vec![0.0; time_s.len()],
        angle_deg: time_s.iter().map(|t| t.sin()).collect(),
        time_s,
        ..Default::default()
    };
    for (name, value) in [
        ("winding_resistance_ohm", 5.0),
        ("gear_ratio", 50.0),
        ("torque_constant_nm_a", 0.5),
    ] {
        recording.constants.insert(name.into(), value);
    }
    // At the output 0.01 Nm s/rad of the motor are 25.
    let truth = [
        ("motor_inertia_kg_m2", 0.01),
        ("delay_s", 0.0),
        ("coulomb_friction_nm", 1.0),
        ("viscous_friction_nm_s_deg", 25.0 * 1.0_f64.to_radians()),
    ];
    let fit = fitted(&problem(
        "motor-m1",
        vec![answered("motor-m1", recording, &truth, 1)],
    ));
    for (name, value) in truth.into_iter().filter(|(_, value)| *value > 0.0) {
        let estimate = fit.estimate(name).expect("an estimate");
        let errors = (estimate.value - value).abs() / estimate.standard_error_coloured;
        assert!(
            errors < 3.0 && estimate.standard_error_coloured < 0.1 * value,
            "{estimate:?}"
        );
    }
}

#[test]
fn of_an_unloaded_motor_only_ratios_are_known() {
    let mut noise = Noise::new(1, 0);
    for seed in 0..6 {
        let (recording, truth) = unloaded(&mut noise).expect("a response");
        let fit = fitted(&problem("motor-m1", vec![noisy(recording, seed)]));
        let scaled = &truth[..4];
        for (name, _) in scaled {
            let estimate = fit.estimate(name).expect("an estimate");
            assert!(!estimate.identifiable, "{seed} {estimate:?}");
            assert!(estimate.standard_error.is_nan(), "{seed} {estimate:?}");
        }
        // A friction at its bound of zero has no combination of its own.
        assert!(fit.combinations.len() >= 2, "{seed} {:?}", fit.combinations);
        let value = |index: usize| {
            let name = fit.estimates[index].name;
            let known = truth.iter().find(|(known, _)| *known == name);
            known.map_or(f64::NAN, |(_, value)| *value)
        };
        // Those with the viscous friction are linear near the estimate, and the truth is not.
        let is_ratio = |c: &&crate::fit::Combination| {
            c.terms.iter().all(|(_, power)| power.abs() == 1.0) && c.is_product
        };
        let ratios: Vec<_> = fit.combinations.iter().filter(is_ratio).collect();
        assert_eq!(ratios.len(), 2, "{seed} {:?}", fit.combinations);
        for ratio in ratios {
            let powers = ratio
                .terms
                .iter()
                .map(|(index, power)| value(*index).powf(*power));
            let truth: f64 = powers.product();
            let error = ratio.standard_error.max(ratio.standard_error_coloured);
            // Far more than the error for noise: the cost of a model with friction has small
            // minima.
            assert!(
                (ratio.value / truth - 1.0).abs() < 0.02,
                "{seed} {ratio:?} {truth}"
            );
            assert!(error < 0.05 * truth, "{seed} {ratio:?}");
        }
    }
}
