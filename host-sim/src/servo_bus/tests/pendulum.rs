//! Pendulums at the horns of servos, against closed forms.

use std::f64::consts::PI;

use model_core::plant::drivetrain::load::LoadParameters;
use servo_bus::tables::{sts, x};
use servo_bus::{MIDDLE, TURN};

use super::super::{Bus, Model, model};
use super::Bench;

/// Standard gravity, m/s^2 (ISO 80000-3).
const GRAVITY_M_S2: f64 = 9.80665;

const STEPS_RAD: f64 = TURN as f64 / (2.0 * PI);

fn servo_with(name: &str, mass_kg: f64, length_m: f64) -> (Model, Bench) {
    let model = model(name).expect("a model");
    let load = |_| LoadParameters {
        pendulum_mass_kg: mass_kg,
        pendulum_length_m: length_m,
        ..LoadParameters::default()
    };
    let bench = Bench {
        bus: Bus::with_loads(&model, 1, load, 0.0).expect("in range"),
        is_sts: name.starts_with("sts"),
    };
    (model, bench)
}

/// Angle from the middle in steps, as the bus reads it.
fn angle(bench: &mut Bench) -> i32 {
    let field = if bench.is_sts {
        sts::PRESENT_POSITION
    } else {
        x::PRESENT_POSITION
    };
    bench.read(field) - MIDDLE
}

#[test]
fn a_servo_without_torque_swings_with_the_inertia_of_its_gears_and_its_pendulum() {
    for (mass_kg, length_m) in [(10.0, 0.05), (5.0, 0.1)] {
        let (model, mut bench) = servo_with("xm430-w350", mass_kg, length_m);
        bench.write(x::TORQUE_ENABLE, 1);
        bench.write(x::GOAL_POSITION, MIDDLE + 400);
        bench.run(2000);
        assert!(
            (angle(&mut bench) - 400).abs() < 60,
            "{}",
            angle(&mut bench)
        );
        bench.write(x::TORQUE_ENABLE, 0);
        // The periods in which it passes the middle, and its amplitude in between.
        let mut passed = Vec::new();
        let (mut before, mut amplitude) = (angle(&mut bench), 0);
        for period in 0..1000 {
            bench.run(1);
            let now = angle(&mut bench);
            if (now < 0) != (before < 0) {
                passed.push(f64::from(period));
            }
            if passed.len() == 1 {
                amplitude = amplitude.max(now.abs());
            }
            before = now;
        }
        let gears = model.drivetrain(LoadParameters::default()).gear_train;
        let rotor = gears.motor_inertia_kg_m2 * gears.gear_ratio * gears.gear_ratio;
        let inertia = rotor + mass_kg * length_m * length_m;
        let weight_nm = mass_kg * GRAVITY_M_S2 * length_m;
        let amplitude = f64::from(amplitude) / STEPS_RAD;
        // Half a period of a pendulum, with the first term of its amplitude. The friction of the
        // gears, 14 % of the torque, changes it by less than 2 %; without the inertia of the rotor
        // it would be shorter by 20 % and more.
        let half_ms = 1e3 * PI * (inertia / weight_nm).sqrt() * (1.0 + amplitude.powi(2) / 16.0);
        let measured_ms = passed[1] - passed[0];
        assert!(
            (measured_ms / half_ms - 1.0).abs() < 0.02,
            "{measured_ms} ms, {half_ms} ms"
        );
    }
}

#[test]
fn the_mean_current_of_lifting_and_lowering_is_that_of_the_weight_at_each_angle() {
    let (mass_kg, length_m) = (1.13, 0.12);
    let (model, mut bench) = servo_with("sts3250", mass_kg, length_m);
    let motor = model.drivetrain(LoadParameters::default());
    let constant_nm_a = motor.electrical.torque_constant_nm_a * motor.gear_train.gear_ratio;
    bench.write(sts::OPERATING_MODE, 1);
    bench.write(sts::TORQUE_ENABLE, 1);
    // The sums of currents within 1 deg of each of these angles, upwards and downwards.
    const ANGLES: [f64; 6] = [-90.0, -60.0, -30.0, 30.0, 60.0, 90.0];
    let mut sums = [[(0.0, 0); 2]; ANGLES.len()];
    for (way, speed, end) in [
        (None, -400, -1200),
        (Some(0), 100, 1200),
        (Some(1), -100, -1200),
    ] {
        bench.write(sts::GOAL_VELOCITY, speed);
        while (angle(&mut bench) - end) * speed.signum() < 0 {
            bench.run(10);
            let degrees = f64::from(angle(&mut bench)) / STEPS_RAD * (180.0 / PI);
            let current = f64::from(bench.read(sts::PRESENT_CURRENT));
            let near = ANGLES.iter().position(|at| (degrees - at).abs() < 1.0);
            if let (Some(near), Some(way)) = (near, way) {
                let (sum, count) = &mut sums[near][way];
                (*sum, *count) = (*sum + current, *count + 1);
            }
        }
    }
    for (degrees, ways) in ANGLES.iter().zip(sums) {
        let [up, down] = ways.map(|(sum, count)| sum / f64::from(count) * model.current_unit_a());
        // Friction, the same in both directions, is half the difference.
        let weight_nm = constant_nm_a * (up + down) / 2.0;
        let expected = mass_kg * GRAVITY_M_S2 * length_m * degrees.to_radians().sin();
        assert!(
            (weight_nm - expected).abs() < 0.01,
            "{degrees} deg: {weight_nm} Nm, {expected} Nm"
        );
    }
}
