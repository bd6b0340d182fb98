//! No motion that was not commanded, on the board.

use board_tests::frames::{Frame, control, faults, start, write};
use board_tests::program::run_master;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::{Finished, Options};

/// Number of the fault "command timeout".
const COMMAND_TIMEOUT: u8 = 15;

/// Angles of the shaft from this tick on, deg.
fn angles_deg<S>(finished: &Finished<S>, from_tick: u64) -> impl Iterator<Item = f64> {
    let rows = finished.trace.rows.iter();
    let rows = rows.filter(move |row| row.at_ns >= from_tick * 4_000_000);
    rows.map(|row| row.angle_deg)
}

/// Starts the node in a mode and enables operation.
fn enabled(mode: u8, tick: u64) -> Vec<Frame> {
    match tick {
        20 => vec![start()],
        24 => vec![write(0x607D, 1, -2_000_000_i32 as u32, 4)],
        26 => vec![write(0x607D, 2, 2_000_000, 4)],
        28 => vec![write(0x6060, 0, mode.into(), 1)],
        30 => vec![control(0x06, 0)],
        32 => vec![control(0x07, 0)],
        34 => vec![control(0x0f, 0)],
        _ => Vec::new(),
    }
}

/// To 50 deg by a profile, off, and on again in cyclic synchronous position mode with target 0;
/// then a single command.
fn enabled_away_from_its_target(tick: u64) -> Vec<Frame> {
    match tick {
        40 => vec![control(0x1f, 50_000)],
        42 => vec![control(0x0f, 50_000)],
        300 => vec![control(0, 0)],
        310 => vec![write(0x6060, 0, 8, 1)],
        320 => vec![control(0x06, 0)],
        322 => vec![control(0x07, 0)],
        324 => vec![control(0x0f, 0)],
        340 => vec![control(0x0f, 50_000)],
        _ => enabled(1, tick),
    }
}

#[test]
fn enabling_at_50_deg_with_target_0_holds_the_angle_and_misses_the_commands() {
    let options = Options {
        plant: BoardPlantOptions::realistic(3),
        ..Options::for_ms(1_800)
    };
    let finished = run_master(options, enabled_away_from_its_target);
    let at_rest = angles_deg(&finished, 318).next().expect("rows");
    assert!((at_rest - 50.0).abs() < 1.0, "{at_rest} deg");
    let furthest = angles_deg(&finished, 318).map(|deg| (deg - at_rest).abs());
    let furthest_deg = furthest.fold(0.0, f64::max);
    assert!(furthest_deg < 0.5, "it moved by {furthest_deg} deg");
    let faults = faults(&finished);
    let [(at_ns, COMMAND_TIMEOUT)] = faults[..] else {
        panic!("{faults:?}");
    };
    // 100 ms from the first command on, and the turn that reports it; ticks begin about 10 ms after
    // power-on.
    let after_ms = (at_ns / 1_000_000).saturating_sub(340 * 4);
    assert!((100..=122).contains(&after_ms), "{after_ms} ms");
}
