use canopen::cia402::{Demand, Mode, Output, statusword};

use crate::{Bench, ENABLE};

fn torque(output: &Output) -> i16 {
    match output.demand {
        Demand::Torque { torque, .. } => torque,
        other => panic!("{other:?}"),
    }
}

fn velocities(output: &Output) -> (i32, i32) {
    match output.demand {
        Demand::Torque { velocities, .. } => velocities,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_profile_torque_approaches_its_target_with_its_slope_from_zero() {
    let mut bench = Bench::enabled(Mode::ProfileTorque);
    bench.writes(false);
    bench.step();
    (bench.input.target_torque, bench.input.is_new_torque) = (200, true);
    let mut outputs = Vec::new();
    for _ in 0..8 {
        outputs.push(bench.step());
    }
    // 10,000 a second are 40 in 4 ms.
    let torques: Vec<_> = outputs.iter().map(torque).collect();
    assert_eq!(torques, [40, 80, 120, 160, 200, 200, 200, 200]);
    let reached = outputs
        .iter()
        .map(|it| it.statusword & statusword::TARGET_REACHED != 0);
    assert_eq!(
        reached.collect::<Vec<_>>(),
        [false, false, false, false, true, true, true, true]
    );
}

#[test]
fn a_cyclic_torque_acts_at_once_within_the_max_torque() {
    let mut bench = Bench::enabled(Mode::CyclicTorque);
    for (target, expected) in [
        (300, 300),
        (-1_000, -1_000),
        (1_001, 1_000),
        (i16::MIN, -1_000),
    ] {
        bench.input.target_torque = target;
        let output = bench.step();
        assert_eq!(torque(&output), expected);
        let is_limited = target != expected;
        assert_eq!(
            output.statusword & statusword::INTERNAL_LIMIT != 0,
            is_limited
        );
        assert_eq!(output.statusword & statusword::MODE_12 != 0, !is_limited);
    }
}

#[test]
fn a_torque_ends_at_the_position_limit_where_the_shaft_is_held_and_leads_back_from_it() {
    let mut bench = Bench::enabled(Mode::CyclicTorque);
    bench.parameters.approach_gain = 7 << 10;
    bench.input.target_torque = 1_000;
    bench.run(1_000);
    let place = bench.input.position_actual;
    assert!((59_900..=60_000).contains(&place), "{place}");
    bench.input.position_actual = 60_500;
    bench.input.velocity_actual = 3_000;
    assert_eq!(bench.step().demand, Demand::Velocity(0), "held");
    bench.input.target_torque = -1_000;
    assert_eq!(velocities(&bench.step()), (-500_000, 0));
    bench.run(20);
    assert!(
        bench.input.velocity_actual < -70_000,
        "{}",
        bench.input.velocity_actual
    );
}

#[test]
fn a_stop_decelerates_from_the_actual_velocity_and_a_halted_profile_resumes() {
    let mut bench = Bench::enabled(Mode::ProfileTorque);
    bench.parameters.position_limits = None;
    bench.input.target_torque = 1_000;
    bench.run(75);
    // That of the last period: the motor has become faster by 4 deg/s since.
    let before = bench.input.velocity_actual - 4_000;
    assert!((200_000..300_000).contains(&before), "{before}");
    // 3000 deg/s^2 are 12 deg/s in 4 ms.
    for period in 1..=10 {
        let output = bench.command(ENABLE | 0x100);
        assert_eq!(output.demand, Demand::Velocity(before - 12_000 * period));
    }
    bench.writes(false);
    assert_eq!(torque(&bench.command(ENABLE)), 40);
}
