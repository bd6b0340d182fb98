//! A jam that lets the shaft go for a moment again and again, and slow motion against a load.

use model_core::{control::units::angle, plant::board::BoardPlantOptions};

use super::{winding::Loop, *};

/// Control periods of 100 ms.
const CYCLE: u32 = 25;

/// The first fault, and after how many control periods, of a shaft that is jammed for 80 of each
/// 100 ms while the target is 8 deg ahead of it; in the other 20 ms it is ahead by this.
fn intermittently_jammed(seed: u64, direction: f64, free_deg: f64) -> Option<(Fault, u32)> {
    let mut board = Loop::with(&BoardPlantOptions::realistic(seed));
    for period in 1..=1000 {
        let is_jammed = period % CYCLE < 20;
        board.plant.plant.defects.is_jammed = is_jammed;
        let ahead_deg = if is_jammed { 8.0 } else { free_deg };
        let target = board.application.telemetry().angle + angle(direction * ahead_deg);
        if let Some(fault) = board.follow(target, 1).fault {
            return Some((fault, period));
        }
    }
    None
}

#[test]
fn a_jam_for_80_of_each_100_ms_is_a_stall_within_a_second() {
    for seed in 0..8 {
        for direction in [1.0, -1.0] {
            // A motor that pulls meanwhile, and one that does not.
            for free_deg in [8.0, 0.0] {
                let found = intermittently_jammed(seed, direction, free_deg);
                // 15 more in each 25 are 125 after 209.
                assert!(
                    matches!(found, Some((Fault::Stall, 125..=250))),
                    "{seed} {direction} {free_deg}: {found:?}"
                );
            }
        }
    }
}

/// The first fault of a shaft that lifts a load of 0.7 N m, which takes 0.6 A, at this rate.
fn lifting(seed: u64, rate_deg_s: f64) -> Option<Fault> {
    let mut board = Loop::with(&BoardPlantOptions::realistic(seed));
    board.follow(angle(-60.0), 300);
    board.plant.plant.defects.torque_nm = -0.7;
    let periods = (100.0 / rate_deg_s * 250.0) as u32;
    let mut outputs = (1..=periods).map(|period| {
        let command_deg = -60.0 + rate_deg_s * f64::from(period) / 250.0;
        board.follow(angle(command_deg), 1)
    });
    outputs.find_map(|outputs| outputs.fault)
}

#[test]
fn a_load_that_is_lifted_at_4_deg_s_or_faster_is_no_stall_and_at_2_deg_s_it_is() {
    for seed in 0..3 {
        assert_eq!(lifting(seed, 2.0), Some(Fault::Stall), "{seed}");
        for rate_deg_s in [4.0, 5.0, 7.0, 10.0, 20.0, 40.0] {
            assert_eq!(lifting(seed, rate_deg_s), None, "{seed} {rate_deg_s}");
        }
    }
}
