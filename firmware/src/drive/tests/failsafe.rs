//! A master that falls silent.

use super::*;

/// In a cyclic mode; the master commands 10 deg, then sends nothing more.
fn without_master(action: u32) -> Bench {
    let mut bench = Bench::new();
    bench.set(0x2040, 2, action, 1);
    bench.set(0x2040, 3, -20_000_i32 as u32, 4);
    bench.enable();
    bench.cyclic = Some((15, 10_000));
    bench.steps(250);
    assert!((bench.angle_mdeg() - 10_000).abs() <= 176);
    bench.cyclic = None;
    bench.received.clear();
    bench
}

#[test]
fn by_default_missing_commands_are_a_fault_after_the_timeout() {
    let mut bench = without_master(1);
    bench.steps(24);
    assert!(bench.emergencies().is_empty());
    bench.steps(3);
    assert_eq!(bench.emergencies(), [(0x8130, 0x8F)]);
    bench.until(200, |bench| bench.status() & 0x4F == 0x08);
    bench.control(0x80);
    assert_eq!(bench.status() & 0x6F, 0x40);
    bench.enable();
}

#[test]
fn the_angle_is_held_or_the_failsafe_position_approached() {
    let mut bench = without_master(0);
    bench.steps(200);
    assert!((bench.angle_mdeg() - 10_000).abs() <= 176);
    let mut bench = without_master(2);
    // 100 ms, then 60 deg/s for 240 ms; the loop lags by at most 60/8 deg.
    bench.steps(25 + 60);
    let angle = bench.angle_mdeg();
    assert!((-4_400..3_500).contains(&angle), "{angle}");
    bench.steps(250);
    assert!((bench.angle_mdeg() + 20_000).abs() <= 176);
    assert!(bench.emergencies().is_empty());
    // The master returns.
    bench.cyclic = Some((15, 0));
    bench.steps(250);
    assert!(bench.angle_mdeg().abs() <= 176);
}

#[test]
fn the_failsafe_position_has_no_offset_of_the_silent_master() {
    let mut bench = Bench::new();
    bench.set(0x2040, 2, 2, 1);
    bench.set(0x2040, 3, -20_000_i32 as u32, 4);
    bench.set(0x60B1, 0, 40_000, 4);
    bench.set(0x60B2, 0, 200, 2);
    bench.enable();
    bench.cyclic = Some((15, 10_000));
    bench.steps(250);
    let ahead = bench.angle_mdeg() - 10_000;
    assert!(
        (ahead - 5_000).abs() <= 176,
        "40 deg/s over the gain of 8: {ahead}"
    );
    bench.cyclic = None;
    bench.steps(25 + 250);
    assert!((bench.angle_mdeg() + 20_000).abs() <= 176);
}

#[test]
fn a_profile_needs_only_its_first_command() {
    let mut bench = Bench::enabled(1);
    bench.set(0x607A, 0, 5_000, 4);
    bench.steps(300);
    assert_eq!(bench.status() & 0x6F, 0x27);
}

#[test]
fn a_lost_heartbeat_ends_the_motion_in_every_mode() {
    let mut bench = Bench::enabled(1);
    bench.set(0x1016, 1, 100 << 16 | 40, 4);
    bench.send(0x764, &[5]);
    bench.received.clear();
    bench.steps(12);
    let seen = bench.emergencies();
    assert!(
        seen.contains(&(0x8130, 100)) && seen.contains(&(0x8130, 0x8F)),
        "{seen:x?}"
    );
    bench.until(200, |bench| bench.status() & 0x4F == 0x08);
}

/// A long sine of 1 deg.
fn exciting(bench: &mut Bench) {
    for (sub, value) in [(3, 7), (4, 1_000), (5, 1_000), (12, 1_000)] {
        bench.set(0x2020, sub, value, 4);
    }
    bench.set(0x2020, 1, 1, 1);
    bench.steps(20);
    assert_eq!(bench.get(0x2020, 2), 1);
}

#[test]
fn the_loss_of_the_master_ends_an_excitation() {
    for action in [0, 1, 2] {
        for stop in [false, true] {
            let mut bench = Bench::new();
            bench.set(0x2040, 2, action, 1);
            bench.set(0x6060, 0, 1, 1);
            bench.set(0x1016, 1, 100 << 16 | 40, 4);
            // The node stays OPERATIONAL without its master.
            bench.set(0x1029, 1, 1, 1);
            bench.send(0x764, &[5]);
            bench.enable();
            bench.send(0x764, &[5]);
            for (sub, value) in [(3, 7), (4, 1_000), (5, 1_000), (12, 1_000)] {
                bench.set(0x2020, sub, value, 4);
            }
            bench.set(0x2020, 1, 1, 1);
            bench.send(0x764, &[5]);
            bench.steps(2);
            let is_exciting = |bench: &Bench| {
                bench.actuator.device.drive.outputs().telemetry.source == CommandSource::Excitation
            };
            assert!(is_exciting(&bench));
            if stop {
                bench.send(0, &[2, 1]);
            }
            bench.steps(15);
            assert!(!is_exciting(&bench), "action {action}");
            bench.steps(100);
            let is_fault = bench.actuator.device.drive.outputs().motion.status & 0x4F == 0x08;
            assert_eq!(is_fault, action == 1);
        }
    }
}

#[test]
fn an_excitation_needs_no_commands_and_restarts_the_timeout() {
    let mut bench = Bench::new();
    bench.enable();
    bench.set(0x607A, 0, 0, 4);
    exciting(&mut bench);
    for _ in 0..100 {
        bench.step();
    }
    assert_eq!(bench.status() & 0x6F, 0x27, "no timeout while it runs");
    bench.set(0x2020, 1, 0, 1);
    bench.steps(20);
    assert_eq!(bench.status() & 0x6F, 0x27);
    bench.steps(20);
    assert_eq!(bench.get(0x603F, 0), 0x8130);
}

#[test]
fn the_timeout_of_commands_runs_from_the_first_one_after_enabling_or_a_halt() {
    for mode in [8, 9] {
        let mut bench = Bench::new();
        bench.set(0x6060, 0, mode, 1);
        bench.set(0x607A, 0, 0, 4);
        bench.enable();
        bench.steps(100);
        assert_eq!(bench.status() & 0x6F, 0x27, "no command yet");
        let target = if mode == 8 { 0x607A } else { 0x60FF };
        bench.set(target, 0, 0, 4);
        bench.control(0x10F);
        bench.steps(100);
        bench.control(0x0F);
        bench.steps(100);
        assert_eq!(bench.status() & 0x6F, 0x27, "no command since the halt");
        bench.set(target, 0, 0, 4);
        bench.received.clear();
        bench.steps(25);
        assert!(bench.emergencies().is_empty(), "mode {mode}");
        bench.steps(3);
        assert_eq!(bench.emergencies(), [(0x8130, 0x8F)], "mode {mode}");
    }
}

#[test]
fn after_a_change_to_a_cyclic_mode_the_timeout_runs_from_its_first_command() {
    let mut bench = Bench::enabled(1);
    bench.set(0x607A, 0, 0, 4);
    bench.steps(500);
    bench.set(0x6060, 0, 8, 1);
    bench.steps(100);
    assert_eq!(bench.status() & 0x6F, 0x27);
    bench.set(0x607A, 0, 0, 4);
    bench.steps(30);
    assert_eq!(bench.get(0x603F, 0), 0x8130);
}

#[test]
fn targets_of_other_modes_do_not_hide_a_lost_master() {
    let targets = [(8, 0x607A, 4), (9, 0x60FF, 4), (10, 0x6071, 2)];
    for (mode, own, size) in targets {
        let mut bench = Bench::enabled(mode);
        bench.set(own, 0, 0, size);
        bench.received.clear();
        // Each 20 ms, for 120 ms.
        for _ in 0..6 {
            for (_, other, size) in targets.iter().filter(|(_, other, _)| *other != own) {
                bench.set(*other, 0, 0, *size);
            }
            bench.steps(5);
        }
        assert_eq!(bench.emergencies(), [(0x8130, 0x8F)], "mode {mode}");
    }
}

#[test]
fn a_fault_is_not_reset_before_its_reaction_has_ended() {
    let mut bench = Bench::enabled(9);
    bench.set(0x60FF, 0, 200_000, 4);
    let status = |bench: &mut Bench| bench.actuator.device.drive.outputs().motion.status & 0x4F;
    bench.until(100, |bench| status(bench) == 0x0F);
    for word in [0x80, 0x00, 0x80] {
        bench.send(0x601, &[0x2B, 0x40, 0x60, 0, word, 0, 0, 0]);
        bench.step();
        assert_eq!(status(&mut bench), 0x0F, "fault reaction active");
    }
    bench.until(100, |bench| status(bench) == 0x08);
    assert_eq!(bench.get(0x603F, 0), 0x8130);
    bench.control(0);
    bench.control(0x80);
    assert_eq!((status(&mut bench), bench.get(0x603F, 0)), (0x40, 0));
}

#[test]
fn a_reset_of_the_communication_stops_a_moving_drive() {
    for mode in [3, 9] {
        let mut bench = Bench::enabled(mode);
        bench.set(0x60FF, 0, 50_000, 4);
        bench.steps(10);
        bench.send(0, &[130, 1]);
        // In the fault reaction, then in the state "fault".
        let reacts =
            |bench: &mut Bench| bench.actuator.device.drive.outputs().motion.status & 0x48 == 0x08;
        let periods = bench.until(60, reacts);
        assert!(
            periods < 20,
            "mode {mode}: {periods}, before the timeout of commands"
        );
        bench.until(100, |bench| {
            bench.actuator.device.drive.outputs().motion.status & 0x4F == 0x08
        });
        let rate = bench
            .actuator
            .device
            .drive
            .outputs()
            .telemetry
            .velocity_mdeg_s;
        assert!(rate.abs() <= 3_000, "mode {mode}: {rate} mdeg/s");
    }
}

#[test]
fn a_reset_of_the_fault_of_a_lost_master_allows_operation() {
    let losses: [fn(&mut Bench); 2] = [
        |bench| bench.send(0, &[130, 1]),
        |bench| {
            bench.set(0x1016, 1, 100 << 16 | 40, 4);
            bench.send(0x764, &[5]);
            bench.steps(12);
            bench.set(0x1016, 1, 0, 4);
        },
    ];
    for lose in losses {
        let mut bench = Bench::enabled(1);
        lose(&mut bench);
        bench.until(60, |bench| bench.status() & 0x4F == 0x08);
        bench.control(0x80);
        bench.enable();
        bench.steps(50);
        assert_eq!(bench.status() & 0x6F, 0x27);
    }
}

#[test]
fn a_reset_bit_without_a_fault_changes_nothing() {
    let mut bench = without_master(2);
    bench.steps(25 + 200);
    let away = bench.angle_mdeg();
    bench.set(0x6040, 0, 0x8F, 2);
    bench.steps(50);
    assert!(bench.angle_mdeg() <= away + 500, "the retreat goes on");
}

#[test]
fn a_profile_halts_if_the_failsafe_action_is_to_hold() {
    let mut bench = Bench::enabled(1);
    bench.control(0);
    bench.set(0x2040, 2, 0, 1);
    bench.set(0x6081, 0, 20_000, 4);
    bench.set(0x1016, 1, 100 << 16 | 40, 4);
    bench.set(0x1029, 1, 1, 1);
    bench.enable();
    bench.send(0x764, &[5]);
    bench.set(0x607A, 0, 50_000, 4);
    bench.control(0x1F);
    // It would be at 24 deg if it continued.
    bench.steps(300);
    let angle = bench.angle_mdeg();
    assert!(angle < 5_000, "{angle}");
    assert_eq!(bench.status() & 0x6F, 0x27);
}
