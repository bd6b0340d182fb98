//! The current sense against what duty, supply and back-EMF make, on the plant whose current
//! pulses.

use model_core::{control::units::angle, plant::board::BoardPlantOptions};

use super::{winding::Loop, *};

/// Largest offset of the current amplifier, V: 10 mA.
const OFFSET_V: f64 = 5e-3;

/// A motor whose constants are these shares of those of object 2011h, with this load and offset.
#[derive(Debug, Clone, Copy)]
struct Drive {
    seed: u64,
    offset_v: f64,
    torque_nm: f64,
    rate_deg_s: f64,
    resistance: f64,
    inductance: f64,
}

/// Control periods from the loss of the current sense, after so many, to the fault; `None` without
/// one within 2 s. The shaft moves to and fro between 40 and -40 deg.
fn until_implausible(drive: Drive, loss_after: Option<u32>) -> Option<u32> {
    let mut options = BoardPlantOptions::realistic(drive.seed);
    options.current.current_offset_error_v = drive.offset_v;
    let motor = &mut options.drivetrain.electrical;
    motor.winding_resistance_ohm *= drive.resistance;
    motor.winding_inductance_h *= drive.inductance;
    let mut board = Loop::with(&options);
    board.plant.plant.defects.torque_nm = drive.torque_nm;
    let from = loss_after.unwrap_or(0);
    for period in 1..=from + 500 {
        if loss_after.is_some_and(|after| period > after) {
            board.plant.plant.defects.current_loss_pct = 100.0;
        }
        let turns = drive.rate_deg_s * f64::from(period) * 0.004 / 160.0;
        let triangle = 1.0 - 4.0 * ((turns + 0.25).rem_euclid(1.0) - 0.5).abs();
        let outputs = board.follow(angle(40.0 * triangle), 1);
        if let Some(fault) = outputs.fault {
            assert_eq!(fault, Fault::CurrentImplausible, "{drive:?}");
            assert!(loss_after.is_some_and(|after| period > after), "{drive:?}");
            return Some(period - from);
        }
    }
    None
}

fn drives(offset_v: f64) -> impl Iterator<Item = Drive> {
    // The negative ones begin in the other direction.
    let rates = [0.0, 1.0, -10.0, 50.0, -75.0, 100.0];
    let loads = [0.0, 0.1, -0.13, 0.16, -0.2, 0.3];
    let both = rates.map(|rate_deg_s| loads.map(|torque_nm| (rate_deg_s, torque_nm)));
    let both = both.into_iter().flatten().enumerate();
    both.map(move |(seed, (rate_deg_s, torque_nm))| Drive {
        seed: seed as u64,
        offset_v,
        torque_nm,
        rate_deg_s,
        resistance: 1.0,
        inductance: 1.0,
    })
}

#[test]
fn a_dead_current_sense_is_reported_within_half_a_second_held_or_moving() {
    let mut worst = 0;
    for offset_v in [OFFSET_V, -OFFSET_V] {
        for drive in drives(offset_v) {
            // At several angles of the motion to and fro.
            let after = 250 + 37 * drive.seed as u32;
            let found = until_implausible(drive, Some(after));
            worst = worst.max(found.unwrap_or(u32::MAX));
            assert!(
                found.is_some_and(|periods| periods <= 125),
                "{drive:?}: {found:?}"
            );
        }
    }
    std::println!("at most {} ms", worst * 4);
}

#[test]
fn a_sound_current_sense_is_plausible_with_resistance_and_inductance_off_by_30_percent() {
    let ends = [0.7, 1.3];
    for (resistance, inductance) in ends.into_iter().flat_map(|r| ends.map(|l| (r, l))) {
        for offset_v in [OFFSET_V, -OFFSET_V] {
            for drive in drives(offset_v) {
                let drive = Drive {
                    resistance,
                    inductance,
                    ..drive
                };
                assert_eq!(until_implausible(drive, None), None);
            }
        }
    }
}
