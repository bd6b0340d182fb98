//! Energy balance: electrical energy equals heat, kinetic and elastic energy.

use super::super::*;
use super::{FULL, drivetrain, ideal};

/// Checks supplied energy minus heat and stored energy; steps of 1 us and the trapezoidal rule
/// leave an error of about 1e-4 of the energy.
fn energy_balance(p: &DrivetrainParameters) {
    let mut b = drivetrain(p);
    let (mut electrical, mut heat, mut work) = (0.0, 0.0, 0.0);
    let step = 1e-6;
    for i in 0..200_000 {
        let terminal = [
            FULL,
            Terminal::Brake,
            Terminal::Driven(-4.0),
            Terminal::Coast,
        ][i / 50_000];
        let before = b.reading();
        b.advance(terminal, step);
        let after = b.reading();
        let mean = |f: fn(&Reading) -> f64| (f(&before) + f(&after)) / 2.0 * step;
        // The voltage is that after the bridge has switched.
        electrical += after.terminal_v * mean(|r| r.current_a);
        heat += 7.7 * mean(|r| r.current_a * r.current_a);
        heat += after.friction_torque_nm * mean(|r| r.motor.rate_deg_s) / 320.0 * PI / 180.0;
        work += after.load_torque_nm * mean(|r| r.load.rate_deg_s) * PI / 180.0;
    }
    let magnetic = 1e-3 * b.reading().current_a * b.reading().current_a / 2.0;
    let stored = b.train.energy_j() + magnetic;
    let missing = electrical + work - heat - stored;
    assert!(electrical > 0.05);
    assert!(
        missing.abs() < 2e-3 * electrical,
        "{missing} of {electrical}"
    );
}

#[test]
fn electrical_energy_equals_heat_and_kinetic_energy() {
    energy_balance(&ideal());
}

#[test]
fn energy_balances_with_friction_and_a_spring_at_the_load() {
    let mut p = ideal();
    p.friction.friction_model = 4.0;
    p.friction.coulomb_friction_nm = 0.05;
    p.friction.viscous_friction_nm_s_deg = 1e-4;
    p.load.hinge_moment_nm_deg = 0.01;
    energy_balance(&p);
}

#[test]
fn energy_balances_in_flexible_shafts() {
    let mut p = ideal();
    p.gear_train.gear_stiffness_nm_deg = 0.5;
    p.gear_train.shaft_stiffness_nm_deg = 0.5;
    p.gear_train.gear_damping_nm_s_deg = 0.0;
    p.gear_train.shaft_damping_nm_s_deg = 0.0;
    p.gear_train.load_inertia_kg_m2 = 1e-3;
    energy_balance(&p);
}
