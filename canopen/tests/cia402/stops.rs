use canopen::cia402::{
    Cia402State, Deceleration, Demand, Fault, Mode, QuickStop, StopOption, controlword, statusword,
};

use crate::{Bench, ENABLE};

/// An axis at 300 deg/s in profile velocity mode.
fn moving() -> Bench {
    let mut bench = Bench::enabled(Mode::ProfileVelocity);
    bench.parameters.position_limits = None;
    bench.input.target_velocity = 300_000;
    bench.until(|output| output.demand == Demand::Velocity(300_000));
    bench
}

fn periods_to_standstill(bench: &mut Bench) -> usize {
    bench.until(|output| matches!(output.demand, Demand::Off | Demand::Velocity(0)))
}

#[test]
fn quick_stop_option_codes_select_deceleration_and_final_state() {
    // 300 deg/s at 12 deg/s (slow down) or 24 deg/s (quick stop) per period; coasting and limits
    // stop immediately.
    for (code, periods, stays) in [
        (0, 1, false),
        (1, 25, false),
        (2, 13, false),
        (3, 1, false),
        (4, 1, false),
        (5, 25, true),
        (6, 13, true),
        (7, 1, true),
        (8, 1, true),
    ] {
        let mut bench = moving();
        bench.parameters.options.quick_stop = QuickStop::from_code(code).expect("an option");
        bench.input.controlword = 0x02;
        assert_eq!(periods_to_standstill(&mut bench), periods, "option {code}");
        bench.step();
        let expected = if stays {
            Cia402State::QuickStopActive
        } else {
            Cia402State::SwitchOnDisabled
        };
        assert_eq!(bench.axis.state(), expected, "option {code}");
        if stays {
            bench.command(ENABLE);
            assert_eq!(bench.axis.state(), Cia402State::OperationEnabled);
        }
    }
}

#[test]
fn disable_voltage_coasts_immediately() {
    let mut bench = moving();
    assert_eq!(bench.command(0).demand, Demand::Off);
    assert_eq!(bench.axis.state(), Cia402State::SwitchOnDisabled);
    let mut bench = moving();
    bench.command(0x02);
    assert_eq!(
        bench.command(0).demand,
        Demand::Off,
        "also during a quick stop"
    );
}

#[test]
fn shutdown_and_disable_operation_follow_their_option_codes() {
    for (word, end) in [
        (0x06, Cia402State::ReadyToSwitchOn),
        (0x07, Cia402State::SwitchedOn),
    ] {
        for (option, periods) in [
            (StopOption::Disable, 1),
            (StopOption::Stop(Deceleration::SlowDown), 25),
        ] {
            let mut bench = moving();
            bench.parameters.options.shutdown = option;
            bench.parameters.options.disable_operation = option;
            bench.input.controlword = word;
            assert_eq!(periods_to_standstill(&mut bench), periods);
            assert_eq!(bench.step().demand, Demand::Off);
            assert_eq!(bench.axis.state(), end);
        }
    }
}

#[test]
fn a_stop_for_disable_operation_can_be_revoked() {
    let mut bench = moving();
    bench.command(0x07);
    assert_eq!(
        bench.axis.state(),
        Cia402State::OperationEnabled,
        "still stopping"
    );
    bench.command(ENABLE);
    bench.until(|output| output.demand == Demand::Velocity(300_000));
}

#[test]
fn halt_stops_in_operation_enabled_and_ends_with_its_bit() {
    for (option, periods) in [
        (Deceleration::SlowDown, 25),
        (Deceleration::QuickStop, 13),
        (Deceleration::Limit, 1),
    ] {
        let mut bench = moving();
        bench.parameters.options.halt = StopOption::Stop(option);
        bench.input.controlword = ENABLE | controlword::HALT;
        assert_eq!(periods_to_standstill(&mut bench), periods);
        let output = bench.step();
        assert_eq!(output.state, Cia402State::OperationEnabled);
        assert_ne!(
            output.statusword & statusword::TARGET_REACHED,
            0,
            "it is at rest"
        );
        bench.command(ENABLE);
        bench.until(|output| output.demand == Demand::Velocity(300_000));
    }
}

#[test]
fn fault_reactions_follow_their_option_code_unless_the_fault_is_immediate() {
    for (fault, code, periods) in [
        (Fault::Controlled, 0, 1),
        (Fault::Controlled, 1, 25),
        (Fault::Controlled, 2, 13),
        (Fault::Immediate, 2, 1),
    ] {
        let mut bench = moving();
        bench.parameters.options.fault_reaction = StopOption::from_code(code).expect("an option");
        bench.input.fault = fault;
        assert_eq!(periods_to_standstill(&mut bench), periods, "option {code}");
        bench.step();
        assert_eq!(bench.axis.state(), Cia402State::Fault);
    }
    let mut bench = moving();
    bench.input.fault = Fault::Controlled;
    bench.step();
    bench.input.fault = Fault::Immediate;
    assert_eq!(
        bench.step().demand,
        Demand::Off,
        "the fault becomes immediate during the stop"
    );
}

#[test]
fn a_move_resumes_after_halt_but_not_after_quick_stop() {
    let mut bench = Bench::enabled(Mode::ProfilePosition);
    bench.parameters.options.quick_stop = QuickStop::from_code(6).expect("an option");
    bench.input.target_position = 50_000;
    bench.command(crate::NEW);
    bench.run(30);
    bench.input.controlword = ENABLE | controlword::HALT;
    bench.until(|output| matches!(output.demand, Demand::Position { velocity: 0, .. }));
    bench.input.controlword = ENABLE;
    bench.run(10);
    bench.input.controlword = 0x02;
    bench.until(|output| matches!(output.demand, Demand::Position { velocity: 0, .. }));
    let place = bench.input.position_actual;
    assert!((1..50_000).contains(&place));
    bench.input.controlword = ENABLE;
    bench.run(100);
    assert_eq!(bench.input.position_actual, place);
}

/// An axis whose demand has reached a far target, while the motor is still on its way.
fn behind_its_demand() -> Bench {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    bench.follows = false;
    bench.parameters.interpolation_us = 0;
    bench.parameters.max_velocity = u32::MAX;
    bench.input.target_position = 50_000;
    bench.run(3);
    (bench.input.position_actual, bench.input.velocity_actual) = (10_000, 200_000);
    let arrived = Demand::Position {
        position: 50_000,
        velocity: 0,
    };
    assert_eq!(bench.step().demand, arrived);
    bench
}

#[test]
fn a_motor_that_is_behind_its_demand_is_decelerated_from_its_own_motion() {
    for (word, deceleration) in [(0x02, 6_000_000), (0x06, 3_000_000), (0x07, 3_000_000)] {
        let mut bench = behind_its_demand();
        bench.parameters.options.shutdown = StopOption::Stop(Deceleration::SlowDown);
        bench.follows = true;
        let first = bench.command(word).demand;
        let velocity = 200_000 - deceleration / 250;
        let position = 10_000 + velocity / 250;
        assert_eq!(first, Demand::Position { position, velocity });
        bench.until(|output| output.demand == Demand::Off);
        // v^2 / 2a less half a period of v: a period has the velocity at its end.
        let way = 200_000_i64.pow(2) / (2 * i64::from(deceleration)) - 200_000 / 500;
        let passed = i64::from(bench.input.position_actual) - 10_000;
        // The last period has a part of a step of the velocity.
        let step = i64::from(deceleration) / 250;
        assert!((passed - way).abs() <= step / 500, "{passed} for {way}");
    }
}

#[test]
fn power_stays_on_until_the_motor_rests_or_its_time_is_over() {
    let mut bench = behind_its_demand();
    bench.parameters.velocity_threshold_time_ms = 20;
    bench.input.controlword = 0x02;
    // 200 deg/s at 24 deg/s per period.
    bench.run(9);
    for _ in 0..50 {
        assert_ne!(bench.step().demand, Demand::Off, "the motor still moves");
    }
    bench.input.velocity_actual = 0;
    // 20 ms.
    let periods = bench.until(|output| output.demand == Demand::Off);
    assert_eq!(periods, 6);
    // A motor that never rests: after 500 ms.
    let mut bench = behind_its_demand();
    bench.input.controlword = 0x02;
    let periods = bench.until(|output| output.demand == Demand::Off);
    assert_eq!(periods, LONGEST_STOP_PERIODS);
}

/// The command, 500 ms from the next period on, the period that ends them, and that without power.
const LONGEST_STOP_PERIODS: usize = 1 + 125 + 1 + 1;

#[test]
fn a_stop_has_its_own_time_after_one_that_lasted_long() {
    let mut bench = Bench::enabled(Mode::CyclicPosition);
    // 600 ms.
    bench.input.controlword = ENABLE | controlword::HALT;
    bench.run(150);
    bench.parameters.interpolation_us = 0;
    bench.parameters.max_velocity = u32::MAX;
    bench.input.controlword = ENABLE;
    bench.input.target_position = 50_000;
    bench.run(3);
    bench.follows = false;
    (bench.input.position_actual, bench.input.velocity_actual) = (10_000, 200_000);
    bench.step();
    bench.input.controlword = 0x02;
    let periods = bench.until(|output| output.demand == Demand::Off);
    assert_eq!(periods, LONGEST_STOP_PERIODS);
}
