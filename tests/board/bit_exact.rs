//! The device on the PC and the ELF on the emulated board give bit-exactly the same signals and
//! frames.

use board_tests::frames::{Frame, read, sent, start, write_real};
use board_tests::native::NativeBoard;
use board_tests::program::run_master;
use board_tests::workloads::command;
use model_core::time::{CONTROL_RATE_HZ, PWM_PERIODS_PER_CONTROL_PERIOD};
use virtual_board::plant::{BoardPlantOptions, Bridge};
use virtual_board::run::Options;

const SECONDS: u64 = 60;
const TICKS: u64 = SECONDS * CONTROL_RATE_HZ as u64;

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

#[test]
fn a_minute_of_all_modes_is_the_same_natively_and_on_the_emulated_board() {
    let plant = BoardPlantOptions::realistic(11);
    let options = Options {
        plant,
        ..Options::for_ms(SECONDS * 1000 + 20)
    };
    let emulated = run_master(options, mixed);
    let mut native = NativeBoard::new(&plant);
    (0..TICKS).for_each(|tick| native.tick(&mixed(tick)));

    let rows = &emulated.trace.rows;
    assert!(rows.len() as u64 >= u64::from(PWM_PERIODS_PER_CONTROL_PERIOD) * TICKS);
    native.assert_same(rows);
    let found: Vec<Frame> = sent(&emulated).iter().map(|sent| sent.frame).collect();
    for (number, (expected, found)) in native.frames.iter().zip(&found).enumerate() {
        assert_eq!(expected, found, "frame {number}");
    }
    // Twice 250 Hz and once 50 Hz of telemetry, and the responses to the SDO requests.
    let telemetry = (2 * 250 + 50) * SECONDS as usize;
    assert!(found.len() > telemetry, "{}", found.len());
    // Frames of the last calls may not have ended yet.
    assert!(found.len().abs_diff(native.frames.len()) < 20);
    let driven = rows
        .iter()
        .filter(|row| matches!(row.bridge, Bridge::Driven { .. }));
    assert!(driven.count() > rows.len() / 4, "the bridge is mostly off");
    let angles = rows.iter().map(|row| row.angle_deg);
    let (least, most) = angles.fold((0.0_f64, 0.0_f64), |(a, b), deg| (a.min(deg), b.max(deg)));
    assert!(least < -25.0 && most > 50.0, "{least} to {most} deg");
}
