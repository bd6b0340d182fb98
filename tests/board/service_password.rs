//! The service password of the board's program.

use board_tests::frames::{Frame, SAVE, read, responses, write};
use board_tests::master::driven;
use board_tests::program::run_master;
use canopen::Abort;
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::Options;

const PASSWORD: u32 = 0x1EAF_5EED;

fn limit() -> Frame {
    write(0x2100, 8, 1_500, 4)
}

fn give(password: u32) -> Frame {
    write(0x2103, 1, password, 4)
}

/// A password is set and saved; after a power cycle at 1,400 ms it is given, first a wrong one.
fn requests(tick: u64) -> Vec<Frame> {
    match tick {
        25 => vec![limit()],
        26 => vec![write(0x2103, 4, PASSWORD, 4)],
        27 => vec![write(0x1010, 1, SAVE, 4)],
        450 => vec![read(0x2103, 2)],
        451 => vec![limit()],
        452 => vec![give(1)],
        453 => vec![give(PASSWORD)],
        // The back-off of 1 s is over.
        720 => vec![give(PASSWORD)],
        721 => vec![read(0x2103, 2)],
        722 => vec![limit()],
        _ => Vec::new(),
    }
}

#[test]
fn a_saved_password_locks_the_board_after_a_power_cycle_and_a_wrong_one_delays_the_next() {
    let options = Options {
        faults: vec![Planned::at_ms(1400, Fault::PowerLoss).for_ms(50)],
        ..Options::for_ms(3_000)
    };
    let finished = run_master(options, requests);
    let answers: Vec<(u8, u32)> = responses(&finished)
        .iter()
        .map(|[command, _, _, _, a, b, c, d]| (*command, u32::from_le_bytes([*a, *b, *c, *d])))
        .collect();
    let state = |abort: Abort| (0x80, abort.code());
    let expected = [
        (0x60, 0),
        (0x60, 0),
        (0x60, 0),
        (0x4F, 1),
        state(Abort::DeviceState),
        state(Abort::Value),
        state(Abort::DeviceState),
        (0x60, 0),
        (0x4F, 2),
        (0x60, 0),
    ];
    assert_eq!(answers, expected);
}

/// As the timetable of a drive that is enabled, with writes in between.
fn while_enabled(tick: u64) -> Vec<Frame> {
    match tick {
        60 => vec![limit()],
        61 => vec![write(0x2102, 1, 5, 4)],
        62 => vec![write(0x1F51, 1, 1, 1)],
        63 => vec![write(0x2103, 4, PASSWORD, 4)],
        _ => driven(tick, 0),
    }
}

#[test]
fn limits_identity_update_and_password_are_locked_while_the_board_is_enabled() {
    let finished = run_master(Options::for_ms(400), while_enabled);
    let answers = responses(&finished);
    assert_eq!(answers.len(), 4);
    for [command, _, _, _, code @ ..] in answers {
        let refused = (0x80, Abort::DeviceState.code().to_le_bytes());
        assert_eq!((command, code), refused);
    }
}
