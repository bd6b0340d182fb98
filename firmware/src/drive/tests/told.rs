//! What the network is told without having asked.

use super::*;
use crate::application::BusState;

#[test]
fn an_error_passive_bus_is_told_once_however_often_the_node_has_its_turn() {
    let mut bench = Bench::new();
    bench.heard.clear();
    for _ in 0..5 {
        bench.step_with(|samples| samples.bus = BusState::Passive);
        bench.device.communicate(bench.now_us + 1000);
        bench.listen();
    }
    assert_eq!(bench.emergencies(), [(0x8120, 0)]);
}

#[test]
fn lost_frames_are_told_once_until_none_are_lost_for_a_second() {
    let mut bench = Bench::new();
    bench.heard.clear();
    for lost in [1, 2, 2, 3, 3, 3, 4] {
        bench.device.drive.diagnostics.receive_overflows = lost;
        bench.step();
    }
    assert_eq!(bench.emergencies(), [(0x8110, 0)]);
    bench.steps(249);
    assert_eq!(bench.emergencies().len(), 1);
    bench.steps(2);
    assert_eq!(bench.emergencies(), [(0x8110, 0), (0, 0)]);
    bench.device.drive.diagnostics.receive_overflows = 5;
    bench.step();
    assert_eq!(bench.emergencies().len(), 3, "and again");
}

/// From error passive to bus-off and back.
const FALL: [BusState; 5] = [
    BusState::Passive,
    BusState::Passive,
    BusState::Off,
    BusState::Off,
    BusState::Active,
];

#[test]
fn each_loss_of_the_bus_is_told_and_all_of_it_is_gone_a_second_later() {
    let mut bench = Bench::new();
    for _ in 0..2 {
        bench.heard.clear();
        for state in FALL {
            bench.step_with(|samples| samples.bus = state);
        }
        assert_eq!(bench.emergencies(), [(0x8120, 0), (0x8140, 0)]);
        assert_eq!(bench.get(0x1001, 0) & 0x10, 0x10, "communication");
        bench.heard.clear();
        bench.steps(260);
        let over = bench.emergencies();
        assert_eq!(over, [(0, 0), (0, 0)]);
        assert_eq!(bench.get(0x1001, 0), 0);
    }
}

#[test]
fn trouble_that_lasts_is_told_anew_after_a_reset_of_the_node() {
    let mut bench = Bench::new();
    let passive = |samples: &mut Samples| samples.bus = BusState::Passive;
    bench.step_with(passive);
    bench.send(0, &[0x81, 0]);
    bench.heard.clear();
    bench.step_with(passive);
    bench.step_with(passive);
    assert_eq!(bench.emergencies(), [(0x8120, 0)]);
}

#[test]
fn a_watchdog_reset_is_told_although_the_node_begins_with_a_reset_of_its_own() {
    let start = Start {
        watchdog: true,
        ..Start::default()
    };
    let mut bench = Bench::after(start);
    bench.steps(20);
    let told = bench.emergencies();
    let instance = 0x80 | crate::faults::Fault::WatchdogReset.number() as u8;
    assert!(told.contains(&(0x6010, instance)), "{told:x?}");
}
