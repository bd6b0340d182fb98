//! When the bridge drives: after a command of this control period, and not after a trip.

use crate::mocks::Timer;
use drivers::bridge::{Bridge, Command, Compare, HBridge};
use model_core::control::{pwm_timer::Modulator, units::percent};

/// Whether the switches are driven after the next edge.
fn is_driven(bridge: &mut HBridge<Timer>) -> bool {
    bridge.begin_pwm_period();
    bridge.timer().are_on
}

#[test]
fn a_command_acts_from_the_next_edge_on_and_off_at_once() {
    let mut bridge = HBridge::new(Timer::default());
    let mut modulator = Modulator::default();
    let driven = [5.0, -5.0].map(|duty| Command::Driven(modulator.next(percent(duty))));
    for command in driven.into_iter().chain([Command::Brake]) {
        bridge.command(command);
        assert!(!bridge.timer().are_on);
        assert!(is_driven(&mut bridge));
        assert_eq!(bridge.timer().compare, Some(Compare::of(command)));
        bridge.off();
        assert!(!bridge.timer().are_on);
        assert!(!is_driven(&mut bridge));
    }
    bridge.command(Command::Coast);
    assert!(!is_driven(&mut bridge));
}

#[test]
fn a_control_period_without_a_command_ends_with_open_switches() {
    let mut bridge = HBridge::new(Timer::default());
    bridge.brake();
    bridge.begin_control_period();
    assert!(is_driven(&mut bridge));
    bridge.begin_control_period();
    assert!(!is_driven(&mut bridge));
}

#[test]
fn a_trip_opens_the_switches_until_it_is_taken() {
    let mut bridge = HBridge::new(Timer::default());
    bridge.brake();
    assert!(is_driven(&mut bridge));
    bridge.timer().trip();
    assert!(!is_driven(&mut bridge));
    assert!(bridge.take_trip());
    assert!(!bridge.take_trip());
    assert!(is_driven(&mut bridge));
}
