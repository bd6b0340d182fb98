//! The counters of the protections, object 2051h.

use super::*;
use crate::{
    dictionary::{DICTIONARY, Location, location},
    protection::Counter,
};
use std::format;

const OBJECT: u16 = 0x2051;

fn counters(bench: &mut Bench) -> Vec<u32> {
    (1..=13).map(|sub| bench.get(OBJECT, sub)).collect()
}

#[test]
fn each_sub_index_is_the_counter_of_its_name_with_the_value_reported_last() {
    let mut buffer = [0; 10];
    let mut drive = Drive::new(StoredParameters::DEFAULT, &mut buffer);
    let mut outputs = *drive.outputs();
    // Two values of each: the last ones count.
    for tick in 1..=26 {
        outputs.telemetry.tick = tick;
        outputs.telemetry.counter = 100 + tick as u16;
        drive.observe(&outputs);
    }
    let entries = DICTIONARY.entries().iter();
    let entries: Vec<_> = entries
        .filter(|entry| entry.address().index == OBJECT && entry.address().sub > 0)
        .collect();
    assert_eq!(entries.len(), Counter::ALL.len());
    for (entry, counter) in entries.into_iter().zip(Counter::ALL) {
        let Location::Measured(value) = location(entry) else {
            panic!("{entry:?}");
        };
        assert_eq!(format!("{value:?}"), format!("{counter:?}Counter"));
        let tick = (14..=26).find(|tick| Counter::of_tick(*tick) == counter);
        let expected = 100 + u64::from(tick.expect("each has its tick"));
        assert_eq!(drive.measured(value), expected, "{counter:?}");
    }
}

#[test]
fn encoder_words_of_which_one_in_four_is_missing_show_a_counter_and_no_fault() {
    let mut bench = Bench::enabled(8);
    assert_eq!(counters(&mut bench), [0; 13]);
    let mut most = [0; 13];
    for period in 0..400 {
        bench.step_with(|samples| {
            if period % 4 == 0 {
                samples.encoder = None;
            }
        });
        let found = bench.actuator.device.drive.counters;
        most = core::array::from_fn(|at| found[at].max(most[at]));
    }
    assert_eq!(most, core::array::from_fn(|at| u16::from(at == 0)));
    assert_eq!(bench.get(0x2050, 10), 0, "no fault");
    // All valid: the counter is empty 52 ms later.
    bench.steps(13);
    assert_eq!(counters(&mut bench), [0; 13]);
}

#[test]
fn a_reset_of_the_node_clears_the_counters() {
    let mut bench = Bench::new();
    for _ in 0..20 {
        bench.step_with(|samples| samples.encoder = None);
    }
    assert_eq!(bench.get(OBJECT, 1), 4, "one more than is tolerated");
    bench.actuator.device.drive.power_on();
    assert_eq!(bench.actuator.device.drive.counters, [0; 13]);
}
