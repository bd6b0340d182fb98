mod energy;
mod robustness;

use super::stepped::SteppedDrivetrain;
use super::*;
use crate::plant::first_order::{FirstOrder, FirstOrderParameters};
use crate::plant::{PERIOD, Plant, Pwm};
use crate::time::TICK_S;

const FULL: Terminal = Terminal::Driven(6.0);

/// One rigid inertia without friction.
fn ideal() -> DrivetrainParameters {
    let mut p = DrivetrainParameters::default();
    p.gear_train.gear_stiffness_nm_deg = f64::INFINITY;
    p.gear_train.shaft_stiffness_nm_deg = f64::INFINITY;
    p.gear_train.backlash_deg = 0.0;
    p.gear_train.bearing_friction_nm = 0.0;
    p.gear_train.hard_stop_deg = 32000.0;
    p.friction.coulomb_friction_nm = 0.0;
    p.friction.viscous_friction_nm_s_deg = 0.0;
    p
}

fn without_stops() -> DrivetrainParameters {
    let mut p = DrivetrainParameters::default();
    p.gear_train.hard_stop_deg = 32000.0;
    p
}

fn drivetrain(p: &DrivetrainParameters) -> Drivetrain {
    Drivetrain::try_new(p).unwrap()
}

fn advance(drivetrain: &mut Drivetrain, terminal: Terminal, seconds: f64) {
    let ticks = libm::round(seconds / TICK_S) as u32;
    for _ in 0..ticks {
        drivetrain.advance(terminal, TICK_S);
    }
}

#[test]
fn a_rigid_drivetrain_without_friction_runs_up_to_the_closed_form_of_rate_and_current() {
    let p = ideal();
    let mut b = drivetrain(&p);
    advance(&mut b, FULL, 4.0);
    // Without friction: e = V, no current.
    let free_deg_s = 6.0 / (320.0 * 3.62e-3) * 180.0 / PI;
    assert!((b.reading().output.rate_deg_s - free_deg_s).abs() < 1e-6);
    assert!(b.reading().current_a.abs() < 1e-9);
    // Under 0.4 Nm against the motion: i = 0.4/(n k), e = V - R i.
    b.set_recorded_torque_nm(-0.4);
    advance(&mut b, FULL, 4.0);
    let current_a = 0.4 / (320.0 * 3.62e-3);
    assert!((b.reading().current_a - current_a).abs() < 1e-9);
    assert!((b.reading().back_emf_v - (6.0 - 7.7 * current_a)).abs() < 1e-9);
}

#[test]
fn the_default_drivetrain_has_the_no_load_rate_and_time_constant_of_the_paper() {
    let mut b = drivetrain(&without_stops());
    // A step around an operating point, from 50 % to 100 %: friction is then constant.
    advance(&mut b, Terminal::Driven(3.0), 3.0);
    let low = b.reading().output.rate_deg_s;
    advance(&mut b, FULL, 1.0 / 7.586);
    let after_one_time_constant = b.reading().output.rate_deg_s;
    advance(&mut b, FULL, 3.0);
    let high = b.reading().output.rate_deg_s;
    assert!((high - 283.6).abs() < 0.5, "{high}");
    let gain = (high - low) / 50.0;
    assert!((gain / 2.836 - 1.0).abs() < 0.04, "{gain}");
    // 1 - 1/e = 0.632, with a tolerance of 10 % of the time constant.
    let risen = (after_one_time_constant - low) / (high - low);
    assert!((0.60..0.67).contains(&risen), "{risen}");
}

#[test]
fn without_friction_the_drivetrain_follows_the_first_order_motor() {
    // The same gain and time constant: K = V/(n k), tau = R J/(n k)^2. The electrical lag of 0.13
    // ms, absent in the first-order motor, causes about 283 deg/s * 0.13 ms.
    let p = ideal();
    let constant: f64 = 320.0 * 3.62e-3;
    let motor = FirstOrderParameters {
        motor_gain_up: 0.06 / constant * 180.0 / PI,
        motor_time_constant_s: 7.7 * (2.27e-7 * 320.0 * 320.0 + 4e-6) / (constant * constant),
        position_limit_deg: 32000.0,
        ..Default::default()
    };
    // 33.3 % switches within a tick.
    for (pwm, duty_pct) in [(Pwm::Average, 100.0), (Pwm::Switched, 33.3)] {
        let mut simple = FirstOrder::try_new(motor, pwm).unwrap();
        let mut full = SteppedDrivetrain::try_new(&p, pwm).unwrap();
        for _ in 0..500 {
            simple.start_period(duty_pct);
            full.start_period(duty_pct);
            full.pass_to(PERIOD);
            let difference = simple.at(PERIOD).angle_deg - full.at(PERIOD).angle_deg;
            assert!(difference.abs() < 0.05, "{pwm:?}: {difference}");
        }
    }
}

#[test]
fn load_damping_reduces_the_no_load_rate_by_its_share_of_the_damping() {
    let mut p = ideal();
    p.load.load_damping_nm_s_deg = 1e-3;
    let mut b = drivetrain(&p);
    advance(&mut b, FULL, 2.0);
    // n k (V - n k w)/R = c w.
    let constant: f64 = 320.0 * 3.62e-3;
    let damping = 1e-3 * 180.0 / PI;
    let rate_rad_s = constant * 6.0 / 7.7 / (constant * constant / 7.7 + damping);
    assert!((b.reading().output.rate_deg_s - rate_rad_s * 180.0 / PI).abs() < 1e-6);
}

#[test]
fn the_output_lags_the_motor_by_the_backlash_after_a_reversal() {
    let mut p = without_stops();
    p.gear_train.backlash_deg = 1.0;
    p.gear_train.gear_stiffness_nm_deg = 50.0;
    let mut b = drivetrain(&p);
    let lead = |b: &Drivetrain| b.reading().motor.angle_deg / 320.0 - b.reading().output.angle_deg;
    advance(&mut b, Terminal::Driven(1.0), 1.0);
    let forward = lead(&b);
    advance(&mut b, Terminal::Driven(-1.0), 1.0);
    let width = forward - lead(&b);
    // The bearing friction of 2 mNm twists the gears by another 2 x 0.04 mdeg.
    assert!((width - 1.0).abs() < 1e-3, "{width}");
}

#[test]
fn the_output_is_at_rest_while_the_motor_crosses_the_backlash() {
    let mut p = without_stops();
    p.gear_train.backlash_deg = 2.0;
    let mut b = drivetrain(&p);
    advance(&mut b, Terminal::Driven(1.0), 1.0);
    advance(&mut b, Terminal::Brake, 1.0);
    let (start, motor) = (b.reading().output, b.reading().motor.angle_deg);
    assert_eq!(start.rate_deg_s, 0.0);
    let mut crossed = 0.0;
    while b.reading().output.angle_deg == start.angle_deg && crossed < 3.0 {
        b.advance(Terminal::Driven(-1.0), TICK_S);
        crossed = (motor - b.reading().motor.angle_deg) / 320.0;
    }
    // The output is anywhere in the gap, so the motor crosses at most the whole gap.
    assert!((0.5..2.01).contains(&crossed), "{crossed}");
}

#[test]
fn a_torque_below_the_breakaway_friction_moves_nothing_and_one_above_it_does() {
    let mut p = ideal();
    p.friction.friction_model = 2.0;
    p.friction.coulomb_friction_nm = 0.03;
    p.friction.stribeck_friction_nm = 0.02;
    // Breakaway at 0.05 Nm: V = R 0.05/(n k).
    let threshold_v = 7.7 * 0.05 / (320.0 * 3.62e-3);
    let mut b = drivetrain(&p);
    advance(&mut b, Terminal::Driven(threshold_v * (1.0 - 1e-9)), 1.0);
    assert_eq!(b.reading().output, PlantState::default());
    advance(&mut b, Terminal::Driven(threshold_v * (1.0 + 1e-6)), 1.0);
    assert!(b.reading().output.rate_deg_s > 0.0);
}

#[test]
fn load_dependent_friction_holds_a_load_that_coulomb_friction_alone_does_not() {
    let mut p = ideal();
    p.friction.coulomb_friction_nm = 0.05;
    p.friction.load_friction_motor = 0.5;
    p.load.load_torque_nm = 0.0999;
    p.friction.friction_model = 1.0;
    let mut slides = drivetrain(&p);
    advance(&mut slides, Terminal::Coast, 0.1);
    assert!(slides.reading().output.angle_deg > 0.1);
    // 0.05 + 0.5 tau holds all tau up to 0.1 Nm.
    p.friction.friction_model = 3.0;
    let mut holds = drivetrain(&p);
    advance(&mut holds, Terminal::Coast, 0.1);
    assert_eq!(holds.reading().output, PlantState::default());
    holds.set_recorded_torque_nm(2e-4);
    advance(&mut holds, Terminal::Coast, 0.1);
    assert!(holds.reading().output.angle_deg > 0.0);
}

#[test]
fn load_dependent_friction_holds_opposing_torques_and_not_aligned_ones() {
    let mut p = ideal();
    p.electrical.winding_inductance_h = 0.0;
    p.friction.friction_model = 3.0;
    p.friction.load_friction_motor = 0.5;
    let motor = Terminal::Driven(7.7 * 0.1 / (320.0 * 3.62e-3));
    // 0.1 Nm against 0.05 Nm load the gears with 0.15 Nm, half of which holds the difference of
    // 0.05 Nm.
    p.load.load_torque_nm = -0.05;
    let mut opposed = drivetrain(&p);
    advance(&mut opposed, motor, 0.1);
    assert_eq!(opposed.reading().output, PlantState::default());
    // 0.1 Nm aligned with 0.1 Nm do not load the gears.
    p.load.load_torque_nm = 0.1;
    let mut agreed = drivetrain(&p);
    agreed.advance(motor, TICK_S);
    assert!(agreed.reading().friction_torque_nm < 1e-15);
    assert!(agreed.reading().output.rate_deg_s > 0.0);
}

#[test]
fn a_braked_motor_stops_with_its_time_constant_and_a_coasting_one_continues() {
    let p = ideal();
    let mut braked = drivetrain(&p);
    advance(&mut braked, FULL, 2.0);
    let start = braked.reading().output.rate_deg_s;
    let mut coasting = braked.clone();
    // R J/(n k)^2 = 0.1334 s.
    advance(&mut braked, Terminal::Brake, 0.1334);
    advance(&mut coasting, Terminal::Coast, 0.1334);
    // The electrical lag of 0.13 ms shifts 1/e by 0.1 %.
    let left = braked.reading().output.rate_deg_s / start;
    assert!((left - libm::exp(-1.0)).abs() < 2e-3, "{left}");
    assert!((coasting.reading().output.rate_deg_s / start - 1.0).abs() < 1e-6);
    assert_eq!(coasting.reading().current_a, 0.0);
}

#[test]
fn coulomb_friction_decelerates_a_coasting_motor_linearly_to_exactly_zero() {
    let mut p = ideal();
    p.friction.coulomb_friction_nm = 0.05;
    let mut b = drivetrain(&p);
    advance(&mut b, FULL, 2.0);
    advance(&mut b, Terminal::Coast, 0.01);
    let start = b.reading().output.rate_deg_s;
    advance(&mut b, Terminal::Coast, 0.5);
    let slope = 0.05 / (2.27e-7 * 320.0 * 320.0 + 4e-6) * 180.0 / PI;
    assert!((b.reading().output.rate_deg_s - (start - slope * 0.5)).abs() < 1e-6);
    advance(&mut b, Terminal::Coast, start / slope - 0.5 + TICK_S);
    assert_eq!(b.reading().output.rate_deg_s, 0.0);
}

#[test]
fn a_bridge_that_coasts_in_the_off_time_runs_faster_at_partial_duty_than_one_that_brakes() {
    let mut p = without_stops();
    let mut rate = |coast| {
        p.electrical.coast_when_off = coast;
        let mut b = SteppedDrivetrain::try_new(&p, Pwm::Switched).unwrap();
        for _ in 0..1000 {
            b.start_period(30.0);
            b.pass_to(PERIOD);
        }
        b.at(PERIOD).rate_deg_s
    };
    let (braking, coasting) = (rate(0.0), rate(1.0));
    // Braking is equivalent to the mean voltage: K 30 % minus the effect of friction.
    assert!((braking - 78.2).abs() < 2.0, "{braking}");
    assert!(coasting > 1.5 * braking, "{coasting}");
}

#[test]
fn the_motor_stalls_at_the_hard_stop_with_its_closed_form_current() {
    let mut p = DrivetrainParameters::default();
    p.gear_train.hard_stop_deg = 30.0;
    let mut b = drivetrain(&p);
    // The rotor oscillates on the gear stiffness at 70 rad/s and settles with about 4/s.
    for _ in 0..60_000 {
        b.advance(FULL, TICK_S);
        assert!(b.reading().output.angle_deg <= 30.0 + 1e-12);
    }
    assert_eq!(b.reading().output.rate_deg_s, 0.0);
    assert!((b.reading().current_a - 6.0 / 7.7).abs() < 1e-9);
    // The gear twist is that of stall torque minus friction, plus half the backlash.
    let twist = b.reading().motor.angle_deg / 320.0 - 30.0;
    let stall_nm = 320.0 * 3.62e-3 * 6.0 / 7.7;
    assert!(
        (twist - (stall_nm / 2.0 + 0.05)).abs() < 0.028 / 2.0 + 1e-6,
        "{twist}"
    );
}

#[test]
fn a_pendulum_settles_where_its_weight_balances_the_motor_torque() {
    let mut p = ideal();
    p.load.pendulum_mass_kg = 1.0;
    p.load.pendulum_length_m = 0.1;
    p.load.load_damping_nm_s_deg = 0.01;
    let mut b = drivetrain(&p);
    advance(&mut b, Terminal::Driven(3.0), 10.0);
    let torque_nm = 320.0 * 3.62e-3 * 3.0 / 7.7;
    let angle_deg = libm::asin(torque_nm / (9.80665 * 0.1)) * 180.0 / PI;
    assert!((b.reading().output.angle_deg - angle_deg).abs() < 1e-3);
}

#[test]
fn very_stiff_and_infinitely_stiff_joints_agree() {
    let rigid = ideal();
    let mut stiff = rigid;
    stiff.gear_train.gear_stiffness_nm_deg = 100.0;
    stiff.gear_train.gear_damping_nm_s_deg = 1e-4;
    let (mut rigid, mut stiff) = (drivetrain(&rigid), drivetrain(&stiff));
    advance(&mut rigid, FULL, 0.3);
    advance(&mut stiff, FULL, 0.3);
    let difference = rigid.reading().output.angle_deg - stiff.reading().output.angle_deg;
    // The rigid one leads by half a step of 50 us at 287 deg/s.
    assert!(difference.abs() < 0.015, "{difference}");
}

#[test]
fn a_jammed_gear_train_stops_immediately_and_draws_the_stall_current() {
    let mut drivetrain = Drivetrain::try_new(&DrivetrainParameters::default()).unwrap();
    drivetrain.advance(Terminal::Driven(6.0), 0.3);
    let before = drivetrain.reading().output;
    assert!(before.rate_deg_s > 200.0);
    drivetrain.set_jammed(true);
    drivetrain.advance(Terminal::Driven(6.0), 0.01);
    let jammed = drivetrain.reading();
    assert_eq!(jammed.output.rate_deg_s, 0.0);
    // 0.01 s is 77 time constants of the winding: 6 V / 7.7 ohm.
    assert!((jammed.current_a - 6.0 / 7.7).abs() < 1e-9);
    drivetrain.set_jammed(false);
    drivetrain.advance(Terminal::Driven(6.0), 0.3);
    assert!(drivetrain.reading().output.rate_deg_s > 200.0);
}

#[test]
fn a_lower_supply_limits_the_terminal_voltage_and_the_diode_voltage() {
    let mut drivetrain = Drivetrain::try_new(&DrivetrainParameters::default()).unwrap();
    drivetrain.set_supply_v(2.0);
    drivetrain.advance(Terminal::Driven(6.0), 1e-4);
    assert_eq!(drivetrain.reading().terminal_v, 2.0);
    drivetrain.advance(Terminal::Coast, 1e-9);
    // 2 V and twice 0.7 V oppose the remaining current.
    assert_eq!(drivetrain.reading().terminal_v, -3.4);
    drivetrain.set_supply_v(f64::NAN);
    drivetrain.advance(Terminal::Driven(6.0), 1e-4);
    assert_eq!(drivetrain.reading().terminal_v, 0.0);
}

#[test]
fn a_bench_that_has_come_to_rest_has_no_subnormal_current_or_rate() {
    let mut bench = SteppedDrivetrain::try_new(&without_stops(), Pwm::Average).unwrap();
    let pass = |bench: &mut SteppedDrivetrain, duty_pct, seconds: f64| {
        for _ in 0..(seconds / (PERIOD as f64 * TICK_S)) as u32 {
            bench.start_period(duty_pct);
            bench.pass_to(PERIOD);
        }
    };
    pass(&mut bench, 50.0, 1.0);
    // 345 time constants of the winding, 0.13 ms, are 45 ms.
    pass(&mut bench, 0.0, 1.0);
    let reading = bench.reading();
    assert_eq!(reading.current_a, 0.0);
    assert_eq!(reading.output.rate_deg_s, 0.0);
    assert_eq!(reading.load.rate_deg_s, 0.0);
}
