//! The counters of the protections, object 2051h, of a board whose encoder fails now and then.

use std::collections::BTreeMap;

use board_tests::frames::{Frame, fault, faults, read, sent};
use board_tests::master::driven;
use board_tests::native::NativeBoard;
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::plant::{BoardPlantOptions, EncoderWire, Stuck};
use virtual_board::run::Options;

const DURATION_MS: u64 = 2_000;

/// The words of one in four control periods are invalid while the drive is enabled.
fn chatter() -> Vec<Planned> {
    let word = Fault::EncoderWire {
        line: EncoderWire::Data,
        stuck: Stuck::Low,
    };
    let starts = (400..DURATION_MS).step_by(16);
    starts
        .map(|at_ms| Planned::at_ms(at_ms, word.clone()).for_ms(4))
        .collect()
}

/// Holds the angle, and reads the counters in turn, each at all phases of the four control periods.
fn reading(tick: u64) -> Vec<Frame> {
    let mut frames = driven(tick, 0);
    if tick > 110 && tick.is_multiple_of(3) {
        frames.push(read(0x2051, 1 + (tick / 3 % 13) as u8));
    }
    frames
}

/// The greatest value of each sub-index that was read.
fn greatest(frames: impl Iterator<Item = Frame>) -> BTreeMap<u8, u16> {
    let mut greatest = BTreeMap::new();
    for frame in frames.filter(|frame| frame.raw_id() == (0x581, false)) {
        let [command, low, high, sub, a, b, ..] = frame.bytes();
        assert_eq!(
            (command, low, high),
            (0x4B, 0x51, 0x20),
            "two bytes of 2051h"
        );
        let most = greatest.entry(sub).or_default();
        *most = u16::from_le_bytes([a, b]).max(*most);
    }
    greatest
}

/// One lost word at a time, and all other counters empty.
fn expected() -> BTreeMap<u8, u16> {
    (1..=13).map(|sub| (sub, u16::from(sub == 1))).collect()
}

#[test]
fn one_invalid_word_in_four_shows_in_the_counters_and_is_no_fault() {
    let plant = BoardPlantOptions::realistic(5);
    let options = Options {
        plant,
        faults: chatter(),
        ..Options::for_ms(DURATION_MS)
    };
    let emulated = run_master(options, reading);
    assert_eq!(faults(&emulated), []);
    let frames = sent(&emulated).into_iter().map(|sent| sent.frame);
    assert_eq!(greatest(frames), expected());
}

#[test]
fn one_invalid_word_in_four_shows_in_the_counters_natively_too() {
    let plant = BoardPlantOptions::realistic(5);
    let mut board = NativeBoard::new(&plant).with_faults(chatter());
    (0..DURATION_MS / 4).for_each(|tick| board.tick(&reading(tick)));
    assert_eq!(board.frames.iter().find_map(fault), None);
    assert_eq!(greatest(board.frames.into_iter()), expected());
}
