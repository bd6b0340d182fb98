//! Requests that take more than a control period, and other requests in the meantime.

use board_tests::frames::{
    Frame, SAVE, abort, angles_cdeg, control, read, responses, standard, start, write, write_real,
};
use board_tests::master::driven;
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::Options;

/// Sets the position gain and saves it.
fn save(gain: f32) -> Vec<Frame> {
    vec![write_real(0x60FB, 1, gain), write(0x1010, 1, SAVE, 4)]
}

/// The same from a client that aborts its previous save.
fn save_again(gain: f32) -> Vec<Frame> {
    [vec![abort(0x1010, 1)], save(gain)].concat()
}

/// A save to the blank page; then three during the erase of the next one.
fn saves(tick: u64) -> Vec<Frame> {
    match tick {
        25 => save(8.5),
        225 => save(8.6),
        230 => save_again(9.0),
        235 => save_again(7.0),
        900 => vec![read(0x60FB, 1)],
        _ => Vec::new(),
    }
}

#[test]
fn after_three_saves_within_an_erase_a_power_cycle_loads_the_last() {
    let options = Options {
        faults: vec![Planned::at_ms(3400, Fault::PowerLoss).for_ms(50)],
        ..Options::for_ms(3700)
    };
    let finished = run_master(options, saves);
    let responses = responses(&finished);
    let [command, low, high, sub, value @ ..] = *responses.last().expect("a response");
    assert_eq!((command, low, high, sub), (0x43, 0xfb, 0x60, 1));
    assert_eq!(f32::from_le_bytes(value), 7.0);
}

/// A pulse of 5 deg that is started and stopped between the same two control steps; then one that
/// is only started.
fn start_and_stop(tick: u64) -> Vec<Frame> {
    let excitation = |on| write(0x2020, 1, on, 1);
    match tick {
        41 => vec![write(0x2020, 3, 0, 4)],
        51 => vec![excitation(1), excitation(0)],
        251 => vec![excitation(1)],
        _ if tick >= 40 && tick.is_multiple_of(5) => vec![control(0x0f, 0)],
        _ => driven(tick, 0),
    }
}

#[test]
fn a_stop_in_the_control_period_of_the_start_cancels_the_excitation() {
    let finished = run_master(Options::for_ms(1400), start_and_stop);
    let furthest_cdeg = |from_ms: u64, until_ms: u64| {
        let angles = angles_cdeg(&finished).into_iter();
        let within = angles.filter(|(at_ns, _)| (from_ms..until_ms).contains(&(at_ns / 1_000_000)));
        within.map(|(_, cdeg)| cdeg.abs()).max()
    };
    let called_off = furthest_cdeg(200, 1000);
    assert!(called_off < Some(50), "{called_off:?}");
    let started = furthest_cdeg(1000, 1400);
    assert!(started > Some(400), "{started:?}");
    // Writing the shape, three times the control, each with its response.
    let accepted = responses(&finished);
    assert_eq!(accepted.len(), 4);
    assert!(
        accepted.iter().all(|bytes| bytes[0] == 0x60),
        "{accepted:x?}"
    );
}

/// An RPDO with the target point of the interpolated position mode, and three of its frames; then
/// the number of points is read.
fn points(tick: u64) -> Vec<Frame> {
    match tick {
        5 => vec![write(0x1403, 1, 0x8000_0501, 4)],
        6 => vec![write(0x1603, 0, 0, 1)],
        7 => vec![write(0x1603, 1, 0x60C1_0120, 4)],
        8 => vec![write(0x1603, 0, 1, 1)],
        9 => vec![write(0x1403, 1, 0x501, 4)],
        20 => vec![start()],
        30..33 => vec![standard(0x501, &1_000_u32.to_le_bytes())],
        35 => vec![read(0x60C4, 4)],
        _ => Vec::new(),
    }
}

#[test]
fn each_frame_of_a_mapped_point_appends_one() {
    let finished = run_master(Options::for_ms(200), points);
    let responses = responses(&finished);
    let [command, low, high, sub, number, ..] = *responses.last().expect("a response");
    assert_eq!((command, low, high, sub), (0x4b, 0xc4, 0x60, 4));
    assert_eq!(number, 3);
}
