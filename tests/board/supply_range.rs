//! The supplies that the defaults are for: the shaft reverses in motion without a fault.

use board_tests::frames::faults;
use board_tests::master::{driven, steps};
use board_tests::program::run_master;
use virtual_board::faults::{Fault, Planned};
use virtual_board::run::Options;

#[test]
fn the_shaft_reverses_in_motion_with_every_supply_of_the_range() {
    // Four cells that are nearly empty; a BEC of 5 V; five charged cells, and these with the
    // greatest error of the measurement.
    for volts in [4.4, 5.0, 7.25, 7.58] {
        let options = Options {
            faults: vec![Planned::at_ms(0, Fault::Supply { volts })],
            ..Options::for_ms(2_000)
        };
        let finished = run_master(options, |tick| driven(tick, steps(tick, 60_000, 60)));
        assert_eq!(faults(&finished), [], "{volts} V");
        // Half of the rate at which the back-EMF, 20 mV per deg/s, is the supply.
        let rates = finished.trace.rows.iter().map(|row| row.rate_deg_s);
        let range = rates.fold((0.0, 0.0), |(low, high): (f64, f64), rate| {
            (low.min(rate), high.max(rate))
        });
        let least = 0.5 * volts / 0.020;
        assert!(range.0 < -least && range.1 > least, "{volts} V: {range:?}");
    }
}
