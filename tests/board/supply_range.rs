//! The supplies that the defaults are for: reversals at the full rate are no over-current.

use board_tests::frames::{faults, write};
use board_tests::master::{driven, steps};
use board_tests::program::run_master;
use firmware::faults::Fault as Reported;
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::Options;

/// The first fault of a shaft that reverses in motion, four times a second.
fn first_fault(volts: f64, over_current_ma: Option<u32>) -> Option<u16> {
    let options = Options {
        faults: vec![Planned::at_ms(0, Fault::Supply { volts })],
        ..Options::for_ms(3_000)
    };
    let finished = run_master(options, |tick| match (tick, over_current_ma) {
        (25, Some(limit_ma)) => vec![write(0x2100, 8, limit_ma, 4)],
        _ => driven(tick, steps(tick, 60_000, 60)),
    });
    faults(&finished)
        .first()
        .map(|(_, number)| u16::from(*number))
}

#[test]
fn the_shaft_reverses_in_motion_with_every_supply_of_the_range() {
    // Four cells that are nearly empty, a BEC of 5 V, five charged cells as they may read.
    for volts in [4.4, 5.0, 7.25, 7.58] {
        assert_eq!(first_fault(volts, None), None, "{volts} V");
    }
    // The limit for 6.3 V does not suffice.
    let over_current = Reported::OverCurrent.number();
    assert_eq!(first_fault(7.25, Some(1_600)), Some(over_current));
}
