//! Stops that begin in each phase of a motion: the shaft is not turned back.

use board_tests::frames::{Frame, control, mode as select_mode, nmt, velocity, write};
use board_tests::master::driven;
use board_tests::program::run_master;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;
use virtual_board::trace::Row;

/// The motion from rest begins here.
const MOTION_TICK: u64 = 225;

/// Greatest angle by which a stop may turn the shaft back, deg.
const BACK_DEG: f64 = 0.5;

/// How the master ends the motion.
#[derive(Debug, Clone, Copy)]
enum Stop {
    Quick,
    Halt,
    Disable,
    Silence,
    ResetNode,
}

/// From -55 deg toward 55 deg in a mode, and the stop at this tick.
fn stopped(tick: u64, mode: i8, stop_tick: u64, stop: Stop) -> Vec<Frame> {
    if tick >= stop_tick {
        return match stop {
            Stop::Quick => vec![control(0x02, 55_000)],
            Stop::Halt => vec![control(0x10f, 55_000)],
            Stop::Disable => vec![control(0x07, 55_000)],
            Stop::Silence => vec![],
            Stop::ResetNode if tick == stop_tick => vec![nmt(0x81)],
            Stop::ResetNode => vec![],
        };
    }
    match (mode, tick) {
        (_, ..MOTION_TICK) => driven(tick, -55_000),
        (8, _) => driven(tick, 55_000),
        (_, MOTION_TICK) => vec![select_mode(0x0f, mode)],
        // A set-point, as the rising edge of bit 4.
        (1, _) => vec![control(0x3f, 55_000)],
        (10, _) => vec![write(0x6071, 0, 900, 2)],
        _ => vec![velocity(0x0f, 300_000)],
    }
}

/// How far a shaft travels after the stop, and how far it returns from there.
fn travel(mode: i8, after_ms: u64, stop: Stop) -> (f64, f64, f64) {
    let stop_tick = MOTION_TICK + after_ms / 4;
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        ..Options::for_ms(stop_tick * 4 + 1_500)
    };
    let finished = run_master(options, move |tick| stopped(tick, mode, stop_tick, stop));
    let rows = &finished.trace.rows;
    let after: Vec<&Row> = rows
        .iter()
        .filter(|row| row.at_ns >= stop_tick * 4_000_000)
        .collect();
    let furthest = after
        .iter()
        .map(|row| row.angle_deg)
        .fold(f64::MIN, f64::max);
    let end = after.last().expect("rows");
    let begin = after[0];
    (
        begin.rate_deg_s,
        furthest - begin.angle_deg,
        furthest - end.angle_deg,
    )
}

#[test]
fn no_stop_turns_the_shaft_back_in_any_phase_of_a_motion() {
    println!("| mode | stop | at | rate | travel | back |\n|---|---|---|---|---|---|");
    let mut wrong = Vec::new();
    let phases_ms: [u64; 8] = [20, 60, 100, 160, 240, 320, 400, 480];
    // Of profiles and torques fewer: each stop is the same code.
    for (mode, each) in [(8, 1), (9, 1), (1, 3), (3, 3), (10, 3)] {
        for stop in [
            Stop::Quick,
            Stop::Halt,
            Stop::Disable,
            Stop::Silence,
            Stop::ResetNode,
        ] {
            // A profile needs no further commands.
            if matches!(stop, Stop::Silence) && matches!(mode, 1 | 3) {
                continue;
            }
            for &after_ms in phases_ms.iter().step_by(each) {
                let (rate, way, back) = travel(mode, after_ms, stop);
                println!(
                    "| {mode} | {stop:?} | {after_ms} ms | {rate:.0} deg/s | {way:.1} deg | {back:.2} deg |"
                );
                assert!(
                    after_ms < 100 || rate > 40.0,
                    "mode {mode}: {rate:.0} deg/s"
                );
                if back > BACK_DEG {
                    wrong.push(format!(
                        "mode {mode}, {stop:?} at {after_ms} ms: {back:.2} deg"
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
