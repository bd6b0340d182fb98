//! The device on the PC and the ELF on the emulated board give bit-exactly the same signals and
//! frames.

use std::collections::BTreeMap;

use board_tests::frames::{Frame, read, sent, start, write_real};
use board_tests::master::{PERIODS, TICK_RATE_HZ};
use board_tests::native::NativeBoard;
use board_tests::program::run_master;
use board_tests::workloads::command;
use virtual_board::board::ChipKind;
use virtual_board::plant::{BoardPlantOptions, Bridge};
use virtual_board::run::Options;

/// Commands at 50 Hz, with SDO requests between them.
fn mixed(tick: u64) -> Vec<Frame> {
    if tick < 30 {
        return if tick == 20 {
            vec![start()]
        } else {
            Vec::new()
        };
    }
    match tick % 25 {
        // An object that does not exist, a gain and its default.
        3 => vec![write_real(0x60F6, 1, 1.0)],
        8 if tick.is_multiple_of(3) => vec![write_real(0x60FB, 1, 7.5)],
        8 => vec![write_real(0x60FB, 1, 8.0)],
        // A string, which is uploaded in segments: the next request aborts it.
        13 => vec![read(0x6064, 0), read(0x1008, 0)],
        14 => vec![read(0x5555, 0)],
        18 => vec![read(0x1001, 0), read(0x2050, 1)],
        _ if tick.is_multiple_of(5) => command(tick),
        _ => Vec::new(),
    }
}

/// Runs the workload natively and on the emulated board with this chip, and asserts that the plant
/// was the same in every update period; returns the frames of both.
fn assert_same_plant(chip: ChipKind, seconds: u64) -> [Vec<Frame>; 2] {
    let plant = BoardPlantOptions::realistic(11);
    // The PWM starts after the program's CRC, and with the other chip after the calibration of its
    // converters.
    let start_ms = match chip {
        ChipKind::F427 => 20,
        ChipKind::H743 => 25,
    };
    let options = Options {
        chip,
        plant,
        ..Options::for_ms(seconds * 1000 + start_ms)
    };
    let emulated = run_master(options, mixed);
    let mut native = NativeBoard::new(&plant);
    let ticks = seconds * u64::from(TICK_RATE_HZ);
    (0..ticks).for_each(|tick| native.tick(&mixed(tick)));

    let rows = &emulated.trace.rows;
    println!("{chip:?}: the first PWM edge at {} ns", rows[0].at_ns);
    assert!(rows.len() as u64 >= PERIODS * ticks);
    native.assert_same(rows);
    let driven = rows
        .iter()
        .filter(|row| matches!(row.bridge, Bridge::Driven { .. }));
    assert!(driven.count() > rows.len() / 4, "the bridge is mostly off");
    let angles = rows.iter().map(|row| row.angle_deg);
    let (least, most) = angles.fold((0.0_f64, 0.0_f64), |(a, b), deg| (a.min(deg), b.max(deg)));
    assert!(least < -25.0 && most > 50.0, "{least} to {most} deg");
    let found: Vec<Frame> = sent(&emulated).iter().map(|sent| sent.frame).collect();
    // Twice 250 Hz and once 50 Hz of telemetry, and the responses to the SDO requests.
    let telemetry = (2 * 250 + 50) * seconds as usize;
    assert!(found.len() > telemetry, "{}", found.len());
    // Frames of the last calls may not have ended yet.
    assert!(found.len().abs_diff(native.frames.len()) < 20);
    [native.frames, found]
}

#[test]
fn a_minute_of_all_modes_is_the_same_natively_and_on_the_emulated_board() {
    let [native, emulated] = assert_same_plant(ChipKind::F427, 60);
    for (number, (expected, found)) in native.iter().zip(&emulated).enumerate() {
        assert_eq!(expected, found, "frame {number}");
    }
}

/// This chip transmits from one buffer: an answer may overtake process data that waits, but no
/// frame one of its own identifier.
#[test]
fn all_modes_are_the_same_on_the_emulated_board_with_the_other_chip() {
    let frames = assert_same_plant(ChipKind::H743, 20);
    let [native, emulated] = frames.map(|frames| {
        let mut by_id: BTreeMap<_, Vec<Frame>> = BTreeMap::new();
        for frame in frames {
            by_id.entry(frame.raw_id()).or_default().push(frame);
        }
        by_id
    });
    assert!(native.keys().eq(emulated.keys()));
    for (id, expected) in &native {
        for (number, (expected, found)) in expected.iter().zip(&emulated[id]).enumerate() {
            assert_eq!(expected, found, "{id:x?}, frame {number}");
        }
    }
}
