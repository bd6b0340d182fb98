use model_core::actuator::{ModelKind, PlantKind, Settings};
use model_core::excitation::catalogue::Input;

use super::*;

/// A model without limits of its rate that the input reaches.
fn settings(model: ModelKind, set: &[(&str, f64)]) -> Settings {
    let mut settings = Settings::new(model, PlantKind::FirstOrder);
    let free = [("rate_limit_up_deg_s", 1e5), ("rate_limit_down_deg_s", 1e5)];
    for (name, value) in free.iter().chain(set) {
        settings.set(name, *value).expect("a parameter");
    }
    settings
}

fn exported(settings: &Settings, target: &str) -> Export {
    let target = named(target).expect("a target");
    let input = Input::named(INPUT).expect("an input");
    export(settings, target, &input, None).expect("an approximation")
}

/// The number behind `key` in a file.
fn number_after(text: &str, key: &str) -> f64 {
    let rest = text.split(key).nth(1).expect("the key");
    let end = rest.find(|c: char| !(c.is_ascii_digit() || ".-e".contains(c)));
    rest[..end.unwrap_or(rest.len())].parse().expect("a number")
}

#[test]
fn a_first_order_lag_is_a_transfer_function_exactly() {
    let set = [
        ("pole_rad_s", 17.0),
        ("delay_s", 0.0125),
        ("gain", 0.9),
        ("offset_deg", 2.0),
    ];
    let lag = settings(ModelKind::BlackBox1, &set);
    let matlab = exported(&lag, "matlab");
    // The model's own steps of 50 us and its fixed-point command.
    assert!(matlab.error_deg < 1e-3, "{}", matlab.text);
    let expected = "servo = tf(15.3, [1, 17], 'InputDelay', 0.0125);\n";
    assert!(matlab.text.ends_with(expected), "{}", matlab.text);
    assert!(matlab.text.contains("0.9 c + 2 deg"), "{}", matlab.text);
    let python = exported(&lag, "python-control");
    assert!(python.text.contains("control.tf([15.3], [1, 17])"));
}

#[test]
fn a_lag_in_jsbsim_has_the_pole_of_tustins_rule() {
    let lag = settings(
        ModelKind::BlackBox1,
        &[("pole_rad_s", 17.0), ("delay_s", 0.0)],
    );
    let found = exported(&lag, "jsbsim");
    // exp(-p T) = (2 - a T)/(2 + a T); the step itself comes half a sample early.
    let step_s = named("jsbsim").expect("a target").step_s();
    let pole = (-17.0 * step_s).exp();
    let expected = 2.0 / step_s * (1.0 - pole) / (1.0 + pole);
    let fitted = number_after(&found.text, "<lag>");
    assert!((fitted / expected - 1.0).abs() < 0.1, "{fitted} {expected}");
}

#[test]
fn an_oscillator_is_a_joint_with_its_stiffness_and_damping() {
    let set = [
        ("position_gain_per_s2", 400.0),
        ("rate_gain_per_s", 30.0),
        ("delay_s", 0.01),
    ];
    let oscillator = settings(ModelKind::BlackBox2, &set);
    for target in ["mujoco-position", "mujoco-dcmotor"] {
        let found = exported(&oscillator, target);
        // Euler steps of 2 ms shift damping and delay by parts of a step.
        assert!(found.error_deg < 0.1, "{}", found.text);
        assert!(found.text.contains("delay=\"0.009\""), "{}", found.text);
        let inertia = number_after(&found.text, "armature=\"");
        let key = if target == "mujoco-position" {
            "kp=\""
        } else {
            "controller=\""
        };
        let square = number_after(&found.text, key) / inertia;
        assert!((square / 400.0 - 1.0).abs() < 0.05, "{square}");
    }
}

#[test]
fn a_step_is_one_that_the_simulator_has() {
    let lag = settings(ModelKind::BlackBox1, &[("pole_rad_s", 17.0)]);
    let target = named("ardupilot-sitl").expect("a target");
    let input = Input::named(INPUT).expect("an input");
    for step_s in [1.0 / 1200.0, 0.0007, 0.00015, 0.003, 0.0137] {
        let found = export(&lag, target, &input, Some(step_s)).expect("an approximation");
        let stated = number_after(&found.text, "in steps of ");
        // Of `Aircraft::setup_frame_time`, in whole us.
        let rate_hz = number_after(&found.text, "SIM_RATE_HZ ");
        let run_us = (1e6 / rate_hz) as u32;
        assert_eq!((stated * 1e6).round() as u32, run_us, "{}", found.text);
        assert!((stated / step_s - 1.0).abs() < 0.03, "{}", found.text);
    }
}

#[test]
fn every_target_says_what_it_loses_of_a_servo() {
    let servo = Settings::new(ModelKind::Board, PlantKind::Drivetrain);
    for target in TARGETS {
        let found = exported(&servo, target.name());
        assert!(found.error_deg < 0.3 * found.spread_deg, "{}", found.text);
        let error = format!("{:.4} deg rms", found.error_deg);
        assert!(found.text.contains(&error), "{}", found.text);
        assert!(found.lost.contains(&"backlash"), "{}", found.text);
        let is_stated = |lost: &&&str| found.text.contains(**lost);
        assert_eq!(
            found.lost.iter().filter(is_stated).count(),
            found.lost.len()
        );
        let has_delay = target.kept().contains(&Effect::Delay);
        assert_eq!(!has_delay, found.lost.contains(&"the delay of the command"));
    }
}

#[test]
fn the_error_is_that_on_an_input_to_which_the_law_is_not_fitted() {
    let servo = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    let target = named("jsbsim").expect("a target");
    for (first, second, validation, size) in [
        (INPUT, "log-chirp", "variable-step", ("scale", 7.0 / 120.0)),
        ("log-chirp", INPUT, "variable-step", ("scale", 7.0 / 120.0)),
        ("chirp", INPUT, "variable-step", ("scale", 7.0 / 120.0)),
        ("variable-step", "log-chirp", INPUT, ("amplitude_deg", 7.0)),
    ] {
        let mut input = Input::named(first).expect("an input");
        let (name, amplitude) = match first {
            "variable-step" => ("scale", 7.0 / 120.0),
            _ => ("amplitude_deg", 7.0),
        };
        input.set(name, amplitude).expect("an amplitude");
        let found = export(&servo, target, &input, None).expect("an approximation");
        let inputs = format!("on the inputs {first} and {second} with an amplitude of ");
        let unseen = format!("on the input {validation} with this amplitude, to which it is not");
        let stated = [inputs, unseen].map(|it| found.text.contains(&it));
        assert_eq!(stated, [true; 2], "{}", found.text);
        let mut unseen = Input::named(validation).expect("an input");
        unseen.set(size.0, size.1).expect("an amplitude");
        let response = Response::of(&servo, &[unseen], target.step_s()).expect("a response");
        // The amplitude of a sweep is that at the steps.
        let amplitude_deg = number_after(&found.text, "with an amplitude of ");
        assert!((amplitude_deg - 7.0).abs() < 1e-3, "{}", found.text);
        assert!((found.spread_deg - response.spread_deg()).abs() < 1e-3);
    }
}

#[test]
fn a_rate_limited_model_is_a_joint_without_damping_in_the_actuator() {
    // With it the fit is 0.4 % better, at a stiffness of 13,904 Nm/rad and 391 Nm.
    let servo = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    let found = exported(&servo, "mujoco-position");
    assert!(found.text.contains("kv=\"0\""), "{}", found.text);
    let limit_nm = number_after(&found.text, "forcerange=\"-");
    let rate_deg_s = (limit_nm / number_after(&found.text, " damping=\"")).to_degrees();
    // Between the rate limits of the two directions.
    assert!((240.0..350.0).contains(&rate_deg_s), "{}", found.text);
}

#[test]
fn the_document_states_the_errors_of_the_default_models() {
    let document = include_str!("../../../docs/identification.md");
    let mut stated = 0;
    for row in document.lines().filter(|row| row.starts_with("| `")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let target = cells[1].split('`').nth(1).and_then(named);
        let (Some(target), [.., of_black_box, of_bench, _]) = (target, &*cells) else {
            continue;
        };
        let models = [
            (
                Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder),
                of_black_box,
            ),
            (
                Settings::new(ModelKind::Board, PlantKind::Drivetrain),
                of_bench,
            ),
        ];
        for (settings, expected_deg) in models {
            let found = exported(&settings, target.name());
            let expected: f64 = expected_deg.parse().expect("a number");
            // Half of the last digit, and rounding.
            let off_deg = found.error_deg - expected;
            assert!(off_deg.abs() < 0.0051, "{row} {}", found.text);
            stated += 1;
        }
    }
    // One row is that of two targets with the same transfer function.
    assert_eq!(stated, 2 * (TARGETS.len() - 1));
}

#[test]
fn large_steps_export_the_ratio_of_the_rate_limits() {
    let servo = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    let input = Input::named("variable-step").expect("an input");
    let target = named("jsbsim").expect("a target");
    let found = export(&servo, target, &input, None).expect("an approximation");
    let limit = |sense| number_after(&found.text, &format!("sense=\"{sense}\">"));
    // The rate is limited in the whole sweep, in which the shaft drifts by this ratio.
    let ratio = limit("decr") / limit("incr");
    assert!(
        (ratio / (350.0 / 240.0) - 1.0).abs() < 0.02,
        "{}",
        found.text
    );
}

#[test]
fn what_a_target_cannot_represent_is_an_error_that_says_how_far_off_it_is() {
    // Limits that differ by direction, at their most: linear models cannot follow.
    let servo = Settings::new(ModelKind::BlackBox1, PlantKind::FirstOrder);
    let input = Input::named("variable-step").expect("an input");
    let target = named("matlab").expect("a target");
    let error = export(&servo, target, &input, None).expect_err("no approximation");
    let ExportError::Unlike {
        error_deg,
        spread_deg,
        ..
    } = error
    else {
        panic!("{error}")
    };
    assert!(error_deg > 0.5 * spread_deg);
    let error = export(&servo, target, &input, Some(1.0)).expect_err("no simulation");
    assert_eq!(
        error.to_string(),
        "the period is 1 s, expected 0.0001 to 0.05 s"
    );
}
