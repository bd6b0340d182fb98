//! Node and drive on the PC and the ELF on the emulated board do the same, bit for bit and frame for frame.

use board_tests::canopen::{NativeNode, control, read, run_master, seen, start, target, write};
use board_tests::frames::Frame;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

const SECONDS: u64 = 60;
const TICKS: u64 = SECONDS * 250;

/// What the drive is to do, by controlwords and targets: each mode for ten seconds, with quick stops, halts, and the
/// power off now and then.
pub fn command(tick: u64) -> Vec<Frame> {
    let seconds = tick as f64 / 250.0;
    let mode = [8, 1, 3, 9, 8, 1][(tick / 2500 % 6) as usize];
    let within = tick % 2500;
    let deg = match tick / 625 % 4 {
        0 => f64::from((tick / 125 % 3) as i32 - 1) * 30.0,
        1 => 20.0 * (2.0 * std::f64::consts::PI * 0.7 * seconds).sin(),
        2 => (seconds % 2.5) * 20.0 - 25.0,
        _ => 70.0,
    };
    let mdeg = (deg * 1000.0) as i32;
    let word = match within {
        0..12 => 0x06,
        12..14 => 0x07,
        // A new set-point each time, as profile position takes it.
        _ if tick % 50 < 25 => 0x1f,
        _ => 0x0f,
    };
    let word = match within {
        1200..1260 => 0x02,
        1260..1290 => 0x06,
        1290..1300 => 0x07,
        1700..1750 => word | 0x100,
        2000..2020 => 0x00,
        2020..2030 => 0x06,
        2030..2040 => 0x07,
        _ => word,
    };
    vec![control(word, mdeg), target(mdeg, mode)]
}

/// Commands at 50 Hz, with SDOs, SYNC and frames for others between them.
fn mixed(tick: u64) -> Vec<Frame> {
    if tick < 30 {
        return if tick == 20 {
            vec![start()]
        } else {
            Vec::new()
        };
    }
    match tick % 25 {
        // A setting of the controller and back, an abort, and one that is not there.
        3 => vec![write(0x60F6, 1, 1_f32.to_bits(), 4)],
        8 if tick.is_multiple_of(3) => vec![write(0x60FB, 1, 7.5_f32.to_bits(), 4)],
        8 => vec![write(0x60FB, 1, 8_f32.to_bits(), 4)],
        13 => vec![read(0x6064, 0), read(0x1008, 0)],
        // The first segment of the string that was asked for, then an unknown command.
        14 => vec![read(0x5555, 0)],
        18 => vec![read(0x1001, 0), read(0x2050, 1)],
        _ if tick.is_multiple_of(5) => command(tick),
        _ => Vec::new(),
    }
}

#[test]
fn a_minute_of_all_modes_is_the_same_natively_and_on_the_emulated_board() {
    let rig = BoardPlantOptions::realistic(11);
    let options = Options {
        rig,
        ..Options::for_ms(SECONDS * 1000 + 20)
    };
    let emulated = run_master(options, mixed);
    let mut native = NativeNode::new(&rig);
    (0..TICKS).for_each(|tick| native.tick(&mixed(tick)));

    let rows = &emulated.trace.rows;
    assert!(rows.len() as u64 >= 4 * TICKS);
    native.plant.assert_same(rows);
    let found: Vec<Frame> = seen(&emulated).iter().map(|seen| seen.frame).collect();
    for (number, (expected, found)) in native.frames.iter().zip(&found).enumerate() {
        assert_eq!(expected, found, "frame {number}");
    }
    // Twice 250 Hz and once 50 Hz of telemetry, and the answers to the SDOs.
    assert!(
        found.len() as u64 > 2 * TICKS + TICKS / 5,
        "{}",
        found.len()
    );
    // What the last turns sent may be on its way yet.
    assert!(found.len().abs_diff(native.frames.len()) < 20);
    let moved = rows.iter().map(|row| row.angle_deg);
    let (least, most) = moved.fold((0.0_f64, 0.0_f64), |(a, b), deg| (a.min(deg), b.max(deg)));
    assert!(least < -25.0 && most > 50.0, "{least} to {most} deg");
}
