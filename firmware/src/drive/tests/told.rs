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
fn lost_frames_are_told_once_until_none_are_lost_any_more() {
    let mut bench = Bench::new();
    bench.heard.clear();
    for lost in [1, 2, 3, 3, 3, 4] {
        bench.device.drive.diagnostics.receive_overflows = lost;
        bench.step();
    }
    let told = bench.emergencies();
    assert_eq!(told, [(0x8110, 0), (0, 0), (0x8110, 0)]);
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
