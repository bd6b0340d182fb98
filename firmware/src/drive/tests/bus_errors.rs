//! Messages that the device sends unasked: bus errors and the cause of the last reset.

use super::*;
use crate::application::BusState;
use crate::faults::Fault;

#[test]
fn an_error_passive_bus_is_reported_once() {
    let mut bench = Bench::new();
    bench.received.clear();
    for _ in 0..5 {
        bench.step_with(|samples| samples.bus = BusState::Passive);
        bench.actuator.communicate(bench.now_us + 1000);
        bench.listen();
    }
    assert_eq!(bench.emergencies(), [(0x8120, 0)]);
}

#[test]
fn lost_frames_are_reported_once_until_none_is_lost_for_a_second() {
    let mut bench = Bench::new();
    bench.received.clear();
    for lost in [1, 2, 2, 3, 3, 3, 4] {
        bench.actuator.device.drive.diagnostics.receive_overflows = lost;
        bench.step();
    }
    assert_eq!(bench.emergencies(), [(0x8110, 0)]);
    bench.steps(249);
    assert_eq!(bench.emergencies().len(), 1);
    bench.steps(2);
    assert_eq!(bench.emergencies(), [(0x8110, 0), (0, 0)]);
    bench.actuator.device.drive.diagnostics.receive_overflows = 5;
    bench.step();
    assert_eq!(bench.emergencies().len(), 3, "reported again");
}

/// From error passive to bus-off and back.
const BUS_FAILURE: [BusState; 5] = [
    BusState::Passive,
    BusState::Passive,
    BusState::Off,
    BusState::Off,
    BusState::Active,
];

#[test]
fn each_bus_off_is_reported_and_recovers_after_a_second() {
    let mut bench = Bench::new();
    for _ in 0..2 {
        bench.received.clear();
        for state in BUS_FAILURE {
            bench.step_with(|samples| samples.bus = state);
        }
        assert_eq!(bench.emergencies(), [(0x8120, 0), (0x8140, 0)]);
        assert_eq!(bench.get(0x1001, 0) & 0x10, 0x10, "communication");
        bench.received.clear();
        bench.steps(260);
        let over = bench.emergencies();
        assert_eq!(over, [(0, 0), (0, 0)]);
        assert_eq!(bench.get(0x1001, 0), 0);
    }
}

#[test]
fn active_bus_errors_are_reported_again_after_a_reset_of_the_node() {
    let mut bench = Bench::new();
    let passive = |samples: &mut Samples| samples.bus = BusState::Passive;
    bench.step_with(passive);
    bench.send(0, &[0x81, 0]);
    bench.received.clear();
    bench.step_with(passive);
    bench.step_with(passive);
    assert_eq!(bench.emergencies(), [(0x8120, 0)]);
}

#[test]
fn a_fault_that_persists_is_reported_again_after_a_reset_of_the_node() {
    let mut bench = Bench::new();
    bench.enable();
    let without_encoder = |samples: &mut Samples| samples.encoder = None;
    for _ in 0..2 {
        for _ in 0..100 {
            bench.step_with(without_encoder);
        }
        let emergencies = bench.emergencies();
        let instance = 0x80 | Fault::EncoderInvalid.number() as u8;
        assert!(
            emergencies.iter().any(|it| it.1 == instance),
            "{emergencies:x?}"
        );
        bench.send(0, &[0x81, 0]);
        bench.received.clear();
    }
}

#[test]
fn a_watchdog_reset_is_reported_after_the_first_reset_of_the_node() {
    let start = Start {
        watchdog: true,
        ..Start::default()
    };
    let mut bench = Bench::after(start);
    bench.steps(20);
    let emergencies = bench.emergencies();
    let instance = 0x80 | Fault::WatchdogReset.number() as u8;
    assert!(
        emergencies.contains(&(0x6010, instance)),
        "{emergencies:x?}"
    );
}

#[test]
fn only_a_corrupt_program_remains_a_fault_after_a_reset_of_the_node() {
    let start = Start {
        program_corrupt: true,
        data_corrupt: true,
        ..Start::default()
    };
    let mut bench = Bench::after(start);
    for is_first in [true, false] {
        bench.steps(20);
        let latched = bench.actuator.device.drive.outputs().telemetry.latched;
        assert!(latched.contains(Fault::ProgramCorrupt));
        assert_eq!(latched.contains(Fault::DataCorrupt), is_first);
        let instance = 0x80 | Fault::ProgramCorrupt.number() as u8;
        let emergencies = bench.emergencies();
        assert!(
            emergencies.iter().any(|it| it.1 == instance),
            "{emergencies:x?}"
        );
        bench.received.clear();
        bench.send(0, &[0x81, 0]);
    }
}
