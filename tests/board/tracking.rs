//! Objects 2013h and 2014h on the board: a ramp that is followed, and a rest without duty, with a
//! magnet off its axis.

use board_tests::frames::{Frame, control, faults, start, write};
use board_tests::native::NativeBoard;
use board_tests::program::run_master;
use virtual_board::plant::{BoardPlantOptions, Bridge};
use virtual_board::run::Options;

const DURATION_MS: u64 = 6_000;

/// Sine of the error of the encoder once a turn, the tolerance of the AS5045, and twice: 1.4 deg at
/// 40 deg.
const ONCE_MDEG: u32 = 1400;
const TWICE_MDEG: u32 = 500;

/// The ramp, and the last tick of it.
const RAMP: core::ops::Range<u64> = 150..350;

/// A target in each control period: 50 deg/s from 0 to 40 deg, where the shaft stays.
fn ramp(tick: u64) -> Vec<Frame> {
    let target_mdeg = |tick: u64| 200 * (tick.clamp(RAMP.start, RAMP.end) - RAMP.start) as i32;
    match tick {
        20 => vec![start()],
        22 => vec![write(0x6060, 0, 8, 1)],
        24 => vec![write(0x60C2, 1, 4, 1)],
        26 => vec![write(0x2013, 1, 1000, 2)],
        28 => vec![write(0x2013, 2, 1000, 2)],
        30 => vec![write(0x2013, 3, 132, 2)],
        32 => vec![write(0x2014, 2, ONCE_MDEG, 2)],
        34 => vec![write(0x2014, 4, TWICE_MDEG, 2)],
        40 => vec![control(0x06, 0)],
        42 => vec![control(0x07, 0)],
        44.. => vec![control(0x0f, target_mdeg(tick))],
        _ => Vec::new(),
    }
}

#[test]
fn a_ramp_is_followed_and_a_shaft_at_rest_gets_no_duty_natively_and_on_the_emulated_board() {
    let mut plant = BoardPlantOptions::realistic(5);
    plant.encoder.misalignment_first_deg = f64::from(ONCE_MDEG) * 1e-3;
    plant.encoder.misalignment_second_deg = f64::from(TWICE_MDEG) * 1e-3;
    let options = Options {
        plant,
        ..Options::for_ms(DURATION_MS)
    };
    let emulated = run_master(options, ramp);
    assert_eq!(faults(&emulated), []);
    let mut native = NativeBoard::new(&plant);
    (0..DURATION_MS / 4).for_each(|tick| native.tick(&ramp(tick)));
    let rows = &emulated.trace.rows;
    native.assert_same(rows);

    let within = |ticks: core::ops::Range<u64>| {
        let is_within = move |at_ns: u64| ticks.contains(&(at_ns / 4_000_000));
        rows.iter().filter(move |row| is_within(row.at_ns))
    };
    // The second half of the ramp. The loop of the paper lags by 50 deg/s over its gain of 8,
    // 6.25 deg; what is left is the way of five control periods, 1 deg, in which the command
    // arrives and the duty acts.
    for row in within(250..RAMP.end) {
        let target_deg = (row.at_ns as f64 / 4e6 - RAMP.start as f64) * 0.2;
        let lag_deg = target_deg - row.angle_deg;
        assert!(lag_deg.abs() < 1.0, "{lag_deg} deg at {} ns", row.at_ns);
    }
    // The shaft creeps into the band by the integral of the rate loop, within 4 s, and settles.
    let mut last = within(1440..1490).map(|row| row.bridge).peekable();
    assert!(last.peek().is_some());
    // The dead band and a count.
    let rest_deg = rows.last().expect("a trace").angle_deg;
    assert!((rest_deg - 40.0).abs() < 0.132 + 0.088, "{rest_deg} deg");
    assert!(last.all(|bridge| !matches!(bridge, Bridge::Driven { on_cycles: 1.., .. })));
}
