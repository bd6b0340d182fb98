//! The application on the PC and the ELF on the emulated board do the same, bit for bit.

use board_tests::frames::{BoardFrame, Frame, order};
use board_tests::native::Native;
use board_tests::runs::run_schedule;
use virtual_board::plant::BoardPlantOptions;
use virtual_board::run::Options;

const SECONDS: u64 = 60;
const TICKS: u64 = SECONDS * 250;

/// Steps, ramps, a sine, the servo's end stops, quick stops, and a bridge that is off now and then.
fn mixed(tick: u64) -> Option<Frame> {
    let seconds = tick as f64 / 250.0;
    let deg = match tick / 1250 % 6 {
        0 => f64::from((tick / 125 % 3) as i32 - 1) * 30.0,
        1 => 20.0 * (2.0 * std::f64::consts::PI * 0.7 * seconds).sin(),
        2 => (seconds % 5.0) * 12.0 - 30.0,
        3 => 2.0 * (2.0 * std::f64::consts::PI * 5.0 * seconds).sin(),
        4 => {
            if (tick / 50).is_multiple_of(2) {
                60.0
            } else {
                -60.0
            }
        }
        _ => 0.3,
    };
    let order = match tick % 3000 {
        30 => order::ENABLE,
        1400 => order::QUICK_STOP,
        1500 => order::ACKNOWLEDGE,
        1510 | 2210 => order::ENABLE,
        2200 => order::DISABLE,
        _ => order::NONE,
    };
    let is_due = order != order::NONE || tick.is_multiple_of(5);
    (tick >= 30 && is_due).then(|| Frame::command((deg * 1000.0) as i32, order))
}

#[test]
fn a_minute_of_mixed_inputs_is_the_same_natively_and_on_the_emulated_board() {
    let rig = BoardPlantOptions::realistic(7);
    let options = Options {
        rig,
        ..Options::for_ms(SECONDS * 1000 + 20)
    };
    let emulated = run_schedule(options, mixed);
    let mut native = Native::new(&rig);
    (0..TICKS).for_each(|tick| native.tick(mixed(tick).as_ref()));

    let rows = &emulated.trace.rows;
    assert!(rows.len() as u64 >= 4 * TICKS);
    native.plant.assert_same(rows);
    let sent: Vec<Frame> = (emulated.trace.frames.iter())
        .filter(|sent| sent.sender == 0)
        .map(|sent| Frame::from_the_wire(&sent.frame))
        .collect();
    let expected = native.telemetry.as_flattened();
    assert!(sent.len() >= expected.len());
    for (index, (expected, found)) in expected.iter().zip(&sent).enumerate() {
        assert_eq!(found, expected, "frame {} of tick {}", index % 3, index / 3);
    }
    let driven = rows
        .iter()
        .filter(|row| matches!(row.bridge, virtual_board::plant::Bridge::Driven { .. }));
    assert!(driven.count() > rows.len() / 4, "it hardly moved");
}
